import numpy as np
import pytest

from reflet.errors import RefletError, RefletWarning
from reflet.scene.meshes.corners import crease_normals
from reflet.scene.readers.obj import read_obj

CUBE = """
v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1
f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 2 3 7 6\nf 1 5 8 4
"""


def write(folder, text, name="a.obj"):
    (folder / name).write_text(text)
    return folder / name


def test_a_cube_without_normals_keeps_its_edges(tmp_path):
    """Its edges turn by 90°, more than the crease angle: every normal is its face's, and every face is outwards."""
    (part,) = read_obj(write(tmp_path, CUBE))
    mesh = part.mesh
    assert len(mesh.triangles) == 12 and len(mesh.positions) == 24
    at = mesh.positions[mesh.triangles].astype(float)
    face = np.cross(at[:, 1] - at[:, 0], at[:, 2] - at[:, 0])
    assert (np.einsum("ti,ti->t", face, at.mean(axis=1)) > 0).all()
    np.testing.assert_allclose(mesh.normals[mesh.triangles], np.repeat(face[:, None] / 4.0, 3, axis=1), atol=1e-6)
    assert part.name == "a" and part.material.base_color == (0.65,) * 3 and part.material.perceptual_roughness == 0.0


def test_a_fine_sphere_without_normals_is_smooth(tmp_path):
    theta, phi = np.meshgrid(np.linspace(0.3, 2.8, 24), np.arange(48) * np.pi / 24, indexing="ij")
    at = np.stack([np.sin(theta) * np.cos(phi), np.cos(theta), -np.sin(theta) * np.sin(phi)], -1).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(23), np.arange(48), indexing="ij")
    a, b = i * 48 + j, i * 48 + (j + 1) % 48
    quads = np.stack([a, a + 48, b + 48, b], -1).reshape(-1, 4) + 1
    text = "\n".join("v {} {} {}".format(*p) for p in at) + "\n" + "\n".join("f {} {} {} {}".format(*q) for q in quads)
    smooth, flat = read_obj(write(tmp_path, text)), read_obj(write(tmp_path, "s off\n" + text))
    inner = np.abs(smooth[0].mesh.positions[:, 1]) < 0.9  # the open rims have faces on one side only
    turn = np.einsum("vi,vi->v", smooth[0].mesh.normals, smooth[0].mesh.positions)[inner]
    assert turn.min() > np.cos(np.radians(2.0))  # a facet spans 7.5°; its mean normal errs at second order
    assert len(smooth[0].mesh.positions) == len(at) and len(flat[0].mesh.positions) > 3 * len(at)


def test_crease_zero_is_flat():
    at = np.random.default_rng(0).random((9, 3))
    normals = crease_normals(at, 0.0).reshape(3, 3, 3)
    assert (normals == normals[:, :1]).all()


def test_indices_normals_and_texture_coordinates(tmp_path):
    text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 0.75\nvn 0 0 2\nf -3/-3/-1 -2/-2/-1 -1/-1/-1\n"
    (part,) = read_obj(write(tmp_path, text))
    np.testing.assert_array_equal(part.mesh.uv, [[0, 1], [1, 1], [0, 0.25]])  # an OBJ's v runs upwards
    np.testing.assert_array_equal(part.mesh.normals, [[0, 0, 1]] * 3)


def test_groups_and_materials_become_parts(tmp_path):
    write(tmp_path, "newmtl steel\nKd .5 .6 .7\nPm 1\nPr .1\nnewmtl glow\nKd 0 0 0\nKe 3 2 1\n", "m.mtl")
    faces = "usemtl steel\nf 1 2 3\nusemtl glow\nf 1 3 4\n"
    text = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\no lamp\n" + faces + "o shade\nusemtl steel\nf 1 2 3 4\n"
    parts = {part.name: part for part in read_obj(write(tmp_path, text))}
    assert set(parts) == {"lamp_steel", "lamp_glow", "shade"}
    steel = parts["shade"].material
    assert (steel.base_color, steel.metallic, steel.perceptual_roughness) == ((0.5, 0.6, 0.7), 1.0, 0.1)
    assert parts["lamp_glow"].material.emission == (3.0, 2.0, 1.0) and parts["lamp_glow"].material.metallic == 0.0
    assert len(parts["shade"].mesh.triangles) == 2


def test_missing_materials_are_mirrors_with_a_warning(tmp_path):
    with pytest.warns(RefletWarning, match="gold"):
        (part,) = read_obj(write(tmp_path, "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl gold\nf 1 2 3\n"))
    assert part.material.metallic == 1.0


@pytest.mark.parametrize("line", ["f 1 2 9", "f 0 1 2", "f 1 2 -7", "v 1 2", "v a b c", "f 1/x 2 3"])
def test_broken_files_are_refused(tmp_path, line):
    with pytest.raises(RefletError, match="no valid OBJ"):
        read_obj(write(tmp_path, f"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n{line}\n"))
    with pytest.raises(RefletError, match="cannot be read"):
        read_obj(tmp_path / "none.obj")
