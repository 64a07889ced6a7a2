"""Frames: closed forms first, then properties."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp
from scenes import (
    MIRROR,
    analytic_map,
    mirror_torus_pem,
    pem_of,
    quad,
    random_map,
    scene_of,
    sphere,
    torus,
)

from reflet.envmap.geometry import Box, Ellipsoid, InfiniteSphere
from reflet.envmap.mip_chain import MipChain
from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS
from reflet.envmap.parameterizations.cube import FACES, direction_from_face
from reflet.errors import RefletError
from reflet.infer.rendering_matrix import rendering_matrix
from reflet.render.device import device as device_module
from reflet.render.playback.renderer import Renderer
from reflet.render.playback.visibility import rasterized_visibility
from reflet.scene.material import EnvironmentLight, Material, Texture
from reflet.scene.scene import Part
from reflet.scene.surfaces.irradiance import IrradianceMap
from reflet.scene.surfaces.surface import gbuffer_from_visibility
from reflet.scene.views.camera import Camera

FLOOR = [(-1, 0, 1), (1, 0, 1), (1, 0, -1), (-1, 0, -1)]
HALF = 2.0**-11  # relative rounding of half floats


def test_furnace_a_constant_map_stays_constant() -> None:
    scene = scene_of(Part("torus", torus(), replace(MIRROR, base_color=(1.0, 1.0, 1.0)), True))
    box = Box((-1, -1, -1), (1, 1, 1), (0, 0, 0))
    constant = analytic_map(32, lambda d: np.broadcast_to([0.5, 1.0, 2.0], d.shape), box)
    frame = Renderer(pem_of(scene, [constant, constant])).frame(
        Camera((1.0, 0.8, 0.6), (0, 0, 0), width=64, height=48), what="object"
    )
    # Powers of two: half floats, weights that add up to 1 and F = 1 leave nothing but float32's rounding.
    np.testing.assert_allclose(frame[..., :3], frame[..., 3:] * [0.5, 1.0, 2.0], rtol=1e-6, atol=1e-7)
    assert frame[..., 3].max() == 1.0 and frame[..., 3].min() == 0.0


def test_frames_are_the_rendering_matrix_times_the_texels() -> None:
    box = Box((-1, -0.6, -1.2), (1, 1, 1.1), (0.1, 0, 0))
    scene = scene_of(Part("torus", torus(), MIRROR, True))
    env_map = random_map(32, 3, box, 1)
    pem = pem_of(scene, [env_map], lod_bias=-1.5, image_size=64)
    renderer, camera = Renderer(pem), pem.space.camera(0)
    gbuffer = gbuffer_from_visibility(scene, rasterized_visibility(renderer, camera, 4))
    a = rendering_matrix(gbuffer, MipChain(32), box, -1.5)
    expected = sp.csr_matrix((a.weights, a.columns, a.starts), (len(a.starts) - 1, a.texel_count)) @ env_map.texels
    image = renderer.layer_image(camera, "distant").reshape(-1, 4)[gbuffer.row_pixel]
    # Weights agree to 1e-5, about eight of them matter, texels are at most 2.
    np.testing.assert_allclose(image[:, :3] / image[:, 3:], expected, atol=1e-4)
    assert len(expected) > 500


@pytest.mark.parametrize("name", PARAMETERIZATIONS)
def test_a_mirror_sphere_shows_the_analytic_reflection(name: str) -> None:
    def radiance(d: np.ndarray) -> np.ndarray:
        return 1.0 + np.stack([d[..., 0], d[..., 1] * d[..., 2], d[..., 1]], -1)

    scene = scene_of(Part("ball", sphere(128, 256, 0.4), MIRROR, True))
    parameterization, size = PARAMETERIZATIONS[name], 128 if name == "cube" else 256
    camera = pem_of(scene, [analytic_map(1, radiance, InfiniteSphere())], image_size=96).space.camera(0)
    frame_of_map = camera.view_from_world() if parameterization.is_view_dependent else np.eye(3)
    env_map = analytic_map(size, radiance, InfiniteSphere(), parameterization, frame_of_map)
    pem = pem_of(scene, [env_map], image_size=96)
    frame = Renderer(pem).frame(camera, samples=1, what="object")
    y, x = np.mgrid[:96, :96] + 0.5
    corner, dx, dy = camera.ray_basis()
    d = corner + x[..., None] * dx + y[..., None] * dy
    d /= np.linalg.norm(d, axis=-1, keepdims=True)
    eye = np.asarray(camera.position)
    b, c = d @ eye, eye @ eye - 0.16
    n = (eye - (b + np.sqrt(np.maximum(b * b - c, 0)))[..., None] * d) / 0.4
    n = np.where((b * b > c)[..., None], n, 0)
    cosine = -np.einsum("...i,...i", d, n)
    inside = cosine > 0.3  # near the silhouette facets differ from the sphere
    r = d + 2 * cosine[..., None] * n
    expected = (0.65 + 0.35 * (1 - cosine) ** 5)[..., None] * radiance(r)
    # Facets of 1.4° with interpolated normals bend by (1.4°/2)²/2 = 7e-5, map texels of 0.7° (up to 2.1° along the
    # gazing ball's radius, here) are filtered linearly: 7e-5 (7e-4); chords move hit points by 3e-5 m, which a grazing
    # view stretches threefold and the normal divides by 0.4. At an octahedron's edges directions bend over the texels
    # as |x| does: there filtering errs by a quarter of a texel of up to 1.4° times a bend of up to 1.
    tolerance = 6e-3 if "octahedral" in name else 2e-3
    assert np.abs(frame[inside][:, :3] - expected[inside]).max() < tolerance
    assert inside.sum() > 1500


def test_labelled_faces_appear_where_they_belong() -> None:
    """Six mirrors look straight at the six faces: each shows its face's colour, and its texels the right way round."""
    chain = MipChain(16)
    for face in range(6):
        texels = np.zeros((chain.texel_count, 3), np.float32)
        level = chain.level(texels, 0)
        level[face] = 1.0
        level[face, :4, :4] = (2.0, 0.0, 0.0)  # top left
        level[face, :4, -4:] = (0.0, 2.0, 0.0)  # top right
        env_map = replace(random_map(16, 3, InfiniteSphere(), 0), texels=texels)
        centre = direction_from_face(np.array(face), np.array(0.0), np.array(0.0))
        # A mirror that faces the viewer sends rays straight back: the camera looks away from the face.
        target = np.zeros(3)
        right = direction_from_face(np.array(face), np.array(1.0), np.array(0.0)) - centre
        down = direction_from_face(np.array(face), np.array(0.0), np.array(1.0)) - centre
        corners = [target - right + down, target + right + down, target + right - down, target - right - down]
        mesh = quad(0.05 * np.array(corners))
        if np.dot(mesh.normals[0], centre) < 0:
            mesh = quad(0.05 * np.array(corners[::-1]))
        scene = scene_of(Part("mirror", mesh, MIRROR, True))
        camera = Camera(tuple(2.0 * centre), (0, 0, 0), tuple(-down), fov_deg=2.0, width=8, height=8)
        shown = Renderer(pem_of(scene, [env_map], lod_bias=-20.0)).layer_image(camera, "distant", samples=1)
        assert shown[4, 4, 0] == 1.0, FACES[face]
        for s, t, color in ((-0.8, -0.8, (2, 0, 0)), (0.8, -0.8, (0, 2, 0))):
            wanted = direction_from_face(np.array(face), np.array(s), np.array(t))
            tilted = tilted_mirror(camera, wanted)
            shown = Renderer(pem_of(tilted, [env_map], lod_bias=-20.0)).layer_image(camera, "distant", samples=1)
            np.testing.assert_allclose(shown[4, 4, :3], color, atol=1e-6, err_msg=FACES[face])


