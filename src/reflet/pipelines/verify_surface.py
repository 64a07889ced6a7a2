"""The check that playback looks light on rough surfaces up as inference believed."""

from dataclasses import dataclass, replace

import numpy as np

from reflet.pem.pem import ParameterizedEnvironmentMap
from reflet.pipelines.verify_bounces import white
from reflet.render.playback.renderer import Renderer
from reflet.render.playback.visibility import rasterized_visibility
from reflet.scene.roughness import TRACED_ROUGHNESS
from reflet.scene.surfaces.surface import gbuffer_from_visibility
from reflet.scene.surfaces.surface_taps import seen_from, surface_taps
from reflet.scene.views.camera import Camera

TOLERANCE = 5e-3  # where texels beside one another differ by 1: directions and places in float32, half floats
LEAST_SHARE = 0.99  # of pixels: beside creases of normal maps, and on slivers, roundings decide


@dataclass(frozen=True)
class SurfaceLookups:
    """Of ``pixels`` that show light on surfaces the ``equal_share`` shows what the rendering matrix says."""

    pixels: int
    equal_share: float

    @property
    def agrees(self) -> bool:
        return self.equal_share >= LEAST_SHARE

    def __str__(self) -> str:
        if not self.pixels:
            return "No pixel of this view shows light on rough surfaces."
        return (
            f"Of {self.pixels} pixels of rough surfaces {self.equal_share:.2%} show what the rendering matrix of the "
            f"light on them says, to {TOLERANCE:.0e} (at least {LEAST_SHARE:.0%} must)."
        )


def verify_surface(pem: ParameterizedEnvironmentMap, camera: Camera) -> SurfaceLookups:
    """Compares the middles of all pixels, with random light in the place of what was inferred, over white distant
    light: L + 1 - alpha."""
    surface = pem.surface
    assert surface is not None
    random = np.random.default_rng(0).uniform((1, 1, 1, -1), (2, 2, 2, 1), surface.light.shape).astype(np.float16)
    coloured = replace(surface, light=random)
    renderer = Renderer(replace(white(pem), surface=coloured))
    gbuffer = gbuffer_from_visibility(pem.scene, rasterized_visibility(renderer, camera, 1))
    chosen = np.flatnonzero((surface.resolution[gbuffer.triangle] > 0) & (gbuffer.roughness > TRACED_ROUGHNESS))
    b, back = seen_from(pem.scene, gbuffer, camera.position)
    texels, weights = surface_taps(
        coloured, gbuffer.triangle[chosen], b[chosen], back[chosen], gbuffer.mirrored[chosen]
    )
    light = random.reshape(-1, 4).astype(np.float32)
    expected = np.einsum("nk,nkc->nc", weights, light[texels, :3] + 1.0 - light[texels, 3:])
    picture = renderer.frame(camera, samples=1, what="object", layers=("distant", "local"))
    shown = picture.reshape(-1, 4)[gbuffer.row_pixel[gbuffer.row_of_sample[chosen]], :3]
    equal = (np.abs(shown - expected) <= TOLERANCE).all(1)
    return SurfaceLookups(len(chosen), float(equal.mean()) if len(chosen) else 1.0)
