"""A glossy sphere by Mitsuba's path integrator: what the split sum is measured against."""

import mitsuba as mi
import numpy as np
from jaxtyping import Float, Float32

from reflet.reflectance.brdfs.dfg import SAMPLES, half_vector_samples
from reflet.reflectance.brdfs.ggx import v_smith_ggx
from reflet.scene.material import EnvironmentLight
from reflet.scene.views.camera import Camera
from reflet.trace.references.path_reference import environment_emitter, sensor
from reflet.trace.variant import use_variant

LANES = 1 << 18  # samples of a pass: they bound its memory


class GlossySphere:
    """A unit sphere at the origin under an environment light, of rough metal that absorbs nothing (F = 1).

    GGX as in `reflet.reflectance.brdfs.ggx`, but with masking and shadowing independent of each other, as Mitsuba has
    it. Light that bounces twice between microfacets is lost, so that rough spheres are darker than white: `albedo`.
    """

    def __init__(self, environment: EnvironmentLight, *, variant: str = "llvm_ad_rgb") -> None:
        use_variant(variant)
        self._environment = environment_emitter(environment.radiance)

    def picture(
        self, camera: Camera, alpha: float, *, spp: int, seed: int = 0
    ) -> Float32[np.ndarray, "height width 3"]:
        """Linear radiance with at least ``spp`` samples a pixel and box filter; behind the sphere all is black."""
        metal = {"type": "roughconductor", "distribution": "ggx", "alpha": alpha, "material": "none"}
        scene = mi.load_dict(
            {"type": "scene", "sphere": {"type": "sphere", "bsdf": metal}, "environment": self._environment}
        )
        integrator = mi.load_dict({"type": "path", "max_depth": 2, "hide_emitters": True})
        seen = mi.load_dict(sensor(camera, spp))
        passes = -(-spp * camera.width * camera.height // LANES)
        each = -(-spp // passes)
        total = np.zeros((camera.height, camera.width, 3))
        for number in range(passes):
            image = mi.render(scene, sensor=seen, integrator=integrator, spp=each, seed=seed * passes + number)
            total += np.asarray(image).reshape(total.shape)
        return (total / passes).astype(np.float32)


def albedo(n_dot_v: Float[np.ndarray, "views"], alpha: float) -> Float[np.ndarray, "views"]:
    """What `GlossySphere` reflects of constant light, for n·v in (0, 1].

    By the samples of `dfg`, weighted by the one visibility over the other: G1(l)·G1(v)/(4·n·l·n·v) is
    1/((n·l + r_l)·(n·v + r_v)), r² = α² + (1 - α²)·cos² [Walter07, eq. 34].
    """
    direction, _, weight = half_vector_samples(n_dot_v, alpha, SAMPLES)
    n_dot_l, view = np.maximum(direction[..., 1], 1e-9), np.broadcast_to(n_dot_v[:, None], weight.shape)
    square = alpha * alpha
    apart = 1.0
    for cosine in (n_dot_l, view):
        apart = apart / (cosine + np.sqrt(square + (1.0 - square) * cosine * cosine))
    return np.asarray((weight * apart / v_smith_ggx(n_dot_l, view, alpha)).mean(-1))
