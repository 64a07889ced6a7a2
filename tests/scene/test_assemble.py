import warnings
from dataclasses import replace

import numpy as np
import pytest

from reflet.errors import RefletError, RefletWarning
from reflet.scene.assemble import assemble
from reflet.scene.builtin.solids import box
from reflet.scene.material import MIRROR, EnvironmentLight, Material, Refraction, Texture
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.meshes.touching import touch
from reflet.scene.scene import Part
from reflet.scene.surface_mean import surface_mean, surface_points

SKY = EnvironmentLight(np.ones((2, 4, 3), np.float32))
PAINT = Material("paint", metallic=0.0)


def cube(centre=(0.0, 0.0, 0.0), size=1.0):
    solid = box(centre, (size, size, size), 0)
    triangles = np.arange(len(solid.corners), dtype=np.uint32).reshape(-1, 3)
    at, normals, uv = (np.asarray(x, np.float32) for x in (solid.corners, solid.normals, solid.uv))
    return Mesh(at, normals.copy(), triangles, uv)


def triangle(*corners):
    at = np.array(corners, np.float32)
    return Mesh(at, np.tile(np.float32([0, 1, 0]), (3, 1)), np.array([[0, 1, 2]], np.uint32))


def test_metals_reflect_and_the_rest_does_as_far_as_it_is_smooth():
    varnish = replace(PAINT, perceptual_roughness=0.2)
    satin = replace(PAINT, perceptual_roughness=0.25)
    materials = {"mirror": MIRROR, "matt": Material(), "varnish": varnish, "satin": satin, "paint": PAINT}
    parts = [Part(n, cube((3.0 * k, 0, 0)), m) for k, (n, m) in enumerate(materials.items())]
    lamp = Part("lamp", cube((0, 9.0, 0)), Material(metallic=0.0, emission=(1.0, 1.0, 1.0)))
    scene = assemble([*parts, lamp])  # without a warning: each by its own lobe
    assert [part.reflective for part in scene.parts] == [True, True, True, False, False, False]
    assert [part.material.perceptual_roughness for part in scene.parts[:3]] == [0.0, 1.0, 0.2]
    assert scene.object_of_part == (0, 1, 2, -1, -1, -1)


def test_under_an_environment_a_model_reflects_and_its_surroundings_do_not():
    """Walls three times as large as all of the metal; lamps."""
    cloth = replace(PAINT, perceptual_roughness=1.0)
    lamp = replace(cloth, emission=(1.0, 1.0, 1.0))
    materials = {"screw": MIRROR, "seat": cloth, "lamp": lamp, "sign": replace(lamp, unlit=True)}
    parts = [Part(n, cube((1.5 * k, 0, 0)), m) for k, (n, m) in enumerate(materials.items())]
    large = cube()
    walls = Part("walls", replace(large, positions=3.0 * large.positions), cloth)
    under_sky, lit = (assemble([*parts, walls], environment=environment) for environment in (SKY, None))
    assert [part.reflective for part in under_sky.parts] == [True, True, False, False, False]
    assert [part.reflective for part in lit.parts] == [True, False, False, False, False]


def test_where_nothing_reflects_all_there_is_does():
    cloth = replace(PAINT, perceptual_roughness=1.0)
    lamp = replace(cloth, emission=(1.0, 1.0, 1.0))
    materials = {"a": cloth, "lamp": lamp, "b": cloth, "c": replace(lamp, unlit=True)}
    parts = [Part(n, cube((3.0 * k, 0, 0)), m) for k, (n, m) in enumerate(materials.items())]
    for environment in (SKY, None):
        assert [part.reflective for part in assemble(parts, environment=environment).parts] == [True] * 3 + [False]
    with pytest.raises(RefletError, match="all are unlit or left out; choose with --reflect NAME from c"):
        assemble(parts[3:], environment=SKY)


def test_glass_reflects_and_rough_glass_is_said_to_be_clear():
    clear = Material("clear", metallic=0.0, perceptual_roughness=0.0, refraction=Refraction())
    frosted = replace(clear, name="frosted", perceptual_roughness=0.5)
    parts = [Part(n, cube((3.0 * k, 0, 0)), m) for k, (n, m) in enumerate({"pane": clear, "door": frosted}.items())]
    with pytest.warns(RefletWarning) as said:
        scene = assemble(parts, environment=SKY)
    assert [str(word.message) for word in said] == ["Baked as clear glass whatever their roughness: door (0.50)."]
    assert [part.reflective for part in scene.parts] == [True, True]


