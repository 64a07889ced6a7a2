"""The exact path against shapes whose mirrored rays are known in closed form."""

from dataclasses import replace

import numpy as np
import pytest

from reflet.reflectance.materials.material import dfg_table
from reflet.scene.material import CLAMPS, REPEATS, Material, Texture
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.scene import Part, ReflectiveObject, Scene
from reflet.scene.surfaces.surface import SMALLEST_CLIMB, gbuffer_from_visibility
from reflet.scene.surfaces.visibility import Visibility
from reflet.scene.views.camera import Camera
from reflet.scene.views.sample_pattern import sample_positions

UP = (0.0, 1.0, 0.0)


def floor_scene(normal: tuple[float, float, float] = UP, double_sided: bool = False, **material) -> Scene:  # type: ignore[no-untyped-def]
    """A 2 m square on y = 0 of two triangles, its front up, with shading normals of one's own."""
    positions = np.array([[-1, 0, -1], [-1, 0, 1], [1, 0, 1], [1, 0, -1]], np.float32)
    mesh = Mesh(
        positions,
        np.tile(np.float32(normal), (4, 1)),
        np.array([[0, 1, 2], [0, 2, 3]], np.uint32),
        uv=(positions[:, [0, 2]] * 0.5 + 0.5).astype(np.float32),
        tangents=np.tile(np.float32([1, 0, 0, -1]), (4, 1)),
    )
    part = Part(
        "floor", mesh, Material(perceptual_roughness=0.0, double_sided=double_sided, **material), reflective=True
    )
    return Scene((part,), (ReflectiveObject("floor", (0,)),))


