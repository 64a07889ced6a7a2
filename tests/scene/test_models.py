"""Real files: every one loads and assembles."""

import warnings
from pathlib import Path

import numpy as np
import pytest

from reflet.errors import RefletWarning
from reflet.scene.assemble import assemble
from reflet.scene.material import EnvironmentLight
from reflet.scene.meshes.corners import corner_tangents
from reflet.scene.readers.gltf.read import read_gltf
from reflet.scene.readers.obj.read import read_obj
from reflet.scene.surfaces.hull import hull_triangles
from reflet.scene.views.framing import check_camera, frame_orbit

DATA = Path(__file__).parents[3] / "shared" / "data"
SKY = EnvironmentLight(np.ones((2, 4, 3), np.float32))
MODELS = {  # triangles as the data's notes say
    "torus.glb": 1152, "spot.obj": 5856, "shaderball.glb": 88264,
    "Suzanne/Suzanne.gltf": 3936, "WaterBottle/WaterBottle.gltf": 4510,
    "boombox_nomat.glb": 6036, "IridescenceLamp.glb": 18866, "ClearCoatTest.glb": 37116,
    "NormalTangentMirrorTest.glb": 5240, "AnisotropyDiscTest.glb": 2788,
    "Ingenuity_decoded.glb": 9060,
}  # fmt: skip

pytestmark = pytest.mark.skipif(not DATA.exists(), reason="needs the shared data")


def read(name):
    path = DATA / name
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RefletWarning)
        return read_obj(path) if path.suffix == ".obj" else read_gltf(path)


@pytest.mark.parametrize("name", MODELS)
def test_models_assemble_without_options(name):
    parts = read(f"models/{name}")
    assert sum(len(part.mesh.triangles) for part in parts) == MODELS[name]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RefletWarning)
        scene = assemble(parts, environment=SKY)
    assert scene.objects and len({part.name for part in scene.parts}) == len(scene.parts)
    check_camera(scene, frame_orbit(scene).camera())


def test_bench_scene():
    scene = assemble(read("bench/teapot-bench.glb"))
    assert [len(item.parts) for item in scene.objects] == [4]
    lamp = next(part for part in scene.parts if part.name == "light")
    assert lamp.material.emission == (9.0, 9.0, 9.0)
    share = hull_triangles(scene)[scene.triangle_offsets[2] :].mean()
    assert 0.20 < share < 0.27  # 23 % of the triangles


@pytest.mark.parametrize("name", ["WaterBottle/WaterBottle.gltf", "NormalTangentMirrorTest.glb"])
def test_computed_tangents_agree_with_those_of_the_file(name):
    """The files' tangents come from MikkTSpace, mirrored mappings included."""
    mesh = read(f"models/{name}")[0].mesh
    corner = mesh.triangles.ravel()
    ours = corner_tangents(mesh.positions[corner], mesh.normals[corner].astype(float), mesh.uv[corner].astype(float))
    theirs = mesh.tangents[corner]
    assert (ours[:, 3] == theirs[:, 3]).mean() > 0.98
    agreement = np.einsum("ci,ci->c", ours[:, :3], theirs[:, :3])
    assert np.median(agreement) > 0.999 and (agreement > 0.9).mean() > 0.95  # exporters weld and split differently
