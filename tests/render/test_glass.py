"""Glass in playback: two greedy paths a sample, beside closed forms and Mitsuba."""

from dataclasses import replace

import numpy as np
import pytest
from scenes import MIRROR, flat_sky, mesh, quad, sphere, traced_pem
from test_traced import camera, moved

from reflet.reflectance.brdfs.fresnel import fresnel_dielectric
from reflet.render.playback.renderer import Renderer
from reflet.scene.material import Material, Refraction
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.meshes.primitives import torus_mesh
from reflet.scene.scene import Part
from reflet.scene.views.camera import Camera

GLASS = Material("glass", (1.0, 1.0, 1.0), 0.0, 0.0, refraction=Refraction(1.5))
SKY = np.array([0.7, 0.5, 0.3])


def waves(d: np.ndarray) -> np.ndarray:
    """Radiance that differs in every direction, smoothly."""
    return 1.0 + 0.5 * d + 0.4 * np.sin(3.0 * np.roll(d, 1, axis=-1))


def view_rays(view: Camera) -> np.ndarray:
    corner, dx, dy = view.ray_basis()
    y, x = np.indices((view.height, view.width)) + 0.5
    ray = corner + x[..., None] * dx + y[..., None] * dy
    return ray / np.linalg.norm(ray, axis=-1, keepdims=True)


def test_a_glass_sphere_shows_its_two_paths() -> None:
    """≥ 40 dB of the closed form; all that is reflected inside is taken to show what goes through."""
    pem = traced_pem(Part("ball", sphere(96, 192, 0.6), GLASS, True), sky=waves, size=128, lod_bias=-20.0)
    view = camera((0.4, 0.9, 2.0), (0.0, 0.0, 0.0), 96)
    shown = Renderer(pem).frame(view, samples=1, what="object")
    d, eye = view_rays(view), np.array(view.position)
    b = d @ eye
    root = b * b - eye @ eye + 0.36
    normal = (eye + (-b - np.sqrt(np.maximum(root, 0.0)))[..., None] * d) / 0.6
    inside = (root > 0.0) & (shown[..., 3] > 0.0)
    d, normal, shown = d[inside], normal[inside], shown[inside][:, :3]
    cosine = -(normal * d).sum(-1)
    i = np.arccos(cosine)
    t = np.arcsin(np.sin(i) / 1.5)
    f = fresnel_dielectric(cosine, 1.5)[:, None]
    across = (-normal - cosine[:, None] * d) / np.maximum(np.sin(i), 1e-9)[:, None]

    def light(turned: np.ndarray) -> np.ndarray:
        return waves(np.cos(turned)[:, None] * d + np.sin(turned)[:, None] * across)

    mirrored = f * light(2.0 * i - np.pi)
    two_paths = mirrored + (1.0 - f) * light(2.0 * (i - t))
    every_path = mirrored + sum((1.0 - f) ** 2 * f**k * light(2.0 * (i - t) + k * (np.pi - 2.0 * t)) for k in range(20))

    def psnr(expected: np.ndarray) -> float:
        return float(10.0 * np.log10(expected.max() ** 2 / ((shown - expected) ** 2).mean()))

    assert len(d) > 1500
    assert psnr(two_paths) > 50.0  # 55 dB: all but the outermost ring of triangles is better than 65
    # What the two paths leave out; taking it away instead of showing it where the rest goes costs 6 dB more.
    assert psnr(every_path) > 25.5


def test_clear_glass_under_an_even_sky_is_not_seen() -> None:
    """Nothing is lost by what is left out; rays that are still inside after the last hit see the sky, too."""
    parts = (
        Part("ring", torus_mesh(0.6, 0.25, around=48, sides=24), GLASS, True),
        Part("ball", moved(sphere(24, 48, 0.2), (0.0, 0.3, 0.0)), replace(GLASS, refraction=Refraction(1.9)), True),
        Part("pane", quad(np.array([(-1, -1, -1), (1, -1, -1), (1, 1, -1), (-1, 1, -1)])),
             replace(GLASS, refraction=Refraction(1.5, thin=True)), True),
    )  # fmt: skip
    shown = Renderer(traced_pem(*parts)).frame(camera((0.3, 1.2, 1.6), (0, 0, 0)), samples=1, what="object")
    covered = shown[..., 3] > 0.0
    assert covered.sum() > 2000
    np.testing.assert_allclose(shown[covered][:, :3], np.tile(SKY, (covered.sum(), 1)), rtol=1e-3)


def slab(thickness: float, half: float = 30.0) -> Mesh:
    """A plate about the origin, its faces towards ±z."""
    z = thickness / 2.0
    front = quad(np.array([(-half, -half, z), (half, -half, z), (half, half, z), (-half, half, z)]))
    back = quad(np.array([(half, -half, -z), (-half, -half, -z), (-half, half, -z), (half, half, -z)]))
    return mesh(
        np.concatenate([front.positions, back.positions]),
        np.concatenate([front.normals, back.normals]),
        np.concatenate([front.triangles, back.triangles + np.uint32(4)]),
    )


