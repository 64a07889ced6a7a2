"""What engines would show: the split sum with maps of constant light, and of what stands around."""

import numpy as np
import pytest
from trace_scenes import CHROME, camera, constant_light, no_irradiance, quad, scene, sphere

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.shapes import InfiniteSphere
from reflet.reflectance.materials.material import dfg_lookup, specular_albedo
from reflet.reflectance.prefilter.split_sum_map import SplitSumMap, split_sum_map
from reflet.scene.material import Material
from reflet.scene.scene import Part
from reflet.trace.tracer import Tracer

COLOR = (0.9, 0.6, 0.3)


def light(radiance: tuple[float, float, float]) -> SplitSumMap:
    return split_sum_map(EnvImage(CUBE, np.broadcast_to(np.float32(radiance), (6, 32, 32, 3))), InfiniteSphere())


@pytest.mark.parametrize("roughness", [0.1, 0.4, 1.0])
def test_constant_light_shows_the_directional_albedo(roughness: float) -> None:
    ball = Part("ball", sphere(rows=64), Material("gold", COLOR, 1.0, roughness), True)
    what = scene([ball], [(0,)], constant_light(1.0))
    view = camera((0.0, 0.0, 5.0), 32)
    seen = Tracer(what, irradiance=no_irradiance(what)).split_sum(view, [light((1.0, 1.0, 1.0))], sample_count=16)
    corner, dx, dy = view.ray_basis()
    y, x = np.mgrid[:32, :32] + 0.5
    ray = corner + x[..., None] * dx + y[..., None] * dy
    ray /= np.linalg.norm(ray, axis=-1, keepdims=True)
    eye = np.asarray(view.position)
    root = (ray @ eye) ** 2 - eye @ eye + 1.0
    cosine = np.sqrt(np.maximum(root, 0.0))
    inside = (root > 0.0) & (cosine > 0.6)  # nearer to the rim n·v changes within a pixel
    assert inside.sum() > 100
    wanted = specular_albedo(np.array(COLOR), dfg_lookup(cosine[inside], roughness))
    np.testing.assert_allclose(seen[inside], wanted, rtol=5e-3)  # facets, and n·v of a pixel's middle for its mean
    assert not seen[0].any()


def test_each_object_has_its_own_light_and_mirrors_show_it_by_schlick() -> None:
    facing = [quad((x, -1.0, 0.0), (1.0, 0, 0), (0, 2.0, 0)) for x in (-1.2, 0.2)]
    parts = [Part(f"plate {k}", mesh, CHROME, True) for k, mesh in enumerate(facing)]
    what = scene(parts, [(0,), (1,)], constant_light(0.0))
    view = camera((0.0, 0.0, 40.0), 16)
    shown = Tracer(what, irradiance=no_irradiance(what)).split_sum(
        view, [light((1.0, 0.0, 0.0)), light((0.0, 2.0, 0.0))], sample_count=4
    )
    left, right = (shown[:, half].reshape(-1, 3) for half in (slice(8), slice(8, 16)))
    for half, color in ((left, (0.65, 0.0, 0.0)), (right, (0.0, 1.3, 0.0))):  # along the normal F is f0
        seen = half[half.any(1)]
        assert len(seen)
        np.testing.assert_allclose(seen, np.broadcast_to(color, seen.shape), atol=1e-4)