def tilted_mirror(camera: Camera, wanted: np.ndarray):  # type: ignore[no-untyped-def]
    """A small mirror at the origin that sends the camera's middle ray towards ``wanted``."""
    towards_eye = np.asarray(camera.position) / np.linalg.norm(camera.position)
    n = towards_eye + wanted / np.linalg.norm(wanted)
    n /= np.linalg.norm(n)
    u = np.cross(n, [0.3, 0.5, 0.8])
    u /= np.linalg.norm(u)
    v = np.cross(n, u)
    return scene_of(Part("mirror", quad(0.2 * np.array([-u - v, u - v, u + v, -u + v])), MIRROR, True))


def test_blends_are_weighted_means_of_single_samples() -> None:
    scene = scene_of(Part("torus", torus(), MIRROR, True))
    ellipsoid = Ellipsoid((0, 0, 0), (0.5, 0.2, 0.5), (0, 0, 0))
    distant = [random_map(16, 3, InfiniteSphere(), k) for k in range(2)]
    local = [random_map(16, 4, ellipsoid, 10 + k) for k in range(2)]
    pem = pem_of(scene, distant, local)
    renderer, camera = Renderer(pem), pem.space.orbit.camera({"azimuth_deg": 60.5})
    first, second = (renderer.frame(camera, point={"azimuth_deg": a}) for a in (60.0, 62.0))
    np.testing.assert_allclose(renderer.frame(camera), 0.75 * first + 0.25 * second, atol=2e-6)  # float32 sums up to 4
    np.testing.assert_array_equal(renderer.frame(camera, blend=False), first)
    assert np.abs(first - second).max() > 0.1


