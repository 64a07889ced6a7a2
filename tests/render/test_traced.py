"""Mirrors that see themselves, beside Mitsuba and closed forms."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from scenes import MIRROR, SKY, analytic_map, flat_sky, mesh, pem_of, quad, sphere, torus, traced_pem

from reflet.envmap.geometry import InfiniteSphere
from reflet.pem.pem import ParameterizedEnvironmentMap
from reflet.render.playback.layouts import Shown
from reflet.render.playback.renderer import Renderer
from reflet.render.playback.visibility import rasterized_visibility
from reflet.scene.bvh.build import build_bvh
from reflet.scene.bvh.bvh import corners_of
from reflet.scene.bvh.closest_hit import closest_hits
from reflet.scene.bvh.nodes import refitted
from reflet.scene.material import REPEATS, Material, Texture, Wrap
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.meshes.primitives import torus_mesh
from reflet.scene.scene import Part, ReflectiveObject, Scene
from reflet.scene.surfaces.hull import hull_triangles
from reflet.scene.surfaces.irradiance import IrradianceMap
from reflet.scene.surfaces.surface import gbuffer_from_visibility
from reflet.scene.views.camera import Camera
from reflet.shaders.link import link
from reflet.trace.followed import RayFollower


def camera(position: tuple[float, float, float], target: tuple[float, float, float], size: int = 64) -> Camera:
    return Camera(position, target, fov_deg=45.0, width=size, height=size)


def moved(shape: Mesh, by: tuple[float, float, float]) -> Mesh:
    return replace(shape, positions=(shape.positions + np.float32(by)).astype(np.float32))


def with_uv(shape: Mesh, uv: np.ndarray) -> Mesh:
    """Texture coordinates, and tangents that lie in the surface."""
    tangents = np.cross(shape.normals, [0.3, 1.0, 0.2])
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
    handed = np.where(np.arange(len(tangents)) % 2, -1.0, 1.0)
    return replace(shape, uv=uv.astype(np.float32), tangents=np.column_stack([tangents, handed]).astype(np.float32))


def dressed(mesh: Mesh, uv: np.ndarray) -> Mesh:
    """With further texture coordinates, and with colours."""
    first = with_uv(mesh, uv)
    random = np.random.default_rng(4).uniform(0.3, 1.0, (len(uv), 4)).astype(np.float32)
    assert first.uv is not None
    return replace(
        first, more_uv=(first.uv * np.float32(0.7), first.uv * np.float32([2.0, -1.5]) + np.float32(0.2)), colors=random
    )


def picture(
    seed: int, width: int, height: int, low: int = 0, high: int = 255, wraps: tuple[Wrap, Wrap] = REPEATS
) -> Texture:
    pixels = np.random.default_rng(seed).integers(low, high, (height, width, 4)).astype(np.uint8)
    return Texture(pixels, wraps)


def all_kinds(*, holes: bool = False) -> tuple[Scene, IrradianceMap]:
    """A ring around a ball and before a dish: all four textures, wrapped in all ways, by further coordinates;
    colours of vertices; both sides, and black backs.
    Beside them stands what does not reflect, with textures that say that it did, masked if it is to have ``holes``, and
    a sheet seen from both sides."""
    ring, ball = torus_mesh(0.5, 0.17, around=40, sides=20), sphere(24, 48, 0.28)
    angles = np.random.default_rng(0).uniform(-0.4, 1.5, (len(ring.positions), 2))
    bumps = picture(3, 5, 7, 96, 160)
    bumps.pixels[..., 2] = 255
    painted = Material(
        "painted", (0.9, 0.8, 0.7), 0.8, 0.0, base_color_texture_srgb=picture(1, 6, 3),
        metallic_roughness_texture=replace(picture(2, 9, 4, wraps=("mirror", "clamp")), coordinates=2),
        emission=(0.5, 0.4, 2.0), emission_texture_srgb=picture(4, 2, 8, wraps=("clamp", "repeat")),
    )  # fmt: skip
    bumpy = Material("bumpy", (0.6, 0.7, 0.8), 1.0, 0.0, normal_texture=bumps, normal_scale=0.4)
    both = Material("both", (0.5, 0.6, 0.5), 0.6, 0.0, double_sided=True, emission=(0.01, 0.02, 0.0))
    half = sphere(24, 48, 0.9)
    behind = half.positions[half.triangles].mean(1) @ [0.6, 0.3, 0.75] < -0.3
    dish = replace(half, triangles=half.triangles[behind][:, [0, 2, 1]], normals=-half.normals)  # seen from within
    lid = replace(half, triangles=half.triangles[half.positions[half.triangles].mean(1)[:, 1] > 0.8])  # from above
    beads = [moved(sphere(12, 24, 0.12), (0.45 * np.cos(a), 0.25, 0.45 * np.sin(a))) for a in (0.5, 1.6, 2.8)]
    dull = replace(painted, metallic=1.0, normal_texture=bumps, emission=(0.02, 0.1, 0.05))
    if holes:
        dull = replace(dull, alpha_mode="mask", alpha_cutoff=0.4)
    sheet = quad(np.array([(-0.3, 0.45, 0.3), (0.3, 0.45, 0.3), (0.3, 0.4, -0.3), (-0.3, 0.4, -0.3)]))
    matte = (
        *(Part(f"bead {k}", dressed(bead, np.abs(bead.normals[:, 1:])), dull) for k, bead in enumerate(beads)),
        Part("sheet", moved(sheet, (0.8, 0.0, 0.0)), replace(both, metallic=1.0)),
        Part("flap", moved(sheet, (-0.8, 0.0, 0.0)), MIRROR),
    )
    parts = (
        matte[0],
        Part("ring", dressed(ring, angles), painted, True),
        Part("ball", with_uv(ball, np.abs(ball.normals[:, :2])), bumpy, True),
        Part("dish", dish, both, True),
        Part("lid", lid, MIRROR, True),
        *matte[1:],
    )
    scene = Scene(parts, (ReflectiveObject("object", (1, 2, 3, 4)),))
    count = scene.triangle_offsets[-1]
    resolution = np.full(count, 1, np.uint32)  # six samples each, for both sides
    random = np.random.default_rng(9)
    shade = random.uniform(0.1, 1.0, (6 * count, 3)).astype(np.float32)
    gradient = random.uniform(-0.5, 0.5, (6 * count, 3)).astype(np.float32)
    return scene, IrradianceMap(resolution, 6 * np.arange(count, dtype=np.uint32), shade, gradient)


def radiance_shown(renderer: Renderer, view: Camera, pixels: np.ndarray, *layers: Shown) -> np.ndarray:
    return renderer.frame(view, samples=1, what="object", layers=layers).reshape(-1, 4)[pixels, :3]


def test_each_sample_meets_what_mitsuba_meets() -> None:
    """Hit by hit, with all that materials can have; radiance under a flat sky, whatever the maps' filter does."""
    scene, irradiance = all_kinds(holes=True)
    pem = pem_of(
        scene, [analytic_map(4, flat_sky, InfiniteSphere())], irradiance=irradiance, on_hull=hull_triangles(scene)
    )
    pem = replace(pem, most_hits=5)
    renderer, follower = Renderer(pem), RayFollower(scene, irradiance, pem.traced_parts)
    equal = traced = 0
    ends = np.zeros(len(scene.parts), int)
    for position in ((0.5, 1.5, 1.3), (1.4, -0.3, 1.2)):
        view = camera(position, (0.0, 0.0, 0.0), 128)
        gbuffer = gbuffer_from_visibility(scene, rasterized_visibility(renderer, view, 1))
        pixels = gbuffer.row_pixel[gbuffer.row_of_sample]
        first = gbuffer.lookups[0]
        ways = follower.follow(view.position, first.position[0], first.direction[0], gbuffer.triangle, 5)
        met = ways.triangles
        found = renderer.met_triangles(view, 1, 0).reshape(-1, 4)[pixels]
        rays = (met > 0).any(1)
        same = (found == met).all(1)
        equal += (same & rays).sum()
        traced += rays.sum()
        assert (same | rays).mean() > 0.999
        last = met[rays, np.minimum((met[rays] > 0).sum(1) - 1, 3)] - 1
        ends += np.bincount(np.searchsorted(scene.triangle_offsets, last, side="right") - 1, minlength=len(ends))

        shown = partial(radiance_shown, renderer, view, pixels)
        # The first surface's own light and reflectance are as drawn: the tracer has no mip levels of emission.
        own = shown("diffuse", "fresnel")
        reflected = shown("diffuse", "fresnel", "distant") - own
        radiance = own + reflected * (ways.light / np.float32(SKY) + ways.throughput)
        error = np.abs(shown("diffuse", "fresnel", "distant", "local") - radiance).max(1)
        error /= np.maximum(radiance.max(1), 1e-3)
        assert (rays & same).sum() > 700
        # Normals of bumps and grazing angles magnify the last digits.
        assert np.percentile(error[same & rays], 99.5) < 1e-3
        assert np.percentile(error[same], 99.8) < 1e-3
    assert traced > 3000
    assert equal >= 0.999 * traced
    assert (ends > 30).all()  # on each part, those that do not reflect too


