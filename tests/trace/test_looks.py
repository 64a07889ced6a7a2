"""Colours of vertices, textures that lie and wrap each in its own way: closed forms, and Mitsuba on the same rays."""

from dataclasses import replace

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest
from trace_scenes import CHROME, camera, no_irradiance, quad, room, scene, sphere

from reflet.scene.material import Material, Texture
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.scene import Part
from reflet.trace.camera_rays import CameraRays
from reflet.trace.compose import compose
from reflet.trace.device_scene import DeviceScene
from reflet.trace.references.path_reference import PathReference
from reflet.trace.surface import surface_at
from reflet.trace.tracer import Tracer
from reflet.trace.variant import use_variant

RANDOM = np.random.default_rng(5)
TRIANGLE = Mesh(
    np.float32([[0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.tile(np.float32([0, 0, 1]), (3, 1)), np.uint32([[0, 1, 2]]),
    np.float32([[0, 0], [1, 0], [0, 1]]),
)  # fmt: skip


def facing_reflectance(part: Part, barycentrics: np.ndarray) -> np.ndarray:
    """A mirror's F along its normal, f0, at barycentrics of the second and third vertex."""
    use_variant("llvm_ad_rgb")
    device = DeviceScene(scene([part], [(0,)]))
    uv = mi.Point2f(*np.ascontiguousarray(barycentrics.T, np.float32))
    down = mi.Vector3f(0.0, 0.0, -1.0)
    surface = surface_at(device, dr.zeros(mi.UInt32, len(barycentrics)), uv, down, mi.Bool(True))
    return np.stack([channel.numpy() for channel in surface.fresnel], -1)


def test_a_triangle_of_three_colours_is_their_barycentric_mean() -> None:
    colors = np.float32([[1.0, 0.2, 0.0, 1.0], [0.0, 0.5, 1.0, 0.3], [0.5, 0.5, 0.25, 1.0]])
    gold = replace(CHROME, base_color=(0.9, 0.6, 0.3))
    at = np.array([[0.0, 0.0], [0.5, 0.5], [1 / 3, 1 / 3], [0.2, 0.7]])
    shown = facing_reflectance(Part("t", replace(TRIANGLE, colors=colors), gold, True), at)
    weights = np.column_stack([1.0 - at.sum(1), at])
    np.testing.assert_allclose(shown, weights @ colors[:, :3] * gold.base_color, atol=1e-6)  # float32


@pytest.mark.parametrize(
    ("wraps", "expected"),
    [
        (("repeat", "repeat"), (0.5, 0.5)),
        (("mirror", "clamp"), (0.75, 1.0)),
        (("clamp", "mirror"), (1.0, 0.75)),
    ],
)
def test_a_ramp_beyond_its_edge(wraps, expected) -> None:  # type: ignore[no-untyped-def]
    """Two texels, 0 and 1, along u in red and along v in green. Repeating, it is a half at its edge, between the last
    and the first; 3/8 beyond it clamped is 1 and mirrored as 3/8 before it, an eighth of the picture, a quarter of a
    texel, beyond its middle: 3/4."""
    pixels = np.zeros((2, 2, 4), np.uint8)
    pixels[:, 1, 0] = pixels[1, :, 1] = 255
    metal = np.full((1, 1, 4), 255, np.uint8)
    material = replace(
        CHROME, base_color=(1.0, 1.0, 1.0), metallic=1.0,
        base_color_texture_srgb=Texture(pixels, wraps, coordinates=2), metallic_roughness_texture=Texture(metal),
    )  # fmt: skip
    place = (1.0, 1.0) if wraps == ("repeat", "repeat") else (1.375, 1.375)
    lying = np.tile(np.float32(place), (3, 1))
    mesh = replace(TRIANGLE, more_uv=(np.zeros((3, 2), np.float32), lying))
    shown = facing_reflectance(Part("t", mesh, material, True), np.array([[0.25, 0.25]]))
    # the ends of the picture are codes 0 and 255, which are linear 0 and 1
    np.testing.assert_allclose(shown[0, :2], expected, atol=1e-5)


def test_whole_looks_recombine_to_the_path_integrator_ray_by_ray() -> None:
    """A room that only emits, its picture mirrored and clamped; a coloured panel by two sets of coordinates."""
    pixels = np.full((6, 8, 4), 255, np.uint8)
    pixels[..., :3] = RANDOM.integers(30, 255, (6, 8, 3))
    house = room(3.0)
    far = replace(house, more_uv=(house.uv * np.float32([2.5, 1.5]) - np.float32(0.7),))  # type: ignore[operator]
    walls = Material(
        "walls", (0, 0, 0), 0.0, emission=(1.0, 0.8, 0.6),
        emission_texture_srgb=Texture(pixels, ("mirror", "clamp"), coordinates=1),
    )  # fmt: skip
    panel = quad((-1.5, -1.2, -1.0), (3.0, 0, 0), (0, 2.4, 0.3))
    colors = np.float32([[1, 0.5, 0.2, 1], [0.2, 1, 1, 1], [0.5, 0.3, 0.9, 1], [1, 1, 1, 1]])
    panel = replace(panel, colors=colors, more_uv=(panel.uv * np.float32([3.0, -2.0]),))  # type: ignore[operator]
    tinted = Material(
        "gold", (0.9, 0.7, 0.3), 1.0, 0.0, base_color_texture_srgb=Texture(pixels, ("clamp", "repeat"), coordinates=1)
    )
    ball = sphere((-0.7, 0, 0), 0.6)
    shades = RANDOM.uniform(0.2, 1.0, (len(ball.positions), 4)).astype(np.float32)
    what = scene(
        [
            Part("room", far, walls),
            Part("ball", replace(ball, colors=shades), CHROME, True),
            Part("panel", panel, tinted, True),
        ],
        [(1,), (2,)],
    )
    view = camera((0.3, 0.5, 2.8), size=32)
    picture = compose(Tracer(what, irradiance=no_irradiance(what)).view(view, spp=16, surroundings=True).layers)
    *_, directions = CameraRays(view, 16, 0).antialiased(np.arange(1024, dtype=np.int32))
    along = np.stack([axis.numpy() for axis in directions], -1)
    origin = np.tile(np.asarray(view.position, np.float32), (len(along), 1))
    expected = PathReference(what).along(origin, along, max_depth=10).reshape(1024, 16, 3).mean(1)
    error = np.abs(picture.reshape(-1, 3) - expected).max(-1)
    # as in `test_layers`: grazing rays and curved mirrors magnify float32 rounding, for a few pixels
    assert np.quantile(error, 0.98) < 2e-3 and error.mean() < 2e-3
    assert picture.std() > 0.1
