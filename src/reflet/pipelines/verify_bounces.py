"""The check that playback follows mirrored rays as the ray tracer does."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float32

from reflet.envmap.env_map import EnvMap
from reflet.pem.pem import ParameterizedEnvironmentMap
from reflet.render.playback.layouts import Shown
from reflet.render.playback.renderer import ALL_SHOWN, Renderer
from reflet.render.playback.visibility import rasterized_visibility
from reflet.scene.roughness import TRACED_ROUGHNESS, is_rough
from reflet.scene.surfaces.surface import gbuffer_from_visibility
from reflet.scene.views.camera import Camera
from reflet.scene.views.parameter_space import Axis, ParameterSpace
from reflet.trace.followed import RayFollower

LEAST_SHARE = 0.999  # of rays that meet anything: at edges of triangles roundings decide
FEW = 2  # rays that may always differ, where there are not a thousand
# Of light and throughput, at the 99.5th of 100 rays: normal maps and grazing angles magnify roundings, and each mirror
# magnifies them again.
TOLERANCE = 1e-3
PERCENTILE = 99.5
LEAST_REFLECTANCE = np.float32(1e-3)  # of first surfaces that are compared
LEAST_SHOWN = 0.1  # of the white that distant light is here: what arrives of less has met many mirrors


@dataclass(frozen=True)
class Bounces:
    """Mirrored rays as drawn and as traced: of ``rays`` that meet mirrors or what stands beside them, the
    ``equal_share`` meets the same triangles, the first four one by one, after up to ``most_hits``, or parts by chance
    where something is blended; what they send of their own, and the share of distant light that arrives, differ by
    ``difference``, relative, but for the worst 0.5 %. Rays whose first surface is of glass, and those that meet a rough
    one, are left out of the latter."""

    rays: int
    most_hits: int
    equal_share: float
    difference: float

    @property
    def agrees(self) -> bool:
        strays = round((1.0 - self.equal_share) * self.rays)
        return strays <= (1.0 - LEAST_SHARE) * self.rays + FEW and self.difference <= TOLERANCE

    def __str__(self) -> str:
        if not self.rays:
            return "No mirrored ray of this view meets a mirror again."
        return (
            f"Of {self.rays} mirrored rays that meet mirrors again, up to {self.most_hits} times, "
            f"{self.equal_share:.2%} meet the ray tracer's triangles (at least {LEAST_SHARE:.1%} must); light and "
            f"reflectance on their ways differ by {self.difference:.1e} (allowed {TOLERANCE:.0e}) but for the worst "
            "0.5%."
        )


def verify_bounces(
    pem: ParameterizedEnvironmentMap,
    camera: Camera,
    *,
    variant: str = "llvm_ad_rgb",
) -> Bounces:
    """Compares the middle ray of every pixel. Each shell in turn would show the same: distant light is white here, and
    how it is looked up is the same from wherever a ray leaves (`verify`)."""
    renderer = Renderer(white(pem))
    gbuffer = gbuffer_from_visibility(pem.scene, rasterized_visibility(renderer, camera, 1))
    lookups = gbuffer.lookups[0]
    follower = RayFollower(pem.scene, pem.irradiance, pem.traced_parts, variant=variant)
    ways = follower.follow(camera.position, lookups.position[0], lookups.direction[0], gbuffer.triangle, pem.most_hits)
    pixels = gbuffer.row_pixel[gbuffer.row_of_sample]
    drawn = renderer.met_triangles(camera, 1, 0).reshape(-1, 4)[pixels]
    # Rays of rough surfaces are followed up to a limit, and compared up to the first that they meet.
    followed = gbuffer.roughness <= TRACED_ROUGHNESS
    rough = np.append(
        False, np.repeat([is_rough(part) for part in pem.scene.parts], np.diff(pem.scene.triangle_offsets))
    )
    met_before = np.cumsum(rough[ways.triangles], axis=1)
    beyond, rough_met = met_before - rough[ways.triangles] > 0, met_before[:, -1] > 0
    rough_met |= rough.any() & (ways.triangles[:, -1] > 0)  # those that are met later are not told
    ways = replace(ways, triangles=np.where(beyond | ~followed[:, None], 0, ways.triangles))
    drawn = np.where(beyond, 0, drawn)
    meets = (ways.triangles > 0).any(1) | (drawn > 0).any(1)
    # What is blended is met at random, by other numbers here and there: rays may part where either meets it.
    blended = np.repeat([part.material.cutoff < 0.0 for part in pem.scene.parts], np.diff(pem.scene.triangle_offsets))
    blended = np.append(False, blended)
    parting = np.argmax(drawn != ways.triangles, axis=1)[:, None]
    chance = [blended[np.take_along_axis(met, parting, 1)[:, 0]] for met in (drawn, ways.triangles)]
    same = (drawn == ways.triangles).all(1)
    equal = same | chance[0] | chance[1]

    def shown(layers: frozenset[Shown]) -> Float32[np.ndarray, "rays 3"]:
        return renderer.frame(camera, samples=1, what="object", layers=layers).reshape(-1, 4)[pixels, :3]

    # The first surface's own light and reflectance are divided out: its pictures are decoded by the driver.
    dark, own, everything = shown(ALL_SHOWN - {"distant", "local"}), shown(ALL_SHOWN - {"distant"}), shown(ALL_SHOWN)
    reflectance = shown(ALL_SHOWN - {"local"}) - dark
    light, throughput = (of / np.maximum(reflectance, LEAST_REFLECTANCE) for of in (own - dark, everything - own))
    # what comes through glass, and by two lobes, is no single ray's
    several = np.array([part.material.refraction is not None or part.is_coated for part in pem.scene.parts])
    compared = (
        meets
        & same
        & ~rough_met
        & ~several[gbuffer.row_part[gbuffer.row_of_sample]]
        & (reflectance > LEAST_REFLECTANCE).all(1)
    )
    wrong = np.maximum(np.abs(light - ways.light), np.abs(throughput - ways.throughput)).max(1)
    relative = wrong / np.maximum((ways.light + ways.throughput).max(1), LEAST_SHOWN)
    return Bounces(
        rays=int(meets.sum()),
        most_hits=pem.most_hits,
        equal_share=float(equal[meets].mean()) if meets.any() else 1.0,
        difference=float(np.percentile(relative[compared], PERCENTILE)) if compared.any() else 0.0,
    )


def white(pem: ParameterizedEnvironmentMap) -> ParameterizedEnvironmentMap:
    """The PEM whose last shells are white, and nearer ones empty."""
    layers = tuple(pem.layers[index] for index in pem.distant_layers)
    base = tuple(
        EnvMap(
            layer.chain,
            np.full((layer.chain.texel_count, layer.channels), float(layer.channels == 3), np.float32),
            layer.geometry,
        )
        for layer in layers
    )
    space = ParameterSpace((Axis("azimuth_deg", ()),), pem.space.orbit)
    return replace(pem, space=space, layers=layers, maps=[], base=base)
