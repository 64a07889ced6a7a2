"""The compact form shows the same scene: everything that counts triangles follows them, and rounding is bounded."""

import json
import shutil
from dataclasses import replace

import numpy as np
import pytest
from small_pem import small_pem

from reflet.errors import RefletError
from reflet.pem.compact import compacted
from reflet.pem.container import open_pem, save_pem
from reflet.pem.mesh_codes import as_decoded
from reflet.scene.bvh.build import build_bvh
from reflet.scene.bvh.bvh import corners_of
from reflet.scene.material import Material, Texture
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.readers.gltf.read import read_gltf
from reflet.scene.scene import Part, ReflectiveObject, Scene
from reflet.scene.surfaces.irradiance import IrradianceMap
from reflet.scene.surfaces.surface_layer import SIDES, SurfaceLayer

EXTENT = 1.26  # of the two balls together
STEP = 2.0**-16  # of their grid: the power of two below EXTENT/2¹⁶


def light(position):
    """Irradiance that tells where it is; bright and dark."""
    return np.exp(2.0 * np.sin(3.0 * position)).astype(np.float32)


LUMINANCE = np.float32([0.2126, 0.7152, 0.0722])


def bends(position):
    """Ratios of gradients to luminance that tell where they are, of either sign, small and large."""
    return (np.sinh(3.0 * np.sin(2.0 * position)) * (0.1, 0.5, 2.0)).astype(np.float32)


def sample_positions(scene, irradiance):
    """Where the format says that each mesh colour lies, fronts before backs; and whether it is a back's."""
    corners = corners_of(scene, np.arange(scene.triangle_offsets[-1], dtype=np.uint32)).astype(np.float64)
    sides = np.repeat([1 + part.material.double_sided for part in scene.parts], np.diff(scene.triangle_offsets))
    positions, backs = np.full((len(irradiance.radiosity), 3), np.nan), np.zeros(len(irradiance.radiosity), bool)
    for t, r in enumerate(irradiance.resolution.tolist()):
        grid = (r + 1) * (r + 2) // 2
        for side in range(sides[t] if r else 0):
            for i in range(r + 1):
                for j in range(r + 1 - i):
                    at = irradiance.offset[t] + side * grid + i * (2 * r + 3 - i) // 2 + j
                    positions[at] = np.array([r - i - j, i, j]) / r @ corners[t]
                    backs[at] = side
    return positions, backs


