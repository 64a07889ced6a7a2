"""A PEM's folder: it comes back as it was, opens elsewhere, survives being killed, refuses what it does not know."""

import json
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from small_pem import same, small_pem

from reflet.envmap.geometry import Box, Ellipsoid, Hemisphere, InfiniteSphere, Sphere
from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS
from reflet.envmap.relief import Relief
from reflet.envmap.shapes import FAR_AWAY
from reflet.errors import RefletError
from reflet.files.textures.ktx2 import HALF_MAX
from reflet.pem.arrays import BufferWriter
from reflet.pem.container import PemWriter, open_pem, save_pem
from reflet.pem.geometry_json import geometry_from_json, geometry_to_json
from reflet.report.table import pem_table
from reflet.scene.bvh.build import build_bvh

save_plain = partial(save_pem, codec="none")  # where every number comes back; test_compact.py: what is coded

EXTENSION = "REFLET_parameterized_environment_map"


@pytest.fixture(scope="module")
def pem():
    return small_pem()


@pytest.fixture
def folder(tmp_path, pem):
    save_plain(tmp_path / "pem", pem)
    return tmp_path / "pem"


@pytest.mark.parametrize("with_environment", [True, False])
def test_everything_comes_back(tmp_path, with_environment):
    pem = small_pem(with_environment=with_environment)
    save_plain(tmp_path / "pem", pem)
    back = open_pem(tmp_path / "pem")
    for name in ("scene", "irradiance", "space", "layers", "on_hull", "lod_bias", "sample_count", "statistics"):
        assert same(getattr(pem, name), getattr(back, name)), name


def test_the_tree_comes_back(tmp_path, pem):
    """Given or built when it is written; without hits there is none."""
    bvh = build_bvh(pem.scene, pem.on_hull)
    save_plain(tmp_path / "given", replace(pem, most_hits=5, bvh=bvh))
    save_plain(tmp_path / "built", replace(pem, most_hits=5))
    for name in ("given", "built"):
        back = open_pem(tmp_path / name)
        assert back.most_hits == 5
        assert same(back.bvh, bvh)
    save_plain(tmp_path / "none", replace(pem, bvh=bvh))
    assert open_pem(tmp_path / "none").bvh is None
    assert not (tmp_path / "none" / "bvh.bin").exists()
    of_a_triangle = (tmp_path / "given" / "bvh.bin").stat().st_size / len(bvh.order)
    assert of_a_triangle <= 14  # 4 for its number, 8 for directions, 1 or 2 for nodes


def test_companions_come_back(tmp_path, pem):
    """Those that are written, whatever a reader would choose; without any, nothing is said of them."""
    ball, knob, room, lamp = pem.scene.parts
    low = replace(lamp, mesh=replace(lamp.mesh, positions=lamp.mesh.positions * np.float32(0.6)))
    scene = replace(pem.scene, parts=(ball, knob, room, low))
    save_plain(tmp_path / "low", replace(pem, scene=scene, most_hits=5))
    back = open_pem(tmp_path / "low")
    assert back.companions == back.bvh.companions == (3,) and back.traced_parts == (0, 1, 3)
    assert "lamp" in pem_table(back).split("met beside them")[1].splitlines()[0]
    bvh = build_bvh(pem.scene, pem.on_hull)
    save_plain(tmp_path / "without", replace(pem, scene=scene, most_hits=5, bvh=bvh))
    assert open_pem(tmp_path / "without").companions == ()
    assert "companions" not in (tmp_path / "without" / "scene.gltf").read_text()


@pytest.mark.parametrize("name", PARAMETERIZATIONS)
def test_maps_come_back_to_half_precision(tmp_path, name):
    pem = small_pem(parameterization=PARAMETERIZATIONS[name])
    save_plain(tmp_path / "pem", pem)
    back = open_pem(tmp_path / "pem")
    assert back.layers == pem.layers
    assert len(back.maps) == len(pem.maps)
    assert back.fade_deg == pem.fade_deg
    for ours, theirs in zip([*pem.maps, pem.base], [*back.maps, back.base], strict=True):
        for a, b in zip(ours, theirs, strict=True):
            assert (a.chain, a.geometry) == (b.chain, b.geometry)
            np.testing.assert_array_equal(a.texels.astype(np.float16).astype(np.float32), b.texels)


@pytest.mark.parametrize("shells", [2, 3])
def test_shells_come_back(tmp_path, shells):
    pem = small_pem(shells=shells)
    save_plain(tmp_path / "pem", pem)
    back = open_pem(tmp_path / "pem")
    assert back.layers == pem.layers
    assert [env_map.texels.shape[1] for env_map in back.base] == [4] * (shells - 1) + [3]
    assert [env_map.texels.shape[1] for env_map in back.maps[1]] == [4] * (shells - 1) + [3, 4, 4]


