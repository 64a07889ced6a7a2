"""Segmented layers: closed forms, invariances, and Mitsuba's path integrator on the same rays."""

import numpy as np
import pytest
from trace_scenes import CHROME, camera, constant_light, no_irradiance, quad, room, scene, sphere

from reflet.scene.material import CLAMPS, Material, Texture
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.scene import Part, Scene
from reflet.trace import segmentation
from reflet.trace.camera_rays import CameraRays
from reflet.trace.compose import compose, object_coverage
from reflet.trace.device_scene import DeviceScene
from reflet.trace.layers import SegmentedLayers, Shells
from reflet.trace.references.path_reference import PathReference
from reflet.trace.tracer import Tracer
from reflet.trace.variant import use_variant


def layers_of(what: Scene, size: int = 48, spp: int = 16, **more: object) -> SegmentedLayers:
    tracer = Tracer(what, irradiance=no_irradiance(what))
    return tracer.view(camera(size=size, **more), spp=spp, surroundings=True).layers  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def furnace() -> SegmentedLayers:
    return layers_of(scene([Part("ball", sphere(), CHROME, True)], [(0,)], constant_light(1.7)))


def test_mirror_sphere_in_a_constant_environment_sees_it_everywhere(furnace: SegmentedLayers) -> None:
    # float32 interpolation between equal values, nothing else
    np.testing.assert_allclose(furnace.distant, 1.7, rtol=1e-6)
    assert not furnace.local.any() and not furnace.alpha.any() and not furnace.diffuse.any()
    np.testing.assert_allclose(furnace.combined, 1.7 * furnace.fresnel, rtol=1e-5)


def test_fresnel_of_a_sphere_is_schlicks(furnace: SegmentedLayers) -> None:
    view, inside = furnace.camera, furnace.coverage == 1.0
    corner, dx, dy = view.ray_basis()
    y, x = np.divmod(furnace.pixel[inside], view.width)
    d = corner + (x + 0.5)[:, None] * dx + (y + 0.5)[:, None] * dy
    d /= np.linalg.norm(d, axis=-1, keepdims=True)
    eye = np.asarray(view.position)
    b = d @ eye
    hit = eye + (-b - np.sqrt(np.maximum(b * b - eye @ eye + 1.0, 0.0)))[:, None] * d
    cosine = -(hit * d).sum(-1)
    away = cosine > 0.4  # nearer the rim F bends too much within a pixel for its centre to stand for it
    expected = 0.65 + 0.35 * (1.0 - cosine) ** 5
    # the mean over a pixel against its centre: F'' · (pixel)²/24 stays below 3e-3 where the cosine exceeds 0.4
    np.testing.assert_allclose(furnace.fresnel[inside, 0][away], expected[away], atol=3e-3)
    assert away.sum() > 200


def test_coverage_and_surroundings_share_the_pixel(furnace: SegmentedLayers) -> None:
    share = object_coverage(furnace)
    # surroundings are the environment's radiance times what the object leaves free
    np.testing.assert_allclose(furnace.surroundings[..., 0], 1.7 * (1.0 - share), atol=1e-5)
    # a sphere of radius 1 at distance d subtends π·tan²(asin(1/d)) of the plane at distance 1
    distance = np.linalg.norm(furnace.camera.position)
    pixel_size = 2.0 * np.tan(np.radians(18.0)) / 48
    disc = np.pi * np.tan(np.arcsin(1.0 / distance)) ** 2 / pixel_size**2
    # 48 rows leave 0.2 % of a circle's area out; 16 samples a pixel on the rim add less than that
    assert share.sum() == pytest.approx(disc, rel=5e-3)


def test_grouping_parts_changes_the_layers_but_not_the_picture() -> None:
    parts = [Part("a", sphere((-1.1, 0, 0)), CHROME, True), Part("b", sphere((1.1, 0, 0)), CHROME, True)]
    walls = Part("room", room(3.0), Material("glow", base_color=(0, 0, 0), metallic=0.0, emission=(0.3, 0.9, 2.0)))
    one = layers_of(scene([*parts, walls], [(0, 1)]), position=(0, 1.0, 2.8))
    two = layers_of(scene([*parts, walls], [(0,), (1,)]), position=(0, 1.0, 2.8))
    np.testing.assert_array_equal(one.pixel, two.pixel)
    np.testing.assert_array_equal(one.part, two.part)
    # the same rays, but other kernels: rounding in the last bits, seldom an edge that turns the other way
    np.testing.assert_allclose(compose(one), compose(two), atol=2e-3)
    assert one.alpha.max() == 1.0 and not two.alpha.any()
    # through the whole object, or of it all, nothing but the walls is seen
    np.testing.assert_allclose(one.distant, np.tile([[0.3, 0.9, 2.0]], (len(one.pixel), 1)), rtol=1e-5)
    assert (two.distant < 0.99 * one.distant).any()
    assert (two.distant <= one.distant * (1 + 1e-5)).all(), "a mirror of 0.65 cannot brighten an even room"