def test_names_are_forced_whatever_their_case_and_with_stars():
    parts = [Part(n, cube((3.0 * k, 0, 0)), PAINT) for k, n in enumerate(("Vase left", "Vase right", "Table"))]
    scene = assemble(parts, environment=SKY, reflect=["vase*"])
    assert [part.reflective for part in scene.parts] == [True, True, False]
    left = assemble(parts, environment=SKY, reflect=["none-of vase*"])
    assert [part.reflective for part in left.parts] == [False, False, True]
    with pytest.raises(
        RefletError, match="No part reflects: all are unlit or left out; choose with --reflect NAME from V"
    ):
        assemble(parts, environment=SKY, reflect=["none-of *"])
    with pytest.raises(RefletError, match="No part is named lamp; --reflect can name Vase left, Vase right, Table"):
        assemble(parts, environment=SKY, reflect=["lamp"])


def test_names_become_unique():
    names = ["a", "A", "a", "", "a_2", "a", "a_2"]
    scene = assemble([Part(n, cube((3.0 * k, 0, 0)), MIRROR) for k, n in enumerate(names)], environment=SKY)
    assert [part.name for part in scene.parts] == ["a", "A_2", "a_3", "part", "a_2_2", "a_4", "a_2_3"]


def test_light_is_asked_for():
    with pytest.raises(RefletError, match="--environment"):
        assemble([Part("a", cube(), MIRROR)])
    dark = Texture(np.zeros((1, 1, 4), np.uint8))
    with pytest.raises(RefletError, match="--environment"):
        assemble([Part("a", cube(), replace(MIRROR, emission=(1.0, 1.0, 1.0), emission_texture_srgb=dark))])
    assert assemble([Part("a", cube(), replace(MIRROR, emission=(0.0, 0.1, 0.0)))]).environment is None


@pytest.mark.parametrize(("gap", "objects"), [(-0.2, 1), (0.0, 1), (0.02, 1), (0.2, 2)])
def test_what_touches_is_one_object(gap, objects):
    """Boxes 1 m wide whose corners are far from one another: crossing, touching, almost, and apart."""
    parts = [Part("a", cube(), MIRROR), Part("b", cube((1.0 + gap, 0.3, 0.2)), MIRROR)]
    assert len(assemble(parts, environment=SKY).objects) == objects


def test_only_neighbours_are_looked_at_closely(monkeypatch):
    """Instances come in thousands: of 30 cubes in a row, each a touch from the next, 29 pairs are worth a look."""
    looked = []
    monkeypatch.setattr("reflet.scene.assemble.touch", lambda a, b, tolerance: looked.append(tolerance) or False)
    scene = assemble([Part("c", cube((1.01 * k, 0, 0)), MIRROR) for k in range(30)], environment=SKY)
    assert len(looked) == 29 and len(scene.objects) == 30


def test_touching_is_transitive_and_shells_of_one_part_stay_together():
    apart = cube((50.0, 0, 0))
    both = Mesh(np.concatenate([cube().positions, apart.positions]), np.concatenate([cube().normals, apart.normals]),
                np.concatenate([cube().triangles, apart.triangles + 36]))  # fmt: skip
    parts = [Part("a", both, MIRROR), Part("c", cube((2.0, 0, 0)), MIRROR), Part("b", cube((1.0, 0, 0)), MIRROR)]
    scene = assemble(parts, environment=SKY)
    assert [item.parts for item in scene.objects] == [(0, 1, 2)]


def test_distance_of_a_point_over_a_face_and_of_crossing_edges():
    """Closed forms: a triangle's tip over the middle of a large face, and two skew edges at a known distance."""
    floor = triangle((-5, 0, -5), (5, 0, -5), (0, 0, 8))
    tip = triangle((0, 0.5, 0), (0.3, 2, 0), (-0.3, 2, 0.1))
    ridge, wire = triangle((-1, 0, 0), (1, 0, 0), (0, -3, 0)), triangle((0, 0.5, -1), (0, 0.5, 1), (0, 4, 0))
    for a, b in ((floor, tip), (ridge, wire)):
        assert touch(a, b, 0.5 / 0.7) and touch(b, a, 0.5 / 0.7)  # promised up to 0.7 of the tolerance
        assert not touch(a, b, 0.499)