def test_a_pem_may_have_no_samples(tmp_path):
    pem = small_pem(views=0, shells=2)
    save_plain(tmp_path / "pem", pem)
    back = open_pem(tmp_path / "pem")
    assert len(back.maps) == 0
    assert back.space == pem.space
    assert back.base_share({"azimuth_deg": 10.0, "elevation_deg": 20.0, "distance": 2.0}) == 1.0


def test_maps_are_a_sequence(folder):
    maps = open_pem(folder).maps
    assert same(maps[-1], maps[len(maps) - 1])
    assert same(tuple(maps[1:]), (maps[1], maps[2]))
    with pytest.raises(IndexError):
        maps[3]


def test_opens_by_the_name_of_its_scene(folder):
    assert same(open_pem(folder / "scene.gltf").scene, open_pem(folder).scene)


@pytest.mark.parametrize(
    "geometry",
    [
        InfiniteSphere(),
        Sphere((0.0, 1.0, 0.0), (2.0, 2.0, 2.0), (0.1, 0.2, 0.3)),
        Ellipsoid((0.0, 1.0, 0.0), (2.0, 3.0, 4.0), (0.1, 0.2, 0.3)),
        Box((-1.0, 0.0, -1.0), (1.0, 2.0, 1.0), (0.1, 0.2, 0.3)),
        Hemisphere((0.0, 1.0, 0.0), (2.0, 3.0, 4.0), -0.5, (0.1, 0.2, 0.3)),
        Relief(np.arange(96, dtype=np.float16).reshape(6, 4, 4), (-1.0,) * 3, (FAR_AWAY,) * 3, (0.1, 0.2, 0.3)),
    ],
)
def test_geometries_come_back(tmp_path, geometry):
    buffer = BufferWriter("maps.bin")
    buffer.add(np.zeros(3, np.uint8))  # something else in the same file
    described = json.loads(json.dumps(geometry_to_json(geometry, buffer)))
    buffer.write(tmp_path)
    assert geometry_from_json(described, tmp_path) == geometry


def test_equal_pems_give_equal_folders(tmp_path, folder):
    save_plain(tmp_path / "again", small_pem())
    files = sorted(path.relative_to(folder) for path in folder.rglob("*") if path.is_file())
    assert files == sorted(p.relative_to(tmp_path / "again") for p in (tmp_path / "again").rglob("*") if p.is_file())
    assert all((folder / file).read_bytes() == (tmp_path / "again" / file).read_bytes() for file in files)


def test_other_programs_read_the_scene(folder, pem):
    """trimesh knows nothing of us: it finds the same triangles in the same places."""
    trimesh = pytest.importorskip("trimesh")
    seen = trimesh.load(folder / "scene.gltf", process=False)
    for part in pem.scene.parts:
        mesh = seen.geometry[part.name]
        np.testing.assert_array_equal(mesh.vertices.astype(np.float32), part.mesh.positions)
        np.testing.assert_array_equal(mesh.faces, part.mesh.triangles)


def test_very_bright_maps_are_clamped_not_infinite(tmp_path, pem):
    bright = pem.maps[0][0].texels.copy()
    bright[5] = 1e9
    writer = PemWriter(tmp_path / "pem", {})
    maps = (type(pem.maps[0][0])(pem.maps[0][0].chain, bright, pem.maps[0][0].geometry), *pem.maps[0][1:])
    writer.write_sample(0, pem.layers, maps)
    finish(writer, small_pem(views=1))
    assert (open_pem(tmp_path / "pem").maps[0][0].texels[5] == HALF_MAX).all()


def finish(writer, pem):
    writer.finish(
        scene=pem.scene,
        irradiance=pem.irradiance,
        space=pem.space,
        layers=pem.layers,
        on_hull=pem.on_hull,
        lod_bias=pem.lod_bias,
        sample_count=pem.sample_count,
    )


