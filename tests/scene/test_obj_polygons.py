"""Polygons of OBJ files: triangles of the right area, corners that keep what is theirs."""

import numpy as np
import pytest
from obj_files import area, silently, triangles, write

from reflet.errors import RefletWarning
from reflet.scene.readers.obj.read import read_obj

L_SHAPE = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]


POLYGONS = {
    "L": (L_SHAPE, 3.0),
    "dart": ([(0, 0), (2, -1), (0.5, 0), (2, 1)], 0.5),
    "arrow, tip second": ([(2, 1), (0, 0), (2, -1), (0.5, 0)], 0.5),
    "comb": ([(0, 0), (7, 0), (7, 3), (6, 3), (6, 1), (5, 1), (5, 3), (4, 3), (4, 1), (3, 1), (3, 3), (0, 3)], 17.0),
    "middle of an edge": ([(0, 0), (1, 0), (2, 0), (2, 2), (0, 2)], 4.0),
    "middle of the first edge": ([(1, 0), (2, 0), (2, 2), (0, 2), (0, 0)], 4.0),
    "quad with a middle": ([(1, 0), (2, 0), (0, 2), (0, 0)], 2.0),
    "a corner twice": ([(0, 0), (2, 0), (2, 0), (2, 2), (0, 2)], 4.0),
    "closed on the first": ([(0, 0), (2, 0), (2, 2), (0, 2), (0, 0)], 4.0),
    "keyhole": ([(0, 0), (4, 0), (4, 4), (0, 4), (0, 0), (1, 1), (1, 3), (3, 3), (3, 1), (1, 1)], 12.0),
    "regular": ([(np.cos(a), np.sin(a)) for a in np.arange(1000) * np.pi / 500], 500 * np.sin(np.pi / 500)),
}


@pytest.mark.parametrize(("outline", "right"), POLYGONS.values(), ids=POLYGONS)
@pytest.mark.parametrize("turned", [0, 1, 3])
def test_areas_of_polygons(tmp_path, outline, right, turned):
    """In any plane, in either winding and from any corner: the area, and every triangle faces the polygon's way."""
    rotation = np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))[0]
    for backwards in (False, True):
        corner = np.roll(outline[::-1] if backwards else outline, turned, axis=0)
        at = np.column_stack([corner, np.zeros(len(corner))]) @ rotation.T
        text = "\n".join("v {!r} {!r} {!r}".format(*p) for p in at.tolist()) + "\nf "
        (part,) = silently(read_obj, write(tmp_path, text + " ".join(map(str, range(1, len(at) + 1)))))
        assert area(part) == pytest.approx(right, rel=1e-5)  # positions are float32
        front = rotation[:, 2] * (-1 if backwards else 1)
        np.testing.assert_allclose(part.mesh.normals @ front, 1.0, atol=1e-6)


def test_polygons_that_are_not_flat(tmp_path):
    """A bent L: its triangles hang together along its outline, and none turns away from the mean of the surface."""
    text = "".join(f"v {x} {y} {0.1 * x * y}\n" for x, y in L_SHAPE) + "f 1 2 3 4 5 6\n"
    (part,) = silently(read_obj, write(tmp_path, text))
    at = triangles(part)
    normal = np.cross(at[:, 1] - at[:, 0], at[:, 2] - at[:, 0])
    assert len(at) == 4 and (normal[:, 2] > 0.5).all() and 0.5 * normal[:, 2].sum() == pytest.approx(3.0, rel=1e-6)


def test_polygons_that_cross_themselves_are_counted(tmp_path):
    bow_tie = "v 0 0 0\nv 2 2 0\nv 2 0 0\nv 0 2 0\nf 1 2 3 4\n"
    with pytest.warns(RefletWarning, match=r"polygons that cross themselves \(1\)"):
        read_obj(write(tmp_path, bow_tie))


def test_uv_and_normals_go_with_the_corners_of_ears(tmp_path):
    rows = "".join(f"v {x} {y} 0\nvt {x / 2} {y / 2}\n" for x, y in L_SHAPE)
    (part,) = read_obj(write(tmp_path, rows + "f " + " ".join(f"{k}/{k}" for k in range(1, 7))))
    expected = part.mesh.positions[:, :2] / 2.0 * (1.0, -1.0) + (0.0, 1.0)
    np.testing.assert_array_equal(part.mesh.uv, expected)