def see(camera: Camera, scene: Scene, pixels: list[int], triangle: int = 0, sample_count: int = 4):  # type: ignore[no-untyped-def]
    """The lookups of some pixels' sub-samples that all see one triangle, and each sub-sample's (x, y)."""
    pixel = np.repeat(np.array(pixels, np.int32), sample_count)
    sub = np.tile(np.arange(sample_count, dtype=np.int32), len(pixels))
    visibility = Visibility(camera, sample_count, pixel, sub, np.full(len(pixel), triangle, np.uint32))
    xy = np.stack([pixel % camera.width, pixel // camera.width], -1) + sample_positions(sample_count)[sub]
    return gbuffer_from_visibility(scene, visibility), xy


def view_rays(camera: Camera, xy: np.ndarray) -> np.ndarray:
    corner, dx, dy = camera.ray_basis()
    ray = corner + xy[:, :1] * dx + xy[:, 1:] * dy
    return ray / np.linalg.norm(ray, axis=1, keepdims=True)


def test_a_plane_mirrors_the_view_ray_at_the_pixel_and_its_neighbours() -> None:
    camera = Camera((0.2, 1.0, 0.6), (0.0, 0.0, 0.0), width=16, height=16)
    gbuffer, xy = see(camera, floor_scene(), [100, 101, 136])
    lookups = gbuffer.lookups[0]
    for j, offset in enumerate([(0, 0), (0.25, 0), (0, 0.25)]):
        ray = view_rays(camera, xy + offset)
        hit = np.asarray(camera.position) - ray * (1.0 / ray[:, 1:2])
        # Stored in float32: half a unit in the last place of numbers below 1 is 3e-8.
        assert np.abs(lookups.position[j] - hit).max() < 1e-7
        assert np.abs(lookups.direction[j] - ray * (1, -1, 1)).max() < 1e-7


def test_rows_are_ordered_by_pixel_then_part_whatever_the_sub_samples_see() -> None:
    floor = floor_scene().parts[0]
    scene = Scene(
        (floor, Part("other", floor.mesh, floor.material, reflective=True)), (ReflectiveObject("both", (0, 1)),)
    )
    camera = Camera((0.2, 1.0, 0.6), (0.0, 0.0, 0.0), width=16, height=16)
    triangle = np.array([2, 0, 3, 1, 0, 0, 2, 2], np.uint32)
    pixel, sub = np.repeat(np.int32([7, 9]), 4), np.tile(np.arange(4, dtype=np.int32), 2)
    gbuffer = gbuffer_from_visibility(scene, Visibility(camera, 4, pixel, sub, triangle))
    assert gbuffer.row_pixel.tolist() == [7, 7, 9, 9]
    assert gbuffer.row_part.tolist() == [0, 1, 0, 1]
    assert gbuffer.row_of_sample.tolist() == [0, 0, 1, 1, 2, 2, 3, 3]
    assert gbuffer.triangle.tolist() == [0, 1, 2, 3, 0, 0, 2, 2]


def test_the_back_of_a_double_sided_face_mirrors_downwards() -> None:
    camera = Camera((0.2, -1.0, 0.6), (0.0, 0.0, 0.0), width=16, height=16)
    gbuffer, xy = see(camera, floor_scene(double_sided=True), [100])
    assert np.abs(gbuffer.lookups[0].direction[0] - view_rays(camera, xy) * (1, -1, 1)).max() < 1e-7


def test_rays_below_the_surface_are_bent_back_above_it() -> None:
    # A normal leaning 60° away sends rays from above into the floor.
    camera = Camera((-0.3, 1.0, 0.0), (0.0, 0.0, 0.0), width=16, height=16)
    lean = (float(np.sin(np.pi / 3)), float(np.cos(np.pi / 3)), 0.0)
    gbuffer, xy = see(camera, floor_scene(normal=lean), [100])
    ray = view_rays(camera, xy)
    straight = ray - 2.0 * (ray @ lean)[:, None] * lean
    assert (straight[:, 1] < 0.0).all()
    bent = straight + (SMALLEST_CLIMB - straight[:, 1:2]) * UP
    bent /= np.linalg.norm(bent, axis=1, keepdims=True)
    assert np.abs(gbuffer.lookups[0].direction[0] - bent).max() < 1e-7


def test_rough_surfaces_lean_towards_the_normal_that_mirrors() -> None:
    """Of a normal that faces away from the viewer: as that of the bent ray leans from it, at its own n·v."""
    camera = Camera((-1.0, 0.14, 0.0), (0.0, 0.0, 0.0), fov_deg=1.0, width=16, height=16)
    away = (float(np.sin(np.pi / 9)), float(np.cos(np.pi / 9)), 0.0)
    (part,) = (scene := floor_scene(normal=away)).parts
    rough = replace(part, material=replace(part.material, perceptual_roughness=0.5))
    gbuffer, xy = see(camera, replace(scene, parts=(rough,)), [100])
    ray = view_rays(camera, xy)
    assert (ray @ away > 0.0).all()
    half = gbuffer.mirrored - ray
    cosine = np.linalg.norm(half, axis=1, keepdims=True) / 2.0
    table = dfg_table()
    columns = np.arange(table.shape[1])
    rows = [np.interp(np.sqrt(cosine[:, 0]) * columns[-1], columns, table[row, :, 2]) for row in range(table.shape[0])]
    lean = np.array([np.interp(0.5 * (len(rows) - 1), np.arange(len(rows)), of_one) for of_one in np.transpose(rows)])
    leant = gbuffer.mirrored + lean[:, None] * (half / (2.0 * cosine) - gbuffer.mirrored)
    leant /= np.linalg.norm(leant, axis=1, keepdims=True)
    assert lean.min() > 0.1  # far from what rounds
    assert np.abs(gbuffer.lookups[0].direction[0] - leant).max() < 1e-6  # the cosine is of rays in float32


def test_neighbours_on_a_plane_seen_edge_on_stay_finite() -> None:
    camera = Camera((0.0, 1e-3, 5.0), (0.0, 0.0, 0.0), width=16, height=16)
    gbuffer, _ = see(camera, floor_scene(), list(range(16 * 7, 16 * 9)))
    lookups = gbuffer.lookups[0]
    # Clamped barycentrics keep positions within 20 edges (of at most 2·√2 m) each way.
    assert np.abs(lookups.position).max() < 1.0 + 2 * 20 * 2.0**1.5
    assert np.abs(np.linalg.norm(lookups.direction, axis=-1) - 1.0).max() < 1e-6


@pytest.mark.parametrize(("texel", "expected"), [((255, 128, 255), (1, 0, 0)), ((128, 255, 255), (0, 0, 1))])
def test_normal_maps_lean_along_tangent_and_bitangent(texel, expected) -> None:  # type: ignore[no-untyped-def]
    """Red leans towards the tangent +x, green towards the bitangent (n×t)·w = (+y × +x)·(-1) = +z."""
    texture = Texture(np.tile(np.array([*texel, 255], np.uint8), (2, 2, 1)))
    camera = Camera((0.01, 1.0, 0.0), (0.0, 0.0, 0.0), width=16, height=16)
    gbuffer, xy = see(camera, floor_scene(normal_texture=texture, normal_scale=0.2), [136])
    # 128 decodes to 1/255, not 0: follow the definition.
    x, y, z = 2.0 * np.array(texel) / 255.0 - 1.0
    normal = np.array([0.2 * x, z, 0.2 * y])
    normal /= np.linalg.norm(normal)
    ray = view_rays(camera, xy)
    mirrored = ray - 2.0 * (ray @ normal)[:, None] * normal
    mirrored += np.maximum(SMALLEST_CLIMB - mirrored[:, 1:2], 0.0) * UP
    mirrored /= np.linalg.norm(mirrored, axis=1, keepdims=True)
    assert np.abs(gbuffer.lookups[0].direction[0] - mirrored).max() < 1e-7
    assert (gbuffer.lookups[0].direction[0] @ np.array(expected) > 0.2).all()


def test_textures_are_filtered_bilinearly_and_repeat() -> None:
    """A ramp of two texels over u: halfway between their centres the normal map is their mean; beyond the edge it goes
    on with the other one, or with the same where it clamps or is mirrored."""
    pixels = np.zeros((1, 2, 4), np.uint8)
    pixels[0, :, :3] = [(100, 128, 255), (200, 128, 255)]
    for wraps, across in ((REPEATS, 150.0), (CLAMPS, 200.0), (("mirror", "repeat"), 200.0)):
        scene = floor_scene(normal_texture=Texture(pixels, wraps))
        for x_metres, red in ((0.0, 150.0), (0.999999, across)):
            eye = Camera((x_metres, 1.0, 1e-3), (x_metres, 0.0, 0.0), up=(0.0, 0.0, -1.0), width=1, height=1)
            direction = see(eye, scene, [0], triangle=1, sample_count=1)[0].lookups[0].direction[0, 0]
            normal = np.array([2 * red / 255 - 1, 2 * 128 / 255 - 1, 1.0])[[0, 2, 1]]
            normal /= np.linalg.norm(normal)
            ray = view_rays(eye, np.array([[0.5, 0.5]]))[0]
            # 1e-6 m beside the texture's edge is 2e-6 of a texel, times a slope of 100/255.
            assert np.abs(direction - (ray - 2 * (ray @ normal) * normal)).max() < 3e-6