def test_a_bake_goes_on_where_it_was_stopped(tmp_path, pem):
    folder, parameters = tmp_path / "pem", {"em_size": 16, "target": (0.0, 0.1, 0.0)}
    writer = PemWriter(folder, parameters)
    writer.write_sample(1, pem.layers, pem.maps[1], {"iterations": 5})
    writer.save_state("irradiance", radiosity=pem.irradiance.radiosity)
    first = (folder / "maps/0001/0-balls.avif").read_bytes()
    (folder / "maps/0001/.0-balls.abc.tmp.avif").write_bytes(b"half a fi")  # what a killed writer leaves behind
    with pytest.raises(RefletError, match="unfinished bake"):
        open_pem(folder)

    again = PemWriter(folder, parameters, resume=True)
    assert [again.has(sample) for sample in range(3)] == [False, True, False]
    assert not again.finished
    np.testing.assert_array_equal(again.load_state("irradiance")["radiosity"], pem.irradiance.radiosity)
    assert again.load_state("probes") is None
    with pytest.raises(RefletError, match="lacks the maps of sample 0"):
        finish(again, pem)
    for sample in (0, 2):
        again.write_sample(sample, pem.layers, pem.maps[sample])
    finish(again, pem)
    assert again.finished
    assert (folder / "maps/0001/0-balls.avif").read_bytes() == first
    assert open_pem(folder).statistics == {"samples": [{}, {"iterations": 5}, {}]}
    assert not list(folder.rglob(".*")) and not (folder / "work").exists()


def test_a_sample_half_written_is_no_sample(tmp_path, pem):
    """Killed between two maps of a sample: the sample counts as missing."""
    writer = PemWriter(tmp_path / "pem", {})
    with pytest.raises(RefletError):
        bad = type(pem.maps[0][2])(pem.maps[0][2].chain, pem.maps[0][2].texels * np.nan, pem.maps[0][2].geometry)
        writer.write_sample(0, pem.layers, (*pem.maps[0][:2], bad))
    assert (tmp_path / "pem/maps/0000/1-ball.avif").exists()
    assert not writer.has(0)


def test_other_parameters_are_refused(tmp_path):
    PemWriter(tmp_path / "pem", {"em_size": 256, "spp": 64})
    with pytest.raises(RefletError, match="begun with em_size 256, not 128"):
        PemWriter(tmp_path / "pem", {"em_size": 128, "spp": 64}, resume=True)
    with pytest.raises(RefletError, match="already holds a bake"):
        PemWriter(tmp_path / "pem", {"em_size": 256, "spp": 64})


def test_a_folder_of_something_else_is_left_alone(tmp_path):
    (tmp_path / "thesis.tex").write_text("dear")
    with pytest.raises(RefletError, match="not a bake's"):
        PemWriter(tmp_path, {})
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.tex"]


def _edit(folder, change):
    document = json.loads((folder / "scene.gltf").read_text())
    change(document)
    (folder / "scene.gltf").write_text(json.dumps(document))


@pytest.mark.parametrize(
    ("damage", "said"),
    [
        (lambda f: (f / "scene.gltf").write_text((f / "scene.gltf").read_text()[:-9]), "truncated or damaged"),
        (lambda f: (f / "scene.bin").write_bytes(b"0" * 100), "truncated or damaged"),
        (lambda f: (f / "surface.bin").unlink(), "does not exist"),
        (lambda f: (f / "textures/0.png").write_bytes(b"\x89PNG"), "missing or damaged"),
        (lambda f: (f / "maps/base/0-balls.ktx2").unlink(), "does not exist"),
        (lambda f: _edit(f, lambda d: d["extensions"].pop(EXTENSION)), "plain glTF"),
        (lambda f: _edit(f, lambda d: d["extensions"][EXTENSION].update(version=99)), "version 99"),
        (lambda f: _edit(f, lambda d: d["extensions"][EXTENSION].pop("layers")), "damaged"),
        (lambda f: _edit(f, lambda d: d["extensions"][EXTENSION]["layers"][0].update(end=2.0)), "damaged .*shells"),
        (lambda f: _edit(f, lambda d: d["extensions"][EXTENSION]["layers"][0].update(begin=2.0)), "damaged .*shells"),
        (lambda f: _edit(f, lambda d: d["extensions"][EXTENSION].update(samples=[], base=[])), "neither samples nor"),
        (lambda f: _edit(f, lambda d: d["extensions"][EXTENSION]["base"].append("x.ktx2")), "damaged"),
        (
            lambda f: (f / "maps/base/0-balls.ktx2").write_bytes((f / "maps/0000/1-ball.ktx2").read_bytes()),
            "is a cube of 8 rows, not the cube of 16",
        ),
        (lambda f: _edit(f, lambda d: d["extensions"][EXTENSION]["layers"][0]["geometry"].pop("lower")), "damaged"),
    ],
)
def test_damage_is_one_sentence(folder, damage, said):
    damage(folder)
    with pytest.raises(RefletError, match=said):
        open_pem(folder)


def test_too_many_hits_are_refused(tmp_path, pem):
    with pytest.raises(RefletError, match="0 to 64 hits, not 65"):
        save_plain(tmp_path / "pem", replace(pem, most_hits=65))
    assert not (tmp_path / "pem" / "scene.gltf").exists()