def test_rows_are_ordered_and_parts_of_a_pixel_apart() -> None:
    parts = [Part("a", sphere((-0.9, 0, 0)), CHROME, True), Part("b", sphere((0.9, 0, 0)), CHROME, True)]
    layers = layers_of(scene(parts, [(0, 1)], constant_light(1.0)), position=(0.35, 0.4, 4.0))
    key = layers.pixel.astype(np.int64) * 2 + layers.part
    assert (np.diff(key) > 0).all()
    assert (np.bincount(layers.pixel) == 2).any()
    assert object_coverage(layers).max() <= 1.0 + 1e-6


def emitting_room_with_mirrors() -> Scene:
    """Deterministic light: a room whose walls only emit, a picture on them, and mirrors of two objects."""
    rng = np.random.default_rng(1)
    pixels = np.full((8, 8, 4), 255, np.uint8)
    pixels[..., :3] = rng.integers(30, 255, (8, 8, 3))
    walls = Material(
        "walls", base_color=(0, 0, 0), metallic=0.0, emission=(1.0, 0.8, 0.6), emission_texture_srgb=Texture(pixels)
    )
    tinted = Material("gold", (0.9, 0.7, 0.3), 1.0, 0.0, base_color_texture_srgb=Texture(pixels, CLAMPS))
    back = quad((-1.5, -1.2, -1.0), (3.0, 0, 0), (0, 2.4, 0.3))
    return scene(
        [
            Part("room", room(3.0), walls),
            Part("left", sphere((-0.7, 0, 0), 0.6), CHROME, True),
            Part("right", sphere((0.7, 0, 0), 0.6), CHROME, True),
            Part("panel", back, tinted, True),
        ],
        [(1, 2), (3,)],
    )


def test_layers_recombine_to_the_path_integrator_ray_by_ray() -> None:
    what = emitting_room_with_mirrors()
    tracer = Tracer(what, irradiance=no_irradiance(what))
    view = camera((0.3, 0.5, 2.8), size=40)
    picture = compose(tracer.view(view, spp=16, surroundings=True).layers)
    *_, directions = CameraRays(view, 16, 0).antialiased(np.arange(1600, dtype=np.int32))
    along = np.stack([axis.numpy() for axis in directions], -1)
    origin = np.tile(np.asarray(view.position, np.float32), (len(along), 1))
    # the first segment, eight mirrored ones behind the first mirror, and the emitter at the end
    expected = PathReference(what).along(origin, along, max_depth=10).reshape(1600, 16, 3).mean(1)
    error = np.abs(picture.reshape(-1, 3) - expected).max(-1)
    # Rays that graze an edge, or mirrors that curve and magnify float32 rounding bounce by bounce, differ: few may.
    assert np.quantile(error, 0.98) < 2e-3
    assert error.mean() < 2e-3
    assert picture.std() > 0.1


def test_backs_of_single_sided_faces_are_black_and_opaque() -> None:
    # A mirror bowl, fronts outside, open towards the camera: only its inside is seen.
    ball = sphere(rows=24)
    kept = ball.positions[ball.triangles].mean(1)[:, 2] < 0.0
    bowl = Mesh(ball.positions, ball.normals, ball.triangles[kept])
    seen = layers_of(scene([Part("bowl", bowl, CHROME, True)], [(0,)], constant_light(1.0)), position=(0, 0.01, 4.0))
    assert not len(seen.pixel)
    assert not seen.surroundings[24, 24].any()
    assert seen.surroundings[0, 0].min() == pytest.approx(1.0)

    # A mirror in front of it, part of the same object: what it mirrors of the bowl's inside is local, opaque, black.
    mirror = quad((-0.4, -0.4, 2.0), (0, 0.8, 0), (0.8, 0, 0))
    parts = [Part("bowl", bowl, CHROME, True), Part("mirror", mirror, CHROME, True)]
    own = layers_of(scene(parts, [(0, 1)], constant_light(1.0)), position=(0.0, 0.01, 0.5), target=(0, 0, 2.0))
    on_mirror = own.part == 1
    assert own.alpha[on_mirror].max() == 1.0
    assert not own.local[on_mirror].any()
    np.testing.assert_allclose(own.distant[on_mirror], 1.0, rtol=1e-6)


@pytest.mark.parametrize("roughness", [0.0, 1.0])
def test_double_sided_faces_mirror_on_both_sides(roughness: float) -> None:
    plate = quad((-1, -1, 0), (2, 0, 0), (0, 2, 0))
    both = Material("foil", (0.5, 0.5, 0.5), 1.0, roughness, double_sided=True)
    what = scene([Part("plate", plate, both, True)], [(0,)], constant_light(2.0))
    front, back = layers_of(what), layers_of(what, position=(0.0, 0.4, -4.0))
    assert len(front.pixel) == pytest.approx(len(back.pixel), rel=0.02)
    np.testing.assert_allclose(back.distant, 2.0, rtol=1e-6)