def lit_pem(**options):
    """The small PEM, lit by `light`, its triangles of many resolutions, its hull the side of positive x."""
    pem = small_pem(**options)
    count = pem.scene.triangle_offsets[-1]
    sides = np.repeat([1 + part.material.double_sided for part in pem.scene.parts], np.diff(pem.scene.triangle_offsets))
    resolution = (np.arange(count) % 5).astype(np.uint32)
    counts = np.where(resolution > 0, (resolution + 1) * (resolution + 2) // 2 * sides, 0)
    empty = IrradianceMap(
        resolution, (np.cumsum(counts) - counts).astype(np.uint32), np.zeros((int(counts.sum()), 3), np.float32)
    )
    positions, backs = sample_positions(pem.scene, empty)
    colours = light(positions) * np.where(backs, 0.5, 1.0)[:, None].astype(np.float32)
    corners = corners_of(pem.scene, np.arange(count, dtype=np.uint32))
    return replace(
        pem,
        irradiance=replace(empty, radiosity=colours, gradient=bends(positions) * (colours @ LUMINANCE)[:, None]),
        on_hull=corners.mean(axis=1)[:, 0] > 1e-3,
        most_hits=4,
        surface=SurfaceLayer(
            empty.resolution, empty.offset, np.arange(len(colours))[::-1].astype(np.uint32), maps(colours)
        ),
    )


def maps(colours):
    """A site for each mesh colour, in the opposite order: radiance of either sign that tells which, and alpha."""
    signs = np.where(np.arange(SIDES[0] ** 2) % 2, 1.0, -1.0)[:, None]
    light = colours[::-1, None] * signs * np.linspace(0.5, 1.0, SIDES[0] ** 2)[:, None]
    alpha = np.broadcast_to(np.linspace(-1.0, 1.0, SIDES[0] ** 2), light.shape[:2])[..., None]
    return np.concatenate([light, alpha], -1).astype(np.float16)


@pytest.fixture(scope="module")
def pem():
    return lit_pem()


@pytest.fixture(scope="module")
def stored(tmp_path_factory, pem):
    folder = tmp_path_factory.mktemp("compact") / "pem"
    save_pem(folder, pem)
    return folder


def sorted_corners(scene):
    """All triangles as rows that do not depend on order, corner or rounding."""
    corners = corners_of(scene, np.arange(scene.triangle_offsets[-1], dtype=np.uint32)).astype(np.float64)
    turns = np.stack([np.roll(corners, turn, axis=1).reshape(-1, 9) for turn in range(3)])
    coarse = np.round(turns, 3) + 0.0
    first = np.array([min(range(3), key=lambda turn: tuple(coarse[turn, t])) for t in range(len(corners))])
    rows = turns[first, np.arange(len(corners))]
    return rows[np.lexsort(np.round(rows, 3).T)]


def test_the_same_triangles_are_seen_from_the_same_side(pem, stored):
    """To half a step; corners stay counter-clockwise, as only turning around leaves them."""
    back = open_pem(stored)
    assert back.scene.triangle_offsets == pem.scene.triangle_offsets
    np.testing.assert_allclose(sorted_corners(back.scene), sorted_corners(pem.scene), atol=0.5001 * STEP)
    for part in back.scene.parts:
        np.testing.assert_array_equal(np.rint(part.mesh.positions / STEP), part.mesh.positions / STEP)


def test_irradiance_follows_its_triangles(pem, stored):
    """Front and back, at every grid point. Half a step of green's logarithm is 1/256, of the others' 1/128; the toe and
    the grid of positions add a thousandth."""
    back = open_pem(stored)
    positions, backs = sample_positions(back.scene, back.irradiance)
    expected = light(positions) * np.where(backs, 0.5, 1.0)[:, None]
    relative = back.irradiance.radiosity / expected - 1.0
    assert np.abs(relative[:, 1]).max() < 1 / 256 + 1e-3
    assert np.abs(relative).max() < 1 / 128 + 1e-3
    assert np.sort(back.irradiance.resolution).tolist() == np.sort(pem.irradiance.resolution).tolist()
    assert backs.any() and np.isfinite(positions).all()  # every colour has its place


def test_gradients_follow_their_triangles(pem, stored):
    """In proportion to the luminance, which itself is rounded. Half a step of their logarithm is 1/32, its toe is 1/4;
    the grid of positions adds a thousandth."""
    back = open_pem(stored)
    positions, _ = sample_positions(back.scene, back.irradiance)
    found = back.irradiance.gradient / (back.irradiance.radiosity @ LUMINANCE)[:, None]
    expected = bends(positions)
    assert (np.abs(found - expected) < (np.abs(expected) + 0.25) / 31 + 1e-3).all()
    assert np.abs(expected).max() > 10.0 and (np.abs(expected) < 0.01).any()


def test_scenes_without_bent_normals_store_no_gradients(tmp_path, pem):
    flat = replace(pem, irradiance=replace(pem.irradiance, gradient=np.zeros_like(pem.irradiance.gradient)))
    for codec in ("av1", "none"):
        save_pem(tmp_path / codec, flat, codec=codec)
        document = json.loads((tmp_path / codec / "scene.gltf").read_text())
        (extension,) = document["extensions"].values()
        assert set(extension["irradiance"]) == {"resolution", "offset", "radiosity"}
        assert not open_pem(tmp_path / codec).irradiance.gradient.size


def test_gradients_of_another_size_are_refused(tmp_path, pem):
    save_pem(tmp_path / "pem", pem, codec="none")
    path = tmp_path / "pem" / "scene.gltf"
    document = json.loads(path.read_text())
    document["extensions"]["REFLET_parameterized_environment_map"]["irradiance"]["gradient"]["shape"][0] -= 1
    path.write_text(json.dumps(document))
    with pytest.raises(RefletError, match="gradients of shape"):
        open_pem(tmp_path / "pem")


def test_maps_on_surfaces_follow_their_triangles(pem, stored):
    """As irradiance does. Half a step of the logarithm is 1/32, near 0 of the mean magnitude, half floats and positions
    add a little; of alpha it is 1/256. Sites are numbered as they come."""
    back = open_pem(stored)
    positions, backs = sample_positions(back.scene, back.irradiance)
    found = back.surface.light[back.surface.site].astype(float)
    expected = maps(light(positions) * np.where(backs, 0.5, 1.0)[:, None].astype(np.float32))[::-1].astype(float)
    mean = np.abs(pem.surface.light[..., :3].astype(float)).mean()
    assert (np.abs(found - expected)[..., :3] < (np.abs(expected[..., :3]) + mean) / 30).all()
    assert np.abs(found - expected)[..., 3].max() < 1 / 255
    assert back.surface.site[0] == 0 and np.diff(np.maximum.accumulate(back.surface.site.astype(int))).max() == 1
    assert len(back.surface.light) == len(pem.surface.light)


def test_dark_stays_dark_and_lamps_keep_their_light(tmp_path, pem):
    """0 is 0; a thousand times the mean is in scale; far below it errors are half a step of the linear toe, 2⁻¹⁰/128 of
    the mean."""
    colours = pem.irradiance.radiosity.copy()
    colours[:200] = 0.0
    colours[200:300] = 1e-5
    colours[300] = 1e3
    save_pem(tmp_path / "pem", replace(pem, irradiance=replace(pem.irradiance, radiosity=colours)))
    back = open_pem(tmp_path / "pem").irradiance.radiosity
    assert np.count_nonzero(back == 0.0) >= 600
    # the order is another one
    rounding = colours.mean() * 1e-5
    np.testing.assert_allclose(np.sort(back, axis=0), np.sort(colours, axis=0), rtol=1 / 100, atol=rounding)


def test_without_diffuse_light_a_table_stays(tmp_path, pem):
    """Mirrors alone have no mesh colours: as where they are traced, one that nobody reads keeps the table from being
    empty."""
    dark = np.zeros_like(pem.irradiance.resolution)
    save_pem(tmp_path / "pem", replace(pem, irradiance=IrradianceMap(dark, dark, np.zeros((1, 3), np.float32))))
    np.testing.assert_array_equal(open_pem(tmp_path / "pem").irradiance.radiosity, np.zeros((1, 3)))


def test_hull_flags_follow_their_triangles(pem, stored):
    back = open_pem(stored)
    corners = corners_of(back.scene, np.arange(back.scene.triangle_offsets[-1], dtype=np.uint32))
    np.testing.assert_array_equal(back.on_hull, corners.mean(axis=1)[:, 0] > 1e-3)
    assert 0 < back.on_hull.sum() < len(back.on_hull)


def test_the_tree_is_that_of_the_rounded_meshes(pem, stored):
    """Leaf by leaf it holds the same triangles as one built from what the reader sees, with the same directions; and
    the mirrors' triangles are stored in its order, part by part."""
    back = open_pem(stored)
    given = build_bvh(pem.scene, pem.on_hull)
    compact = compacted(pem.scene, pem.irradiance, pem.on_hull, given, traced=True)
    centres = [
        corners_of(scene, tree.order).mean(axis=1) for scene, tree in ((pem.scene, given), (compact.scene, compact.bvh))
    ]
    np.testing.assert_allclose(*centres, atol=STEP)
    np.testing.assert_array_equal(compact.bvh.directions, given.directions)
    for part, first in zip(back.scene.parts, back.scene.triangle_offsets, strict=False):
        own = back.bvh.order[(back.bvh.order >= first) & (back.bvh.order < first + len(part.mesh.triangles))]
        assert not part.reflective or (np.diff(own.astype(int)) == 1).all()
    built = build_bvh(back.scene, back.on_hull)
    np.testing.assert_array_equal(np.sort(built.leaf_counts), np.sort(back.bvh.leaf_counts))


def test_directions_and_texture_coordinates_are_close(pem, stored):
    """Octahedral coordinates of 14 bits are 1/8192 apart, in directions at most √3 of half of that each; uv 1/65536.
    What no texture needs is left out."""
    back = open_pem(stored)
    seen = 0
    for ours, theirs in zip(pem.scene.parts, back.scene.parts, strict=True):
        material = theirs.material
        assert (theirs.mesh.tangents is None) == (material.normal_texture is None)
        textured = material.normal_texture is not None or material.base_color_texture_srgb is not None
        assert (theirs.mesh.uv is None) == (not textured)
        # corner by corner: found again by where they are, and by direction where several lie in one place
        for k in range(len(theirs.mesh.positions)):
            here = np.abs(ours.mesh.positions - theirs.mesh.positions[k]).max(axis=1) <= STEP
            off = np.linalg.norm(ours.mesh.normals[here] - theirs.mesh.normals[k], axis=1)
            assert off.min() < 1.5 * np.sqrt(3) / 8192
            if theirs.mesh.tangents is not None:
                tangents = ours.mesh.tangents[here]
                off = np.linalg.norm(tangents[:, :3] - theirs.mesh.tangents[k, :3], axis=1)
                assert off.min() < 1.5 * np.sqrt(3) / 8192
                assert theirs.mesh.tangents[k, 3] in tangents[:, 3]
            if theirs.mesh.uv is not None:
                assert np.abs(ours.mesh.uv[here] - theirs.mesh.uv[k]).max(axis=1).min() <= 2.0**-17
                seen += 1
    assert seen > 300


def test_stored_again_nothing_moves(tmp_path, stored):
    """What lies on the grid stays there; normals and colours may round once more, by no more than the first time."""
    once = open_pem(stored)
    save_pem(tmp_path / "again", once)
    twice = open_pem(tmp_path / "again")
    for a, b in zip(once.scene.parts, twice.scene.parts, strict=True):
        np.testing.assert_array_equal(a.mesh.positions, b.mesh.positions)
        np.testing.assert_allclose(a.mesh.normals, b.mesh.normals, atol=np.sqrt(3) / 8192)
    np.testing.assert_allclose(once.irradiance.radiosity, twice.irradiance.radiosity, rtol=1 / 64, atol=1e-4)


def test_other_programs_read_the_coded_scene(stored):
    """The reader of glTF files, which knows nothing of PEMs."""
    back = open_pem(stored)
    parts = read_gltf(stored / "scene.gltf")
    for ours, theirs in zip(back.scene.parts, parts, strict=True):
        np.testing.assert_array_equal(ours.mesh.positions, theirs.mesh.positions)
        np.testing.assert_array_equal(ours.mesh.triangles, theirs.mesh.triangles)


def plate(low, high, name="plate", **fields):
    """A rectangle in x and y as two triangles."""
    (a, b), (c, d) = low, high
    positions = np.array([[a, b, 0], [c, b, 0], [c, d, 0], [a, d, 0]], np.float32)
    mesh = Mesh(
        positions, np.tile(np.float32([0, 0, 1]), (4, 1)), np.array([[0, 1, 2], [0, 2, 3]], np.uint32), **fields
    )
    return Part(name, mesh, Material(name), reflective=True)


def stored_scene(*parts):
    scene = Scene(parts, (ReflectiveObject("all", tuple(p for p, part in enumerate(parts) if part.reflective)),))
    triangles = scene.triangle_offsets[-1]
    dark = IrradianceMap(np.zeros(triangles, np.uint32), np.zeros(triangles, np.uint32), np.zeros((0, 3), np.float32))
    return compacted(scene, dark, np.zeros(triangles, bool), None, traced=True).scene


def test_parts_that_meet_still_meet():
    """One eight times as large as the other: vertices that lay in one place lie in one place."""
    seam = (0.1234567, 0.7654321), (0.2345678, 0.9876543)
    small, large = plate(*seam), plate((0.1234567, -3.0), (5.4321, 0.7654321), "large")
    a, b = (part.mesh.positions for part in stored_scene(small, large).parts)
    corner = np.float32([0.1234567, 0.7654321, 0])
    found = [mesh[np.abs(mesh - corner).max(axis=1) < 1e-3] for mesh in (a, b)]
    np.testing.assert_array_equal(*found)


@pytest.mark.parametrize("scale", [1e-4, 1e4])
def test_parts_of_extreme_sizes_keep_their_shape(scale):
    """10⁴ times smaller: within 2⁻¹¹ of its own extent (half a step of 10 bits, the rest for where the power of two
    falls); 10⁴ times larger: what 24 bits hold."""
    parts = stored_scene(
        plate((0.1, 0.2), (0.9, 0.8)), plate((0.3 * scale, 0.1 * scale), (0.7 * scale, 0.4 * scale), "other")
    ).parts
    extent = 0.7 * scale
    lost = np.abs(np.sort(parts[1].mesh.positions[:, 0]) - np.float32([0.3, 0.3, 0.7, 0.7]) * np.float32(scale)).max()
    assert lost <= max(0.4 * scale * 2.0**-11, extent * 2.0**-22 if scale > 1 else 0.0)


def test_far_from_the_origin_positions_are_those_of_floats():
    """1 m at a distance of 10⁶ m: float32 itself is no finer than 1/16 m."""
    far = plate((1e6, 0.0), (1e6 + 1.0, 1.0))
    np.testing.assert_allclose(
        np.sort(stored_scene(far).parts[0].mesh.positions[:, 0]), [1e6, 1e6, 1e6 + 1, 1e6 + 1], atol=0.26
    )


@pytest.mark.parametrize("reach", [1.0, 37.0, 1e5])
def test_texture_coordinates_may_repeat(tmp_path, reach):
    """2⁻¹⁷ of a repeat while 24 bits hold that, beyond 2⁻²² of the largest."""
    picture = Texture(np.full((2, 2, 4), 200, np.uint8))
    uv = np.float32([[-0.3, 0.1], [reach, 0.1], [reach, 0.7], [-0.3, 0.7]])
    part = plate((0.0, 0.0), (1.0, 1.0), uv=uv)
    part = replace(part, material=replace(part.material, base_color_texture_srgb=picture))
    pem = small_pem(views=0)
    parts = (*pem.scene.parts, part)
    scene = replace(pem.scene, parts=parts)
    none = np.zeros(2, np.uint32)
    irradiance = replace(
        pem.irradiance,
        resolution=np.concatenate([pem.irradiance.resolution, none]),
        offset=np.concatenate([pem.irradiance.offset, none]),
    )
    save_pem(
        tmp_path / "pem", replace(pem, scene=scene, irradiance=irradiance, on_hull=np.append(pem.on_hull, [False] * 2))
    )
    back = open_pem(tmp_path / "pem").scene.parts[-1].mesh
    order = np.lexsort(np.round(back.positions, 3).T[:2]), np.lexsort(np.round(part.mesh.positions, 3).T[:2])
    np.testing.assert_allclose(back.uv[order[0]], uv[order[1]], atol=max(2.0**-17, reach * 2.0**-22))


def test_odd_triangles_come_back():
    """One alone, one twice, ones with a corner twice: whatever the code turns around, the order is kept."""
    for triangles in ([[0, 1, 2]], [[2, 1, 0], [2, 1, 0]], [[0, 0, 1], [1, 2, 1], [2, 2, 2]]):
        given = np.array(triangles, np.uint32)
        back = as_decoded(Mesh(np.eye(3, dtype=np.float32), np.eye(3, dtype=np.float32), given))
        assert all(any((np.roll(a, turn) == b).all() for turn in range(3)) for a, b in zip(given, back, strict=True))


def test_the_corner_whose_handedness_counts_stays_first():
    """Where a triangle's corners differ in it: the first one's is that of all (CONVENTIONS.md)."""
    corners = np.eye(6, 3, dtype=np.float32)
    tangents = np.ones((6, 4), np.float32)
    plain = Mesh(corners, corners, np.array([[0, 1, 2], [1, 3, 4], [2, 4, 5]], np.uint32), tangents=tangents)
    assert as_decoded(plain)[1].tolist() == [3, 4, 1]  # turned, where it does not count
    mixed = replace(plain, tangents=np.where(np.arange(6)[:, None] == 4, [[1, 1, 1, -1]], tangents).astype(np.float32))
    np.testing.assert_array_equal(as_decoded(mixed), mixed.triangles)


def test_scene_files_cut_anywhere_are_one_sentence(stored, tmp_path):
    shutil.copytree(stored, tmp_path / "pem")
    for name in ("scene.bin", "surface.bin", "bvh.bin"):
        whole = (stored / name).read_bytes()
        for length in np.linspace(0, len(whole) - 5, 6).astype(int):
            (tmp_path / "pem" / name).write_bytes(whole[:length])
            with pytest.raises(RefletError, match="truncated or damaged"):
                open_pem(tmp_path / "pem")
        (tmp_path / "pem" / name).write_bytes(whole)


@pytest.mark.parametrize(
    "lie", [{"count": 2**34}, {"count": 3}, {"byteStride": 4}, {"byteLength": 9}, {"mode": "INDICES"}]
)
def test_lies_of_meshes_are_one_sentence(stored, tmp_path, lie):
    shutil.copytree(stored, tmp_path / "pem")
    document = json.loads((stored / "scene.gltf").read_text())
    document["bufferViews"][0]["extensions"]["EXT_meshopt_compression"].update(lie)
    (tmp_path / "pem" / "scene.gltf").write_text(json.dumps(document))
    with pytest.raises(RefletError, match=r"truncated or damaged|is damaged"):
        open_pem(tmp_path / "pem")


def test_the_compact_form_is_small(tmp_path, pem, stored):
    """A quarter of the plain one: 8 to 12 bytes of a vertex's 24 to 48, 2 of a triangle's 12, 3 of a colour's 12."""
    save_pem(tmp_path / "plain", pem, codec="none")
    sizes = [sum((f / name).stat().st_size for name in ("scene.bin", "surface.bin", "bvh.bin"))
             for f in (stored, tmp_path / "plain")]  # fmt: skip
    assert sizes[0] < sizes[1] / 4