def _word(name, number, value):
    """Damage: one number of an array of the tree becomes another."""

    def damage(folder):
        document = json.loads((folder / "scene.gltf").read_text())
        array = document["extensions"][EXTENSION]["traced"][name]
        data = bytearray((folder / "bvh.bin").read_bytes())
        size = {5121: 1, 5125: 4}[array["componentType"]]
        at = array["byteOffset"] + size * (number % array["shape"][0])
        data[at : at + size] = value.to_bytes(size, "little")
        (folder / "bvh.bin").write_bytes(data)

    return damage


@pytest.mark.parametrize(
    ("damage", "said"),
    [
        (lambda f: (f / "bvh.bin").unlink(), "does not exist"),
        (lambda f: (f / "bvh.bin").write_bytes((f / "bvh.bin").read_bytes()[:-4]), "truncated or damaged"),
        (_word("order", 0, 2**31), "damaged .*other triangles"),
        (_word("leafCounts", 0, 3), "damaged .*no tree"),  # the root a leaf, and more nodes behind it
        (_word("leafCounts", -1, 0), "damaged .*no tree"),
        (lambda f: _traced(f, mostHits=0), "damaged .*1 to 64 hits"),
        (lambda f: _traced(f, mostHits=2.5), "damaged .*1 to 64 hits"),
        (lambda f: _traced(f, mostHits=True), "damaged .*1 to 64 hits"),
        (lambda f: _traced(f, order={}), "damaged"),
        (lambda f: _traced(f, companions=[2]), "damaged .*other triangles"),
        (lambda f: _traced(f, companions=[0]), "damaged .*do not reflect"),
        (lambda f: _traced(f, companions=[4]), "damaged .*do not reflect"),
        (lambda f: _traced(f, companions=[2.0]), "damaged .*do not reflect"),
        (lambda f: _traced(f, companions=3), "damaged"),
        (lambda f: _array(f, "leafCounts", shape=[3]), "damaged .*no tree"),
        (lambda f: _array(f, "directions", shape=[3, 2]), "damaged .*other triangles"),
        (lambda f: _array(f, "order", componentType=5126), "damaged .*other types"),
    ],
)
def test_a_damaged_tree_is_one_sentence(tmp_path, pem, damage, said):
    save_plain(tmp_path, replace(pem, most_hits=3))
    damage(tmp_path)
    with pytest.raises(RefletError, match=said):
        open_pem(tmp_path)


def _traced(folder, **members):
    _edit(folder, lambda d: d["extensions"][EXTENSION]["traced"].update(members))


def _array(folder, name, **members):
    _edit(folder, lambda d: d["extensions"][EXTENSION]["traced"][name].update(members))


def test_a_missing_map_is_one_sentence_when_it_is_asked_for(folder):
    maps = open_pem(folder).maps
    (folder / "maps/0001/1-ball.ktx2").unlink()
    assert len(maps[0]) == 3
    with pytest.raises(RefletError, match=r"1-ball\.ktx2 does not exist"):
        maps[1]


def test_a_folder_without_a_pem_is_one_sentence(tmp_path):
    with pytest.raises(RefletError, match=r"nowhere does not exist"):
        open_pem(tmp_path / "nowhere")


def test_a_local_layer_has_no_relief(tmp_path, pem):
    """Shaders search the distant layers' reliefs only."""
    relief = next(each.geometry for each in small_pem(shells=2).layers if isinstance(each.geometry, Relief))
    local = next(layer for layer in pem.layers if layer.kind == "local")
    with pytest.raises(ValueError, match="local layer is a shape"):
        replace(local, geometry=relief)
    save_plain(tmp_path / "pem", small_pem(shells=2))

    def swap(document):
        layers = document["extensions"][EXTENSION]["layers"]
        layers[-1]["geometry"] = next(layer["geometry"] for layer in layers if layer["geometry"]["kind"] == "relief")

    _edit(tmp_path / "pem", swap)
    with pytest.raises(RefletError, match="local layer is a shape"):
        open_pem(tmp_path / "pem")


def test_the_description_stays_the_same_and_short(tmp_path, pem):
    """Lists of numbers take a line, whatever names hold: nothing in a name is taken for a list."""
    odd = 'a [ b\n]{\n "c": [1,\n 2] }'
    parts = (replace(pem.scene.parts[0], name=odd), *pem.scene.parts[1:])
    save_plain(tmp_path / "pem", replace(pem, scene=replace(pem.scene, parts=parts)))
    text = (tmp_path / "pem" / "scene.gltf").read_text()
    assert json.loads(text)["nodes"][0]["name"] == odd
    assert '"nodes": [0, 1, 2, 3]' in text and '{"name": "knob", "mesh": 1}' in text