def test_layers_can_be_left_out_and_add_up() -> None:
    glossy = replace(MIRROR, base_color=(0.8, 0.6, 0.4), metallic=0.5)
    scene = scene_of(Part("torus", torus(), glossy, True))
    count = scene.triangle_offsets[-1]
    light = IrradianceMap(
        np.ones(count, np.uint32), 3 * np.arange(count, dtype=np.uint32), np.full((3 * count, 3), 0.5, np.float32)
    )
    ellipsoid = Ellipsoid((0, 0, 0), (0.5, 0.2, 0.5), (0, 0, 0))
    opaque = replace(random_map(16, 4, ellipsoid, 3))
    opaque.texels[:, 3] = 1.0
    pem = pem_of(scene, [random_map(16, 3, InfiniteSphere(), 2)], [opaque], irradiance=light)
    renderer, camera = Renderer(pem), pem.space.camera(0)

    def shown(*layers: str) -> np.ndarray:
        return renderer.frame(camera, layers=layers, what="object")

    full, coverage = shown("diffuse", "fresnel", "distant", "local"), shown()[..., 3:]
    np.testing.assert_array_equal(shown()[..., :3], 0.0)
    # diffuse colour = base_color·(1 - metallic), irradiance/pi = 0.5
    diffuse = coverage * np.array([0.8, 0.6, 0.4]) * 0.5 * 0.5
    np.testing.assert_allclose(shown("diffuse")[..., :3], diffuse, atol=1e-6)
    np.testing.assert_allclose(full[..., :3] - shown("fresnel", "distant", "local")[..., :3], diffuse, atol=2e-6)
    # A local layer that covers all hides the distant one.
    np.testing.assert_allclose(full, shown("diffuse", "fresnel", "local"), atol=1e-6)
    assert np.abs(full - shown("diffuse", "fresnel", "distant")).max() > 0.1
    np.testing.assert_allclose(shown("distant"), renderer.layer_image(camera, "distant"), atol=1e-6)


def test_the_hull_looks_up_the_distant_map_alone() -> None:
    scene = scene_of(Part("torus", torus(), MIRROR, True))
    ellipsoid = Ellipsoid((0, 0, 0), (0.5, 0.2, 0.5), (0, 0, 0))
    maps = [random_map(16, 3, InfiniteSphere(), 2)], [random_map(16, 4, ellipsoid, 3)]
    on_hull = np.random.default_rng(0).random(scene.triangle_offsets[-1]) < 0.5
    pem = pem_of(scene, *maps, on_hull=on_hull)
    camera = pem.space.camera(0)
    mixed, everywhere = Renderer(pem), Renderer(pem_of(scene, *maps))
    seen = rasterized_visibility(mixed, camera, 1)
    hull = on_hull[seen.triangle]
    assert 0.3 < hull.mean() < 0.7
    pictures = [
        each.frame(camera, samples=1, layers=layers).reshape(-1, 4)[seen.pixel]
        for each, layers in ((mixed, ("distant", "local")), (everywhere, ("distant", "local")), (mixed, ("distant",)))
    ]
    # Pipelines for the two kinds of triangles may round differently.
    np.testing.assert_allclose(pictures[0][hull], pictures[2][hull], atol=1e-6)
    np.testing.assert_allclose(pictures[0][~hull], pictures[1][~hull], atol=1e-6)
    local = mixed.layer_image(camera, "local", samples=1).reshape(-1, 4)[seen.pixel]
    assert (local[hull] == 0).all() and (local[~hull, 3] > 0).all()