def test_a_plate_is_seen_through_in_the_same_direction_and_attenuated() -> None:
    """exp(-absorption·way), the way slanted by Snell's law."""
    kind = Refraction(1.5, attenuation_color=(0.5, 0.9, 1.0), attenuation_distance=0.2)
    plate = Part("plate", slab(0.4), replace(GLASS, base_color=(1.0, 0.5, 1.0), refraction=kind), True)
    pem = traced_pem(plate, sky=waves, size=128, lod_bias=-20.0)
    view = camera((0.0, 0.0, 4.0), (1.5, 0.5, 0.0))
    shown = Renderer(pem).frame(view, samples=1, what="object")
    d = view_rays(view)
    cosine = -d[..., 2]
    f = fresnel_dielectric(cosine, 1.5)[..., None]
    way = 0.4 / np.sqrt(1.0 - (1.0 - cosine**2) / 1.5**2)
    kept = np.array([0.5, 0.9, 1.0]) ** (way[..., None] / 0.2) * np.array([1.0, 0.25, 1.0])
    expected = f * waves(d * (1, 1, -1)) + (1.0 - f) * kept * waves(d)
    assert (shown[..., 3] == 1.0).all()
    np.testing.assert_allclose(shown[..., :3], expected, atol=3e-3)  # texels of half floats, bilinear


def test_a_plate_moves_what_is_behind_it_by_snells_law() -> None:
    """A glowing strip behind it: its edge is where the ray that leaves the back face meets it."""
    plate = Part("plate", slab(0.5, 9.0), GLASS, True)
    strip = quad(np.array([(0.0, -3, -1), (9.0, -3, -1), (9.0, 3, -1), (0.0, 3, -1)], float))
    glow = replace(MIRROR, base_color=(0.0, 0.0, 0.0), emission=(50.0, 50.0, 50.0))
    pem = traced_pem(plate, Part("strip", strip, glow, True))
    view = camera((-2.0, 0.0, 2.0), (0.0, 0.0, 0.0), 128)
    shown = Renderer(pem).frame(view, samples=1, what="object")[..., 0] > 10.0
    d, eye = view_rays(view), np.array(view.position)
    inner = d / 1.5
    inner[..., 2] = -np.sqrt(1.0 - inner[..., 0] ** 2 - inner[..., 1] ** 2)
    x = eye[0] + d[..., 0] / -d[..., 2] * (1.75 + 0.75) + inner[..., 0] / -inner[..., 2] * 0.5
    straight = eye[0] + d[..., 0] / -d[..., 2] * 3.0
    assert ((straight > 0.0) != (x > 0.0)).sum() > 200
    assert (shown == (x > 0.0)).mean() > 0.9998  # rays start off their surfaces by 1e-5 of the plate's size


def test_glass_on_the_hull_is_gone_through() -> None:
    """Whatever says that its fronts cannot meet the object: its inside does."""
    pem = traced_pem(Part("ball", sphere(24, 48, 0.6), GLASS, True))
    assert not pem.on_hull.any()
    view = camera((0.4, 0.9, 2.0), (0.0, 0.0, 0.0))
    plain, flagged = (
        Renderer(replace(pem, on_hull=flags)).frame(view, samples=1, what="object")
        for flags in (pem.on_hull, ~pem.on_hull)
    )
    np.testing.assert_array_equal(plain, flagged)


def test_a_prism_reflects_totally() -> None:
    """Looked at square to one short face, light comes from square to the other, by the long one, without loss."""
    a, b, c = np.array([(-1, -1, 0), (1, -1, 0), (-1, 1, 0)], float)  # the right angle at a
    up = np.array([0.0, 0.0, 40.0])
    faces = [quad(np.array([p - up, p + up, q + up, q - up])) for p, q in ((b, a), (c, b), (a, c))]
    outwards = [(0, -1, 0), (1, 1, 0), (-1, 0, 0)]
    for face, out in zip(faces, outwards, strict=True):
        assert face.normals[0] @ out > 0.99
    prism = mesh(
        np.concatenate([face.positions for face in faces]),
        np.concatenate([face.normals for face in faces]),
        np.concatenate([face.triangles + np.uint32(4 * k) for k, face in enumerate(faces)]),
    )
    pem = traced_pem(Part("prism", prism, GLASS, True), sky=waves, size=128, lod_bias=-20.0)
    renderer, view = Renderer(pem), camera((-60.0, 0.0, 0.0), (0.0, 0.0, 0.0), 256)
    shown = renderer.frame(view, samples=1, what="object")
    seen = shown[..., 3] > 0.0
    # in along +x, on along -y; a degree off the normal Snell bends by less than a degree
    expected = 0.04 * waves(np.array([-1.0, 0, 0])) + 0.96 * waves(np.array([0.0, -1.0, 0]))
    near = seen & (np.abs(np.indices(seen.shape)[1] - 127.5) < 3)
    assert near.sum() > 20
    np.testing.assert_allclose(shown[near][:, :3], np.tile(expected, (near.sum(), 1)), atol=0.02)