def test_textures_give_metal_and_base_colour_their_place() -> None:
    """Left half of the plate is metal of a known sRGB colour, right half a white dielectric that glows."""
    color = np.full((1, 2, 4), 255, np.uint8)
    color[0, 0, :3] = (188, 188, 188)  # 0.5 in linear light
    metal = np.zeros((1, 2, 4), np.uint8)
    metal[0, 0, 2] = 255
    material = Material(
        "half", base_color_texture_srgb=Texture(color, CLAMPS), metallic_roughness_texture=Texture(metal, CLAMPS),
        emission=(0.0, 0.25, 0.0),
    )  # fmt: skip
    plate = quad((-1, -1, 0), (2, 0, 0), (0, 2, 0))
    layers = layers_of(
        scene([Part("plate", plate, material, True)], [(0,)], constant_light(1.0)), position=(0, 1e-3, 4)
    )
    x, y = layers.pixel % 48, layers.pixel // 48
    middle = abs(y - 23.5) < 4
    left, right = middle & (abs(x - 9.5) < 2), middle & (abs(x - 37.5) < 2)
    half = ((188 / 255 + 0.055) / 1.055) ** 2.4
    # seen within 13° of the normal, where Schlick's fifth power adds less than 1e-6
    np.testing.assert_allclose(layers.fresnel[left], half, atol=1e-5)
    np.testing.assert_allclose(layers.fresnel[right], 0.04, atol=1e-5)
    np.testing.assert_allclose(layers.diffuse[right], np.tile([[0.0, 0.25, 0.0]], (right.sum(), 1)), atol=1e-6)


def test_many_parts_give_the_same_rows_as_few(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where an object has many parts their sums are taken for few pixels at a time."""
    balls = [Part(f"ball {k}", sphere(radius=0.3, centre=(0.6 * k - 0.9, 0.0, 0.0)), CHROME, True) for k in range(4)]
    use_variant()
    device = DeviceScene(scene(balls, [(0, 1, 2, 3)], constant_light(1.0)))
    whole = segmentation.segmented_layers(device, camera(), 4, 0, True, [Shells((0.0, 0.0, 0.0), (1.0,))])
    monkeypatch.setattr(segmentation, "MANY_PARTS", 0)
    monkeypatch.setattr(segmentation, "FEW_PIXELS", 7)
    pieces = segmentation.segmented_layers(device, camera(), 4, 0, True, [Shells((0.0, 0.0, 0.0), (1.0,))])
    assert len(np.unique(whole.part)) == 4
    for name, values in vars(whole).items():
        if isinstance(values, np.ndarray):
            np.testing.assert_array_equal(getattr(pieces, name), values, err_msg=name)


def test_through_mirrors_is_as_if_they_were_one_object() -> None:
    """Where rays pass through every object, how parts are grouped changes no layer, and nothing distant mirrors."""
    parts = [
        Part("ball", sphere((-0.6, 0.0, 0.0), 0.5), CHROME, True),
        Part("other", sphere((0.6, 0.1, -0.2), 0.5), CHROME, True),
        Part(
            "wall", quad((-2.0, -2.0, -1.5), (4.0, 0.0, 0.0), (0.0, 4.0, 0.0)), Material("w", emission=(0.4, 0.2, 0.1))
        ),
    ]
    apart, one = (scene(parts, groups, constant_light(1.0)) for groups in ([(0,), (1,)], [(0, 1)]))
    views = [
        Tracer(what, irradiance=no_irradiance(what), through=through).view(camera(), spp=16).layers
        for what, through in ((apart, (0, 1)), (one, (0, 1)), (one, ()), (apart, ()))
    ]
    for other in views[1:3]:
        for name in ("pixel", "part", "distant", "local", "alpha", "combined", "shells"):
            np.testing.assert_array_equal(getattr(views[0], name), getattr(other, name))
    mirrors_mirrors = (views[0].alpha > 0.5) & (views[3].alpha == 0.0)
    assert mirrors_mirrors.sum() > 20  # what is local to all is distant to each


def test_companions_are_local() -> None:
    """Distant is what lies behind what rays go through, and what that sends of its own is all local."""
    glow = (0.4, 0.2, 0.1)
    mirror = Part("ball", sphere((-0.6, 0.0, 0.0), 0.5), CHROME, True)
    lamp = Part("lamp", sphere((0.6, 0.1, -0.2), 0.5), Material("lamp", emission=glow))
    both = scene([mirror, lamp], [(0,)], constant_light(1.0))
    traced = Tracer(both, irradiance=no_irradiance(both), through=(0, 1))
    layers = traced.view(camera(), spp=16).layers
    np.testing.assert_allclose(layers.distant, 1.0, rtol=1e-6)  # the sky, behind the lamp too
    np.testing.assert_allclose(layers.local, layers.alpha[:, None] * np.float32(glow), rtol=1e-5)
    assert (layers.alpha > 0.5).sum() > 10 and layers.alpha.max() == 1.0
    probe = traced.probe(0, Shells((-0.6, 0.0, 0.0)), size=8, spp=4)
    np.testing.assert_allclose(probe.texels, 1.0, rtol=1e-6)
    assert not np.isfinite(probe.distance).any()
