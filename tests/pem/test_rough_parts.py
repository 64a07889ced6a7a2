"""Rough parts in files: the table of their lobes, and what it means where it is missing."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from small_pem import small_pem
from surface_layers import random_surface

from reflet.errors import RefletError
from reflet.pem.reader import open_pem
from reflet.pem.writer import save_pem
from reflet.reflectance.materials.material import dfg_table

EXTENSION = "REFLET_parameterized_environment_map"


def saved(folder: Path, codec: str = "none") -> dict:
    save_pem(folder, small_pem(views=1), codec=codec)
    return json.loads((folder / "scene.gltf").read_bytes())


@pytest.mark.parametrize("codec", ["none", "av1"])
def test_maps_on_surfaces_are_kept(tmp_path: Path, codec: str) -> None:
    pem = small_pem(views=1)
    surface = random_surface(pem.scene, (1,), side=16)
    save_pem(tmp_path / "pem", replace(pem, surface=surface), codec=codec)
    back = open_pem(tmp_path / "pem").surface
    assert back is not None and back.light.dtype == np.float16 and open_pem(tmp_path / "pem").scene is not None
    if codec == "none":
        for name, value in vars(surface).items():
            np.testing.assert_array_equal(value, getattr(back, name))
    assert np.sort(back.resolution).tolist() == np.sort(surface.resolution).tolist()
    save_pem(tmp_path / "without", pem, codec=codec)
    assert open_pem(tmp_path / "without").surface is None


@pytest.mark.parametrize("change", ["side", "shape", "resolution", "site"])
def test_maps_that_do_not_belong_to_the_scene_are_damage(tmp_path: Path, change: str) -> None:
    pem = small_pem(views=1)
    surface = random_surface(pem.scene, (1,))
    if change == "resolution":
        surface = replace(surface, resolution=surface.resolution + np.uint32(1))
    if change == "site":
        surface = replace(surface, site=surface.site + np.uint32(50))
    save_pem(tmp_path / "pem", replace(pem, surface=surface), codec="none")
    path = tmp_path / "pem" / "scene.gltf"
    document = json.loads(path.read_text())
    stored = document["extensions"][EXTENSION]["surface"]
    if change == "side":
        stored["side"] = 4
    if change == "shape":
        stored["light"]["shape"][1:] = [32, 8]
    path.write_text(json.dumps(document))
    with pytest.raises(RefletError, match="damaged"):
        open_pem(tmp_path / "pem")


def test_the_table_is_written_where_a_part_is_rough(tmp_path: Path) -> None:
    at = saved(tmp_path / "pem")["extensions"][EXTENSION]["ggxTable"]
    data = (tmp_path / "pem" / at["uri"]).read_bytes()[at["byteOffset"] :]
    stored = np.frombuffer(data, np.float16, np.prod(at["shape"])).reshape(at["shape"])
    np.testing.assert_array_equal(stored.astype(np.float32), dfg_table())
    assert [part.material.perceptual_roughness for part in open_pem(tmp_path / "pem").scene.parts[:2]] == [0.0, 0.1]


def test_without_a_table_all_that_reflects_is_smooth(tmp_path: Path) -> None:
    """As it was baked before there were rough parts."""
    document = saved(tmp_path / "pem")
    del document["extensions"][EXTENSION]["ggxTable"]
    (tmp_path / "pem" / "scene.gltf").write_text(json.dumps(document))
    parts = open_pem(tmp_path / "pem").scene.parts
    assert [part.material.perceptual_roughness for part in parts if part.reflective] == [0.0, 0.0]
    assert parts[2].material.perceptual_roughness == 1.0  # what does not reflect keeps its own


def test_a_table_that_is_none_is_refused(tmp_path: Path) -> None:
    document = saved(tmp_path / "pem")
    document["extensions"][EXTENSION]["ggxTable"]["shape"] = [32, 192]
    (tmp_path / "pem" / "scene.gltf").write_text(json.dumps(document))
    with pytest.raises(RefletError, match="ggxTable"):
        open_pem(tmp_path / "pem")
