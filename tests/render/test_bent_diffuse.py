"""Diffuse light where normal maps bend normals: what pictures show, in closed form."""

from dataclasses import replace

import numpy as np
import pytest
from scenes import MIRROR, pem_of, quad, random_map, scene_of

from reflet.envmap.geometry import InfiniteSphere
from reflet.render.playback.renderer import Renderer
from reflet.scene.material import Material, Texture
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.scene import Part
from reflet.scene.surfaces.irradiance import IrradianceMap
from reflet.scene.views.camera import Camera

NORMAL = np.array([160, 96, 230])  # a texel's
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def floor(x: float, bumpy: bool) -> Mesh:
    flat = quad(np.array([(x, 0, 0.4), (x + 0.4, 0, 0.4), (x + 0.4, 0, 0), (x, 0, 0)]), np.zeros((4, 2)))
    tangents = np.tile(np.float32([1.0, 0.0, 0.0, -1.0]), (4, 1))
    return replace(flat, tangents=tangents) if bumpy else flat


@pytest.mark.parametrize("double_sided", [False, True])
@pytest.mark.parametrize("exact", [True, False])
def test_a_bent_normal_shows_the_first_order_of_its_light(exact: bool, double_sided: bool) -> None:
    """Beside each other something that reflects and something that does not, with and without the map's tangents; from
    above, and the backs from below."""
    texture = Texture(np.uint8([[[*NORMAL, 255]]]))
    paint = Material("paint", (0.8, 0.6, 0.4), 0.0, 0.0, normal_texture=texture, normal_scale=0.7, specular=0.0,
                     double_sided=double_sided)  # fmt: skip
    parts = [Part(f"{k}", floor(0.5 * k - 1.0, k < 2), paint, k % 2 == 1) for k in range(3)]
    scene = scene_of(*parts, Part("mirror", floor(5.0, False), MIRROR, True))
    count, sides = scene.triangle_offsets[-1], 1 + double_sided
    random = np.random.default_rng(3)
    several = (random.uniform(low, high, (sides * count, 3)) for low, high in ((0.2, 1.0), (-0.5, 0.5)))
    light, gradient = (np.repeat(values, 3, 0).astype(np.float32) for values in several)
    colours = IrradianceMap(np.ones(count, np.uint32), 3 * sides * np.arange(count, dtype=np.uint32), light, gradient)
    pem = pem_of(scene, [random_map(4, 3, InfiniteSphere(), 0)], irradiance=colours)
    bend = 2.0 * NORMAL / 255.0 - 1.0
    bend = np.array([0.7 * bend[0], bend[2], 0.7 * bend[1]])
    for below in (False, True):
        view = Camera((0.0, -1.6 if below else 1.6, 0.9), (-0.2, 0.0, 0.2), fov_deg=50.0, width=96, height=96)
        shown = Renderer(pem).frame(view, samples=1, layers=("diffuse",), exact=exact)
        corner, dx, dy = view.ray_basis()
        y, x = np.indices((96, 96)) + 0.5
        ray = corner + x[..., None] * dx + y[..., None] * dy
        at = np.array(view.position) - view.position[1] / ray[..., 1:2] * ray
        for number in range(3):
            left = 0.5 * number - 1.0
            own = (at[..., 0] > left + 0.02) & (at[..., 0] < left + 0.38) & (at[..., 2] > 0.02) & (at[..., 2] < 0.38)
            # the diagonal runs from the first corner to the third
            across = (at[..., 0] - left) + (at[..., 2] - 0.0) - 0.4
            own &= np.abs(across) > 0.02
            assert own.sum() > 200
            triangle = 2 * number + (across < 0.0)
            place = colours.offset[triangle] + (3 if below and double_sided else 0)
            bent = bend / np.linalg.norm(bend) if number < 2 else np.array([0.0, 1.0, 0.0])
            change = (bent - (0.0, 1.0, 0.0)) * (-1.0 if below else 1.0)
            e, g = light[place], gradient[place]
            expected = np.array(paint.base_color) * e * np.maximum(1.0 + (g @ change) / (e @ LUMINANCE), 0.0)[..., None]
            if below and not double_sided:
                expected *= 0.0
            np.testing.assert_allclose(shown[own][:, :3], expected[own], atol=1e-5)