def test_each_sample_meets_what_the_reference_meets() -> None:
    """The compiled twin of the shader's search, with its arithmetic."""
    scene, irradiance = all_kinds()
    pem = pem_of(scene, [analytic_map(4, flat_sky, InfiniteSphere())], irradiance=irradiance)
    bvh = build_bvh(scene, pem.on_hull)
    renderer = Renderer(replace(pem, most_hits=1, bvh=bvh))
    view = camera((0.5, 1.5, 1.3), (0.0, 0.0, 0.0), 128)
    gbuffer = gbuffer_from_visibility(scene, rasterized_visibility(renderer, view, 1))
    pixels = gbuffer.row_pixel[gbuffer.row_of_sample]
    rays, own = gbuffer.lookups[0], corners_of(scene, gbuffer.triangle)
    normal = np.cross(own[:, 1] - own[:, 0], own[:, 2] - own[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    normal *= np.sign((normal * (np.float32(view.position) - own[:, 0])).sum(1, keepdims=True))
    extent = np.maximum(np.abs(rays.position[0]).max(1), np.abs(own[:, 0]).max(1))
    corners = corners_of(scene, bvh.order)
    place, _ = closest_hits(
        refitted(bvh.leaf_counts, corners), corners,
        (rays.position[0] + 1e-5 * extent[:, None] * normal).astype(np.float32), rays.direction[0],
    )  # fmt: skip
    expected = np.where(place >= 0, bvh.order[place].astype(np.int64) + 1, 0)
    found = renderer.met_triangles(view, 1, 0).reshape(-1, 4)[pixels, 0]
    assert (expected > 0).sum() > 1000
    assert (found != expected).mean() < 5e-4  # rays through edges; and 0.1 % of hits are not sought


def facing(hits: int) -> ParameterizedEnvironmentMap:
    """Two mirrors, 0.4 apart, at x = ∓0.2, facing each other, and open all around."""
    corners = np.array([(0, -1, -1), (0, 1, -1), (0, 1, 1), (0, -1, 1)], float)
    left, right = corners + (-0.2, 0, 0), corners[::-1] + (0.2, 0, 0)
    return traced_pem(Part("left", quad(left), MIRROR, True), Part("right", quad(right), MIRROR, True), hits=hits)


@pytest.mark.parametrize("hits", [1, 3, 5])
def test_between_parallel_mirrors_light_falls_by_each_reflection(hits: int) -> None:
    """F to the power of how often the ray is mirrored until it leaves; after the last hit it sees through."""
    view = camera((0.1, 0.3, 0.9), (-0.2, 0.1, 0.6))
    shown = Renderer(facing(hits)).frame(view, samples=1, what="object")
    corner, dx, dy = view.ray_basis()
    y, x = np.indices((64, 64)) + 0.5
    ray = corner + x[..., None] * dx + y[..., None] * dy
    ray /= np.linalg.norm(ray, axis=-1, keepdims=True)
    eye = np.array(view.position)
    # Unfolded, the ray goes on straight past planes 0.4 apart, while it stays within the mirrors.
    to_first = np.where(ray[..., 0] < 0, (-0.2 - eye[0]) / ray[..., 0], (0.2 - eye[0]) / ray[..., 0])
    every = 0.4 / np.abs(ray[..., 0])
    times = to_first[..., None] + every[..., None] * np.arange(12)
    inside = np.abs(eye[1:] + times[..., None] * ray[..., None, 1:]).max(-1) < 1.0
    seen = inside[..., 0]
    count = np.minimum(np.cumprod(inside, -1).sum(-1), 1 + hits)
    c = 1.0 - np.abs(ray[..., 0])
    fresnel = 0.65 + 0.35 * c**5
    expected = np.where(seen, fresnel**count, 0.0)[..., None] * np.float16(SKY).astype(float)  # as maps hold it
    error = np.abs(shown[..., :3] - expected).max(-1)
    assert len(np.unique(count[seen])) >= min(hits, 4)
    assert (error > 1e-5).mean() < 0.01  # where the edge runs through a pixel's middle


def test_a_corner_of_three_mirrors_sends_light_back_where_it_came_from() -> None:
    def sky(d: np.ndarray) -> np.ndarray:
        return 1.0 + 0.5 * d

    walls = []
    for axis in range(3):
        u, v = np.roll(np.eye(3), -axis, 0)[1:]
        walls.append(Part(f"wall {axis}", quad(np.array([0 * u, u, u + v, v])), MIRROR, True))
    pem = traced_pem(*walls, sky=sky, size=64, lod_bias=-20.0)
    renderer, view = Renderer(pem), camera((2.2, 1.8, 2.0), (0.2, 0.25, 0.3))
    shown = renderer.frame(view, samples=1, what="object", layers=("distant", "local"))
    met = renderer.met_triangles(view, 1, 0)
    thrice = (met[..., 1] > 0) & (met[..., 2] == 0)
    corner, dx, dy = view.ray_basis()
    y, x = np.indices((64, 64)) + 0.5
    ray = corner + x[..., None] * dx + y[..., None] * dy
    ray /= np.linalg.norm(ray, axis=-1, keepdims=True)
    assert thrice.sum() > 300
    np.testing.assert_allclose(shown[thrice][:, :3], sky(-ray[thrice]), atol=3e-3)  # texels of half floats, bilinear
    assert (met[..., 2] == 0).all()


def test_backs_end_in_black_unless_both_sides_are_seen() -> None:
    """A mirror beneath a sheet that looks up: in it the sheet's back."""
    floor = quad(np.array([(-1, 0, 1), (1, 0, 1), (1, 0, -1), (-1, 0, -1)], float))
    sheet = moved(floor, (0.0, 0.15, 0.0))
    view = camera((0.0, 0.2, 1.6), (0.0, 0.0, 0.5))
    for double_sided in (False, True):
        upper = replace(MIRROR, double_sided=double_sided)
        renderer = Renderer(traced_pem(Part("floor", floor, MIRROR, True), Part("sheet", sheet, upper, True)))
        met = renderer.met_triangles(view, 1, 0)
        shown = renderer.frame(view, samples=1, what="object")
        of_floor = (met[..., 0] > 2) & (shown[..., 3] > 0)
        assert of_floor.sum() > 100
        assert (shown[of_floor][:, :3] > 0.0).all() == double_sided
        assert (shown[of_floor][:, :3] == 0.0).all() == (not double_sided)


@pytest.mark.parametrize("double_sided", [False, True])
def test_a_mirror_shows_a_matte_panel_beside_it_where_it_stands(double_sided: bool) -> None:
    """A floor at y = 0, all on its hull, and a panel at x = 0.5 that looks along -x, towards one side of the floor: its
    picture by a mirrored eye, in closed form; its back is black, or shines as its front does."""
    floor = quad(np.array([(-1, 0, 1), (1, 0, 1), (1, 0, -1), (-1, 0, -1)], float))
    low, high = np.array([0.1, -0.4]), np.array([0.6, 0.3])
    panel = quad(np.array([(0.5, y, z) for y, z in ((low[0], low[1]), (low[0], high[1]), high, (high[0], low[1]))]))
    matte = Material("matte", (0.8, 0.4, 0.2), 1.0, 0.3, emission=(0.1, 2.0, 0.3), double_sided=double_sided)
    pem = traced_pem(Part("floor", floor, MIRROR, True), Part("panel", panel, matte))
    assert pem.companions == (1,)
    # Two samples at the corners of each triangle, three a side: all of one irradiance.
    colours = IrradianceMap(
        np.ones(4, np.uint32), np.repeat(np.uint32(0), 4), np.full((6, 3), 0.5, np.float32)
    )  # of both sides
    pem = replace(pem, irradiance=colours)
    light = np.float32(matte.emission) + 0.5 * np.float32(matte.base_color)  # metals are matte here, too
    renderer, eyes = Renderer(pem), ((-0.9, 0.8, 0.4), (0.95, 0.8, 0.2))
    for eye, front in zip(eyes, (True, False), strict=True):
        view = camera(eye, (0.2, 0.0, 0.0), 96)
        corner, dx, dy = view.ray_basis()
        y, x = np.indices((96, 96)) + 0.5
        ray = corner + x[..., None] * dx + y[..., None] * dy
        ray /= np.linalg.norm(ray, axis=-1, keepdims=True)
        on_floor = np.array(eye) - eye[1] / ray[..., 1:2] * ray
        up = ray * (1, -1, 1)
        t = (0.5 - on_floor[..., 0]) / up[..., 0]
        at = (on_floor + t[..., None] * up)[..., 1:]
        meets = (t > 0) & (at > low).all(-1) & (at < high).all(-1)
        seen = light if front or double_sided else np.zeros(3)
        fresnel = np.float32(0.65) + 0.35 * (1 + ray[..., 1:2]) ** 5
        expected = fresnel * np.where(meets[..., None], seen, np.float16(SKY).astype(float))
        for layers in (("diffuse", "fresnel", "distant", "local"), ("fresnel", "distant", "local")):
            shown = renderer.frame(view, samples=1, what="object", layers=layers)
            of_floor = shown[..., 3] > 0
            error = np.abs(shown[..., :3] - expected).max(-1)[of_floor]
            assert (of_floor & meets).sum() > 200 and (of_floor & ~meets).sum() > 500
            assert (error > 1e-5).mean() < 0.01  # where the edge runs through a pixel's middle


def test_switches_and_hits() -> None:
    """Without local light, and without hits, mirrors do not see themselves; switches are for what is met, too."""
    glowing = replace(MIRROR, emission=(0.0, 1.0, 0.0))
    pem = traced_pem(Part("torus", torus(), glowing, True), image_size=128)
    view = pem.space.orbit.camera()
    traced, plain = Renderer(pem), Renderer(replace(pem, most_hits=0))
    met = traced.met_triangles(view, 1, 0)[..., 0] > 0
    frame, without = (r.frame(view, samples=1, what="object") for r in (traced, plain))
    assert met.sum() > 100
    np.testing.assert_allclose(frame[~met], without[~met], rtol=1e-6)  # the compiler orders sums differently
    assert (np.abs(frame - without)[met].max(-1) > 0.01).all()
    off = traced.frame(view, samples=1, what="object", layers=("diffuse", "fresnel", "distant"))
    np.testing.assert_allclose(off, without, rtol=1e-6)
    mirrors = traced.frame(view, samples=1, what="object", layers=("distant", "local"))
    np.testing.assert_allclose(mirrors[mirrors[..., 3] > 0, :3].std(0), 0.0, atol=1e-6)  # the sky, everywhere
    dark = traced.frame(view, samples=1, what="object", layers=("diffuse", "local"))
    assert (dark[met][:, 1] >= 2.0 - 1e-6).all()


def test_objects_see_one_another() -> None:
    """A ball over a mirror, each an object of its own, the ball's triangles all on its hull."""
    ball, floor = (
        moved(sphere(24, 48, 0.4), (0, 0.5, 0)),
        quad(np.array([(-1, 0, 1), (1, 0, 1), (1, 0, -1), (-1, 0, -1)])),
    )
    scene = Scene(
        (Part("ball", ball, MIRROR, True), Part("floor", floor, replace(MIRROR, emission=(0, 0, 5.0)), True)),
        (ReflectiveObject("ball", (0,)), ReflectiveObject("floor", (1,))),
    )
    pem = pem_of(scene, [analytic_map(4, flat_sky, InfiniteSphere())], on_hull=hull_triangles(scene))
    layer = replace(pem.layers[0], parts=(0, 1))
    renderer = Renderer(replace(pem, layers=(layer,), most_hits=2))
    view = camera((0.0, 0.9, 2.2), (0.0, 0.4, 0.0))
    met = renderer.met_triangles(view, 1, 0)[..., 0]
    shown = renderer.frame(view, samples=1, what="object")
    floor_in_ball = met > scene.triangle_offsets[1]
    assert floor_in_ball.sum() > 100
    assert ((met > 0) & (met <= scene.triangle_offsets[1])).sum() > 100
    assert (shown[floor_in_ball][:, 2] > 3.0).all()


def test_after_a_bounce_the_nearer_neighbour_tells_the_level(monkeypatch: pytest.MonkeyPatch) -> None:
    """In a hollow mirror that sees itself: by the farther one, as before bounces, the picture is blurred."""

    def waves(d: np.ndarray) -> np.ndarray:
        return 1.0 + np.sin(8 * d + (0, 1, 2)) * np.sin(8 * np.roll(d, -1, axis=1))

    ball = sphere(48, 96, 0.6)
    behind = ball.positions[ball.triangles].mean(1)[:, 2] < 0.2
    hollow = mesh(ball.positions, -ball.normals, ball.triangles[behind][:, [0, 2, 1]])
    pem = traced_pem(Part("hollow", hollow, MIRROR, True), sky=waves, size=64, lod_bias=-2.0, sample_count=16)
    view = camera((0.3, 0.3, 2.4), (0.0, 0.0, 0.0), 96)
    finest = Renderer(replace(pem, lod_bias=-20.0))
    truth = finest.frame(view, samples=64, what="object")
    bounced = (finest.met_triangles(view, 1, 0)[..., 0] > 0) & (truth[..., 3] == 1.0)

    def error(renderer: Renderer) -> float:
        return float(np.mean((renderer.frame(view, samples=16, what="object") - truth)[bounced] ** 2))

    nearer = error(Renderer(pem))
    monkeypatch.setattr(
        "reflet.render.playback.passes.link", lambda name: link(name).replace("if (m.bounced)", "if (false)")
    )
    farther = error(Renderer(pem))
    assert bounced.sum() > 500
    assert 10 * np.log10(farther / nearer) > 0.7  # 1.5 dB


def test_more_samples_see_finer_levels() -> None:
    """By half a level for twice as many, where rays are traced."""
    pem = replace(traced_pem(Part("torus", torus(), MIRROR, True)), sample_count=16, lod_bias=-3.0)
    assert [pem.lod_bias_at(samples) for samples in (1, 4, 16, 64, 256)] == [-1.0, -2.0, -3.0, -4.0, -4.0]
    assert [replace(pem, most_hits=0).lod_bias_at(samples) for samples in (4, 64)] == [-3.0, -3.0]