def test_texture_means_are_weighted_by_area():
    """Left half of the texture rough 1 and no metal, right half 0 and metal; 3/4 of the area wear the right half."""
    pixels = np.zeros((4, 8, 4), np.uint8)
    pixels[:, :4, 1], pixels[:, 4:, 2] = 255, 255
    at = np.float32([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [1, 0, 0], [4, 0, 0], [4, 1, 0], [1, 1, 0]])
    u = np.float32([0.01, 0.49, 0.49, 0.01, 0.51, 0.99, 0.99, 0.51])
    uv = np.column_stack([u, at[:, 1]]).astype(np.float32)
    mesh = Mesh(at, np.tile(np.float32([0, 0, 1]), (8, 1)),
                np.array([[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]], np.uint32), uv)  # fmt: skip
    material = Material(perceptual_roughness=0.8, metallic_roughness_texture=Texture(pixels))
    # 16384 stratified points: each half's count is exact to one point
    np.testing.assert_allclose(surface_mean(Part("a", mesh, material)), (0.75, 0.8 * 0.25), atol=1e-3)
    triangle_of, weights = surface_points(mesh, 8000)
    np.testing.assert_allclose(np.bincount(triangle_of) / 8000, [1 / 8, 1 / 8, 3 / 8, 3 / 8], atol=1e-3)
    np.testing.assert_allclose(weights.mean(axis=0), 1.0 / 3.0, atol=0.005)  # low discrepancy: about 1/√8000 at worst
    assert (weights >= 0.0).all()


def test_zero_area_triangles_and_unused_vertices_are_dropped():
    mesh = cube()
    spoilt = replace(mesh, triangles=np.vstack([[[0, 0, 1], [0, 1, 1]], mesh.triangles[:-2]]).astype(np.uint32))
    with pytest.warns(RefletWarning, match="2 triangles without area"):
        scene = assemble([Part("a", spoilt, MIRROR)], environment=SKY)
    kept = scene.parts[0].mesh
    assert len(kept.triangles) == 10 and len(kept.positions) == 30
    np.testing.assert_array_equal(kept.positions[kept.triangles], mesh.positions[mesh.triangles[:-2]])
    with pytest.raises(RefletError, match="holds no triangles"), warnings.catch_warnings():
        warnings.simplefilter("ignore", RefletWarning)
        assemble([Part("a", replace(mesh, triangles=np.array([[0, 0, 1]], np.uint32)), MIRROR)], environment=SKY)


def test_normals_without_length_become_the_faces_and_others_unit():
    mesh = cube()
    normals = mesh.normals * 3.0
    normals[:3] = 0.0
    scene = assemble([Part("a", replace(mesh, normals=normals), MIRROR)], environment=SKY)
    np.testing.assert_allclose(scene.parts[0].mesh.normals, mesh.normals, atol=1e-6)


def test_large_meshes_are_checked_block_by_block():
    """20000 triangles apart, of which number 17000 has no area and number 18000 a corner without a normal."""
    count = 20000
    at = np.tile(np.float32([[0, 0, 0], [1, 0, 0], [0, 1, 0]]), (count, 1))
    at[:, 2] = np.repeat(np.arange(count), 3)
    normals = np.tile(np.float32([0, 0, 2]), (3 * count, 1))
    at[3 * 17000 + 1] = at[3 * 17000]
    normals[3 * 18000] = 0
    triangles = np.arange(3 * count, dtype=np.uint32).reshape(-1, 3)
    with pytest.warns(RefletWarning, match="1 triangles without area"):
        scene = assemble([Part("stack", Mesh(at, normals, triangles), MIRROR)], environment=SKY)
    (part,) = scene.parts
    kept = np.delete(at, slice(3 * 17000, 3 * 17001), axis=0)
    np.testing.assert_array_equal(part.mesh.positions[part.mesh.triangles].reshape(-1, 3), kept)
    np.testing.assert_array_equal(part.mesh.normals, np.tile(np.float32([0, 0, 1]), (len(kept), 1)))


def test_impossible_geometry_is_refused():
    mesh = cube()
    for field in ("positions", "normals", "uv"):
        broken = getattr(mesh, field).copy()
        broken[3, 1] = np.nan
        with pytest.raises(RefletError, match=r"Part a .*not finite"):
            assemble([Part("a", replace(mesh, **{field: broken}), MIRROR)], environment=SKY)
    with pytest.raises(RefletError, match="vertex 99 of 36"):
        broken_triangles = np.array([[0, 1, 99]], np.uint32)
        assemble([Part("a", replace(mesh, triangles=broken_triangles), MIRROR)], environment=SKY)
    with pytest.raises(RefletError, match="holds no triangles"):
        assemble([], environment=SKY)


def test_what_is_matte_reflects_only_where_all_is_or_by_name():
    matte = Material(name="chalk", metallic=0.0, perceptual_roughness=0.0, specular=0.0)
    chalk, mirror = Part("chalk", cube(), matte), Part("ball", cube((3.0, 0, 0)), MIRROR)

    def chosen(*parts, **options):
        return {part.name for part in assemble(parts, environment=SKY, **options).parts if part.reflective}

    assert chosen(chalk, mirror) == {"ball"}
    assert chosen(chalk, mirror, reflect=["chalk"]) == {"chalk", "ball"}
    assert chosen(chalk) == {"chalk"}