@pytest.mark.parametrize("distance", [3.0, -3.0])
def test_a_thin_sheet_lets_light_straight_through(distance: float) -> None:
    """From either side: 2R/(1 + R) is reflected, the rest tinted once."""
    kind = replace(GLASS, base_color=(0.2, 0.5, 1.0), refraction=Refraction(1.5, transmission=0.75, thin=True))
    sheet = quad(np.array([(-30, -30, 0), (30, -30, 0), (30, 30, 0), (-30, 30, 0)], float))
    kind = replace(kind, emission=(0.0, 0.25, 0.0))
    pem = traced_pem(Part("sheet", sheet, kind, True), sky=waves, size=128, lod_bias=-20.0)
    view = camera((0.0, 0.0, distance), (0.7, 0.3, 0.0))
    shown = Renderer(pem).frame(view, samples=1, what="object")
    d = view_rays(view)
    once = fresnel_dielectric(np.abs(d[..., 2]), 1.5)[..., None]
    f = 2.0 * once / (1.0 + once)
    through = (1.0 - f) * 0.75 * np.array([0.2, 0.5, 1.0]) * waves(d)
    expected = f * waves(d * (1, 1, -1)) + through + (0.0, 0.25, 0.0)
    np.testing.assert_allclose(shown[..., :3], expected, atol=3e-3)


def test_glass_is_met_by_mirrored_rays_and_meets_mirrors() -> None:
    """A mirror floor under a pane: it is seen through the pane, and the pane in it, from beneath."""
    floor = quad(np.array([(-1, 0, 1), (1, 0, 1), (1, 0, -1), (-1, 0, -1)], float))
    pane = Part("pane", moved(floor, (0.0, 0.15, 0.0)), replace(GLASS, refraction=Refraction(1.5, thin=True)), True)
    renderer = Renderer(traced_pem(Part("floor", floor, MIRROR, True), pane, sky=flat_sky))
    view = camera((0.0, 0.8, 1.6), (0.0, 0.0, 0.0))
    shown = renderer.frame(view, samples=1, what="object")
    d = view_rays(view)
    eye = np.array(view.position)
    at_pane = eye + d * ((0.15 - eye[1]) / d[..., 1])[..., None]
    at_floor = eye + d * (-eye[1] / d[..., 1])[..., None]
    out = at_floor + d * (1, -1, 1) * (0.15 / -d[..., 1])[..., None]
    inside = [np.abs(p[..., ::2]).max(-1) < 0.98 for p in (at_pane, at_floor, out)]
    all_three = inside[0] & inside[1] & inside[2] & (d[..., 1] < 0)
    assert all_three.sum() > 200
    c = np.abs(d[..., 1])
    once = fresnel_dielectric(c, 1.5)
    pane_f, floor_f = 2 * once / (1 + once), 0.65 + 0.35 * (1 - c) ** 5
    # up through the pane the greedy path keeps all: what the pane sends back down comes from the same sky
    expected = (pane_f + (1 - pane_f) * floor_f)[..., None] * SKY
    np.testing.assert_allclose(shown[all_three][:, :3], expected[all_three], rtol=2e-3)


def test_refracted_neighbours_tell_the_level() -> None:
    """A ball shows its surroundings small: finer levels flicker, coarser ones blur."""

    def fine(d: np.ndarray) -> np.ndarray:
        return 1.0 + np.sin(24.0 * d + (0, 1, 2)) * np.sin(24.0 * np.roll(d, -1, axis=-1))

    ball = Part("ball", sphere(48, 96, 0.6), GLASS, True)
    pem = traced_pem(ball, sky=fine, size=128, sample_count=4)
    view = camera((0.4, 0.9, 2.0), (0.0, 0.0, 0.0), 48)
    truth = Renderer(replace(pem, lod_bias=-20.0)).frame(view, samples=64, what="object")

    def psnr(lod_bias: float) -> float:
        shown = Renderer(replace(pem, lod_bias=lod_bias)).frame(view, samples=4, what="object")
        return float(-10.0 * np.log10(np.mean((shown - truth)[truth[..., 3] == 1.0] ** 2)))

    finest, fitting, coarse = map(psnr, (-20.0, 0.0, 2.0))
    assert fitting > finest + 0.5  # 0.85 dB
    assert fitting > coarse + 5.0  # 9.6 dB