def test_four_samples_in_one_pass_are_four_passes() -> None:
    pem = mirror_torus_pem()
    renderer, camera = Renderer(pem), pem.space.camera(0)
    apart = renderer.frame(camera, samples=4)
    at_once = renderer.frame(camera, samples=4, multisampled=True)
    # Both hold radiance up to 2 in half floats. They rasterize the same positions on other grids: a few edges move.
    moved = np.abs(apart[..., 3] - at_once[..., 3]) > 0.1
    assert moved.mean() < 0.002
    assert np.abs(apart - at_once)[~moved].max() < 4 * HALF
    with pytest.raises(RefletError, match="4 samples"):
        renderer.frame(camera, samples=16, multisampled=True)


def test_backs_of_single_sided_faces_are_black() -> None:
    bright = analytic_map(8, lambda d: np.ones(d.shape), InfiniteSphere())
    for double_sided in (False, True):
        floor = Part("floor", quad(FLOOR), replace(MIRROR, double_sided=double_sided), True)
        renderer = Renderer(pem_of(scene_of(floor), [bright]))
        below = Camera((0.0, -1.0, 0.3), (0, 0, 0), width=8, height=8)
        picture = renderer.frame(below)
        assert picture[4, 4, 3] == 1.0
        assert (picture[4, 4, 0] > 0.6) == double_sided
        assert renderer.frame(below, what="object")[4, 4, 3] == double_sided
        assert len(rasterized_visibility(renderer, below, 4).pixel) == 256 * double_sided


def test_parts_hide_each_other_and_the_object_is_cut_out() -> None:
    matte = Material(base_color=(0.5, 0.5, 0.5), metallic=0.0, emission=(3.0, 2.0, 1.0))
    wall = quad([(-1, -1, 0.3), (0, -1, 0.3), (0, 1, 0.3), (-1, 1, 0.3)])
    scene = scene_of(Part("ball", sphere(16, 32, 0.2), MIRROR, True), Part("wall", wall, matte))
    bright = analytic_map(8, lambda d: np.ones(d.shape), InfiniteSphere())
    renderer, camera = Renderer(pem_of(scene, [bright])), Camera((0, 0, 1.0), (0, 0, 0), width=32, height=32)
    picture, cut = renderer.frame(camera), renderer.frame(camera, what="object")
    np.testing.assert_allclose(picture[16, 14], [3, 2, 1, 1], rtol=1e-6)  # emission alone: no irradiance there
    assert (cut[16, 14] == 0).all() and cut[16, 18, 3] == 1.0 and 0.64 < cut[16, 18, 0] < 0.7


def test_mesh_colours_are_linear_between_samples() -> None:
    """Radiosity that is linear in position is shown exactly, whatever the resolution."""
    floor = Part("floor", quad(FLOOR), Material(base_color=(1.0, 1.0, 1.0), metallic=0.0))
    ball = Part("ball", sphere(8, 8, 0.01), MIRROR, True)
    scene = scene_of(ball, floor)
    resolution, n = 5, 21
    triangles = scene.triangle_offsets[-1]
    resolutions, offsets = np.zeros(triangles, np.uint32), np.zeros(triangles, np.uint32)
    resolutions[-2:], offsets[-2:] = resolution, (0, n)
    i, j = np.array([(i, j) for i in range(resolution + 1) for j in range(resolution + 1 - i)]).T / resolution
    corners = floor.mesh.positions[floor.mesh.triangles]
    points = np.concatenate([c[0] + i[:, None] * (c[1] - c[0]) + j[:, None] * (c[2] - c[0]) for c in corners])
    light = IrradianceMap(resolutions, offsets, (2 + points).astype(np.float32))
    bright = analytic_map(8, lambda d: np.ones(d.shape), InfiniteSphere())
    camera = Camera((0.3, 1.0, 0.4), (0.2, 0, 0.1), width=32, height=32)
    shown = Renderer(pem_of(scene, [bright], irradiance=light)).frame(camera, samples=1)
    y, x = np.mgrid[:32, :32] + 0.5
    corner, dx, dy = camera.ray_basis()
    d = corner + x[..., None] * dx + y[..., None] * dy
    hit = np.asarray(camera.position) - d / d[..., 1:2]
    on = (np.abs(hit[..., [0, 2]]) < 0.99).all(-1) & (np.linalg.norm(hit, axis=-1) > 0.05)
    assert on.mean() > 0.5
    np.testing.assert_allclose(shown[on][:, :3], 2 + hit[on], atol=2e-6)


def test_picture_textures_fade_to_their_mean_far_away() -> None:
    checks = np.zeros((256, 256, 4), np.uint8)
    checks[::2, ::2] = checks[1::2, 1::2] = 255
    floor = replace(Material(base_color=(1.0, 1.0, 1.0), metallic=0.0), base_color_texture_srgb=Texture(checks))
    uv = np.array([(0, 0), (1, 0), (1, 1), (0, 1)])
    scene = scene_of(Part("ball", sphere(8, 8, 0.01), MIRROR, True), Part("floor", quad(FLOOR, uv), floor))
    triangles = scene.triangle_offsets[-1]
    resolution, offset = np.zeros(triangles, np.uint32), np.zeros(triangles, np.uint32)
    resolution[-2:] = 1
    light = IrradianceMap(resolution, offset, np.ones((3, 3), np.float32))
    bright = analytic_map(8, lambda d: np.ones(d.shape), InfiniteSphere())
    renderer = Renderer(pem_of(scene, [bright], irradiance=light))
    far = renderer.frame(Camera((0, 40, 1), (0, 0, 0), fov_deg=10, width=32, height=32), samples=16)
    # 2 m over 9 pixels: 28 texels a pixel, 7 a sub-sample: the mean of black and white shows. 8-bit mip levels round
    # 0.5 to 0.503.
    np.testing.assert_allclose(far[13:15, 13:15, :3], 0.5, atol=0.01)
    near = renderer.frame(Camera((0.5, 0.05, 0.5), (0.5, 0, 0.49), fov_deg=40, width=64, height=64), samples=1)
    assert near[..., 0].min() < 0.05 and near[..., 0].max() > 0.95


def test_the_environment_is_the_backdrop() -> None:
    rows, columns = np.mgrid[:64, :128] + 0.5
    phi, theta = (columns / 128 - 0.5) * 2 * np.pi, rows / 64 * np.pi
    d = np.stack([np.cos(phi) * np.sin(theta), np.cos(theta), np.sin(phi) * np.sin(theta)], -1)
    scene = replace(
        scene_of(Part("ball", sphere(8, 8, 0.01), MIRROR, True)),
        environment=EnvironmentLight((2 + d).astype(np.float32)),
    )
    renderer = Renderer(pem_of(scene, [analytic_map(8, lambda d: np.ones(d.shape), InfiniteSphere())]))
    for target in ((-1, 0.2, 0.0), (0.3, 1, 0.2), (0.5, -0.3, 1.0)):  # the first looks at the seam
        position = tuple(-np.array(target))
        camera = Camera(position, target, width=40, height=40, fov_deg=60)
        y, x = np.mgrid[:40, :40] + 0.5
        corner, dx, dy = camera.ray_basis()
        ray = corner + x[..., None] * dx + y[..., None] * dy
        ray /= np.linalg.norm(ray, axis=-1, keepdims=True)
        picture = renderer.frame(camera, samples=1)
        away = picture[..., 3] == 1.0
        away &= np.abs(ray[..., 1]) < 0.9995  # within a texel of the poles all directions share a row
        away[18:22, 18:22] = False  # the ball
        # Linear filtering of 2.8° texels: (2.8°)²/8 = 3e-4, twice that a mip level coarser; half floats near 2: 1e-3.
        np.testing.assert_allclose(picture[away][:, :3], (2 + ray)[away], atol=2.5e-3)
        assert (renderer.frame(camera, what="object")[away] == 0).all()


def test_few_slots_serve_many_samples() -> None:
    pem = mirror_torus_pem(size=8, samples=12)
    small, large = Renderer(pem, map_memory=1), Renderer(pem)
    for azimuth in (60.0, 71.0, 82.0, 63.0, 61.0, 77.5):
        camera = pem.space.orbit.camera({"azimuth_deg": azimuth})
        np.testing.assert_array_equal(small.frame(camera), large.frame(camera))


def test_what_the_device_cannot_take_is_refused_in_a_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    renderer = Renderer(mirror_torus_pem())
    with pytest.raises(RefletError, match="larger than this device takes"):
        renderer.frame(Camera((1, 1, 1), (0, 0, 0), width=10**6, height=1))

    def no_adapter(**_: str) -> None:
        raise RuntimeError("Request adapter failed")

    monkeypatch.setattr(device_module.wgpu.gpu, "request_adapter_sync", no_adapter)
    with pytest.raises(RefletError, match="apt-get install mesa-vulkan-drivers"):
        device_module.open_device()
