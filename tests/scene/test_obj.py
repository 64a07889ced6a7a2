import codecs
import random
import warnings

import numpy as np
import pytest
from obj_files import area, silently, triangles, write

from reflet.errors import RefletError, RefletWarning
from reflet.scene.meshes.corners import crease_normals
from reflet.scene.readers.obj.read import read_obj
from reflet.scene.readers.obj.scan import Count, ObjArrays, scan

CUBE = """
v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1
f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 2 3 7 6\nf 1 5 8 4
"""


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


SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"

# one square each, as tools write it
WRITTEN = {
    "tabs": SQUARE.replace(" ", "\t") + "f\t1\t2\t3\t4\n",
    "tabs and relative": SQUARE.replace(" ", "\t") + "f\t-4\t-3\t-2\t-1",
    "blanks": "  v   0 0\t 0  \n\tv 1 0 0\nv 1 1 0\nv 0 1 0\nf  1  2\t\t3 4  \n",
    "carriage returns": (SQUARE + "f 1 2 3 4").replace("\n", "\r"),
    "both": (SQUARE + "f 1 2 3 4\n").replace("\n", "\r\n"),
    "comments": SQUARE.replace("\n", " # a comment\n") + "# f 1 2 3\nf 1 2 3 4# all\n",
    "a comment that ends in a path": "# C:\\models\\\n" + SQUARE + "f 1 2 3 4\n",
    "continued": SQUARE.replace("1 1 0", "1 \\\n 1 \\\r\n0") + "f 1 2 \\\n3 4\n",
    "weights": SQUARE.replace("1 1 0", "1 1 0 1.0") + "f 1 2 3 4\n",
    "faces first": "f 1 2 3 4\n" + SQUARE,
    "faces between": "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3 4\nv 0 1 0\n",
    "numbers": "v .0 -0 +0.\nv 1e0 0e-5 0\nv 10d-1 .01e2 0\nv 0 1000000000000000000000e-21 0E+3\nf 1 2 3 4",
    "explicit nothing": "vt 0 0\n" + SQUARE + "f 1// 2// 3// 4//\n",
    "old outlines": SQUARE + "fo 1 2 3 4\n",
    "zeros behind": SQUARE + "f 1 2 3 4\n\0\0\0",
}


@pytest.mark.parametrize("text", WRITTEN.values(), ids=WRITTEN)
def test_every_way_of_writing_a_square(tmp_path, text):
    (tmp_path / "a.obj").write_bytes(text.encode())
    (part,) = silently(read_obj, tmp_path / "a.obj")
    corner = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    np.testing.assert_array_equal(triangles(part), corner[[[0, 1, 2], [0, 2, 3]]])
    np.testing.assert_array_equal(part.mesh.normals, [[0, 0, 1]] * 4)


@pytest.mark.parametrize(
    ("mark", "encoding"),
    [
        (codecs.BOM_UTF8, "utf-8"),
        (codecs.BOM_UTF16_LE, "utf-16-le"),
        (codecs.BOM_UTF16_BE, "utf-16-be"),
        (codecs.BOM_UTF32_LE, "utf-32-le"),
        (b"", "utf-16-le"),
    ],
)
def test_byte_order_marks_cost_neither_the_first_vertex_nor_the_library(tmp_path, mark, encoding):
    (tmp_path / "stühle.mtl").write_bytes(mark + "newmtl größe\nKd 1 0 0\n".encode(encoding))
    for first in ("mtllib stühle.mtl\n" + SQUARE, SQUARE + "mtllib stühle.mtl\n"):
        (tmp_path / "a.obj").write_bytes(mark + (first + "usemtl größe\nf 1 2 3 4\n").encode(encoding))
        (part,) = silently(read_obj, tmp_path / "a.obj")
        assert area(part) == 1.0 and part.material.base_color == (1.0, 0.0, 0.0) and part.material.name == "größe"


def test_latin_1_names_are_the_same_in_both_files(tmp_path):
    (tmp_path / "m.mtl").write_bytes("newmtl größe\nKd 1 0 0\n".encode("latin-1"))
    (tmp_path / "a.obj").write_bytes(("mtllib m.mtl\n" + SQUARE + "usemtl größe\nf 1 2 3\n").encode("latin-1"))
    (part,) = silently(read_obj, tmp_path / "a.obj")
    assert part.material.base_color == (1.0, 0.0, 0.0)


def test_relative_indices_after_tabs_count_from_where_they_stand(tmp_path):
    second = SQUARE.replace(" 0\n", " 5\n")
    (part,) = read_obj(write(tmp_path, (SQUARE + "f -4 -3 -2 -1\n" + second + "f -4 -3 -2 -1\n").replace(" ", "\t")))
    assert sorted(set(part.mesh.positions[:, 2])) == [0.0, 5.0] and area(part) == 2.0


def test_lines_of_different_widths_in_one_file(tmp_path):
    text = "v 0 0 0\nv 1 0 0 1\nv 1 1 0 .1 .2 .3\nv 0 1 0 1 .1 .2 .3\nvt 0.5\nvt 1 0.25\nvt 1 1 0\n"
    with pytest.warns(RefletWarning, match=r"a.obj: vertex colours \(2\) are left out"):
        (part,) = read_obj(write(tmp_path, text + "f 1/1 2/2 3/3\nf 1/1 3/3 4/2\n"))
    assert area(part) == 1.0
    np.testing.assert_array_equal(part.mesh.uv, [[0.5, 1], [1, 0.75], [1, 0], [1, 0.75]])


def test_what_is_no_surface_is_left_out_and_counted(tmp_path):
    text = SQUARE + "l 1 2\nl 2 3 4\np 1\nf 1 2\nf 1\nf\ncstype bezier\ncurv 0 1 1 2 3\nparm u 0 1\nend\nwhat 1 2\n"
    with pytest.warns(RefletWarning) as caught:
        (part,) = read_obj(write(tmp_path, text + "f 1 2 3 4\n"))
    (warning,) = caught
    for phrase in (
        "lines (2)",
        "points (1)",
        "curves and free-form surfaces (1)",
        "faces of fewer than three corners (3)",
        'lines of unknown kind (1, the first is line 15, "what 1 2")',
    ):
        assert phrase in str(warning.message)
    assert area(part) == 1.0


def test_normals_and_coordinates_that_are_no_numbers(tmp_path):
    """Exporters write them for faces without area: the rest of the file is good."""
    text = SQUARE + "vn -nan -nan(ind) 0\nvn 0 0 1\nvt 1.#QNAN 0\nvt 1 1\nf 1/1/1 2/2/2 3/2/2 4/2/9\nf 1/7 2/7 3/7\n"
    with pytest.warns(RefletWarning) as caught:
        (part,) = read_obj(write(tmp_path, text))
    said = str(caught[0].message)
    for phrase in (
        "normals that are no numbers (1)",
        "texture coordinates that are no numbers (1)",
        "texture coordinates that are not there (3 corners)",
        "normals that are not there (1 corners)",
    ):
        assert phrase in said
    np.testing.assert_array_equal(part.mesh.normals, np.tile([0.0, 0, 1], (len(part.mesh.normals), 1)))


# -- smoothing ---------------------------------------------------------------------------------------------------------

# two squares that meet along x = 1, the second one turned by 20°
BENT = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 1.93969262 0 .34202014\nv 1.93969262 1 .34202014\n"


@pytest.mark.parametrize(
    ("first", "second", "smooth"),
    [
        ("", "", True),
        ("s 1\n", "s 1\n", True),
        ("s 1\n", "s 2\n", False),
        ("s\t1\n", "s\toff\n", False),
        ("s off\n", "s 0\n", False),
        ("s 1 # one\n", "", True),
        ("s on\n", "", True),
        ("o a\n", "o b\n", False),
        ("g a\ns 1\n", "g b\n", True),
        ("usemtl a\n", "usemtl b\n", True),
    ],
)
@pytest.mark.filterwarnings("ignore:.*uses materials")
def test_normals_are_smooth_within_groups_and_never_across(tmp_path, first, second, smooth):
    parts = read_obj(write(tmp_path, BENT + first + "f 1 2 3 4\n" + second + "f 2 5 6 3\n"))
    normals = np.concatenate([part.mesh.normals[part.mesh.positions[:, 0] == 1.0] for part in parts])
    angles = np.degrees(np.arctan2(-normals[:, 0], normals[:, 2]))
    # both squares have a right angle in the shared corners: the mean of their normals halves the turn
    expected = {10.0} if smooth else {0.0, 20.0}
    assert {round(angle, 4) for angle in angles.tolist()} == expected


def test_a_group_is_smooth_over_sharp_edges_but_not_with_its_back(tmp_path):
    roof = "v -1 0 0\nv 0 0 1\nv 0 1 1\nv -1 1 0\nv 1 0 0\nv 1 1 0\ns 3\nf 1 2 3 4\nf 2 5 6 3\n"
    (part,) = read_obj(write(tmp_path, roof))  # its faces turn by 90°, more than the 60° without a group
    np.testing.assert_allclose(part.mesh.normals[part.mesh.positions[:, 2] == 1.0], [[0, 0, 1]] * 2, atol=1e-6)
    (part,) = read_obj(write(tmp_path, BENT + "s 1\nf 1 2 3 4\nf 2 5 6 3\nf 4 3 2 1\nf 3 6 5 2\n"))
    at = triangles(part)
    face = np.cross(at[:, 1] - at[:, 0], at[:, 2] - at[:, 0])
    shading = part.mesh.normals[part.mesh.triangles]
    assert (np.einsum("ti,tki->tk", face, shading) > 0.9).all()  # cos 10° = 0.985, and areas of 1/2 twice


# -- names and materials -----------------------------------------------------------------------------------------------


def test_a_file_that_says_the_same_again_and_again_is_one_part(tmp_path):
    (part,) = read_obj(write(tmp_path, SQUARE + "g a\nf 1 2 3\ng b\ng a\nf 1 3 4\ng\n"))
    assert part.name == "a" and len(part.mesh.triangles) == 2


def test_names_lose_their_comments_but_not_their_numbers(tmp_path):
    parts = read_obj(write(tmp_path, SQUARE + "o Box #1\nf 1 2 3\no\tBox #2 # the second\nf 1 3 4\n"))
    assert [part.name for part in parts] == ["Box #1", "Box #2"]


@pytest.mark.parametrize(
    ("line", "reads"),
    [
        ("f 1 2 9", "which refers to a vertex that is not there"),
        ("f 0 1 2", "but vertices are counted from 1"),
        ("f 1 2 -7", "which counts back to before the first vertex"),
        ("f 1 2 99999999999999999999", "which refers to a vertex that is not there"),
        ("f 1/x 2 3", "where numbers of vertices were expected"),
        ("f 1/1/1/1 2 3", "where numbers of vertices were expected"),
        ("f 1.5 2 3", "where numbers of vertices were expected"),
        ("f 1 2 x", "where numbers of vertices were expected"),
        ("v 1 2", "which holds too few numbers"),
        ("vn 1 2", "which holds too few numbers"),
        ("vt", "which holds too few numbers"),
        ("v a b c", "where numbers with decimal points were expected"),
        ("v 1,5 2,5 3,5", "where numbers with decimal points were expected"),
        ("v 1.5.2 2 3", "where numbers with decimal points were expected"),
        ("vn 0 0 z", "where numbers with decimal points were expected"),
        ("vt nan 0,5", "where numbers with decimal points were expected"),
        ("v nan 0 0", "which is no finite number"),
        ("v 0 -INF 0", "which is no finite number"),
        ("v 0 0 1.#IND", "which is no finite number"),
        ("v 1e39 0 0", "which is no finite number"),
        ("v 1e99999999999 0 0", "which is no finite number"),
    ],
)
def test_broken_files_are_refused(tmp_path, line, reads):
    for newline in ("\n", "\r", "\r\n"):
        text = f"v 0 0 0\nv 1 0 \\\n0\n# a\nv 0 1 0\nf 1 2 3\n{line}\nf 1 2 3\n".replace("\n", newline)
        (tmp_path / "a.obj").write_bytes(text.encode())
        with pytest.raises(RefletError) as caught:
            read_obj(tmp_path / "a.obj")
        said = f'a.obj is no valid OBJ file: line 7 reads "{line}", {reads}; export it again.'
        assert str(caught.value).endswith(said)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("", "holds no faces, only 0 vertices; export it with its surfaces as polygons."),
        (SQUARE + "l 1 2\n", "holds no faces, only 4 vertices, 1 lines; export"),
        (SQUARE + "p 1\nf 1 2\n", "holds no faces, only 4 vertices, 1 points, 1 faces of fewer than three corners;"),
        ("<!DOCTYPE html>\n<html>", 'is no valid OBJ file: line 1 reads "<!DOCTYPE html>"; export it again.'),
        ("\n\nversion https://git-lfs" + "x" * 900, 'line 3 reads "version https://git-lfsx.*…"; export'),
    ],
)
def test_files_without_a_surface_are_refused(tmp_path, text, sentence):
    with pytest.raises(RefletError, match=sentence):
        read_obj(write(tmp_path, text))
    with pytest.raises(RefletError, match="cannot be read"):
        read_obj(tmp_path / "none.obj")
    with pytest.raises(RefletError, match="cannot be read"):
        read_obj(tmp_path)


# -- whatever is written is read ---------------------------------------------------------------------------------------

BLANKS = [" ", "  ", "\t", " \t ", " \\\n", "\t\\\r\n "]
NEWLINES = ["\n", "\r\n", "\r", "\n\n", " \n", "\t# note\n", "#note \\\n"]


def spelled(draw, x):
    return draw.choice([repr(x), f"{x:.9e}", f"{x:+.12E}", f"{x:.9e}".replace("e", "d"), f"{x:.25f}"])


def test_random_meshes_in_random_spelling_read_back_the_same(tmp_path):
    for seed in range(200):
        draw = random.Random(seed)
        at = np.array([[draw.gauss(0, 1000) for _ in range(3)] for _ in range(draw.randint(3, 8))], np.float32)
        uv = np.array([[draw.random() for _ in range(2)] for _ in range(draw.randint(1, 5))], np.float32)
        faces = [draw.sample(range(len(at)), 3) for _ in range(draw.randint(1, 6))]
        mapped = [draw.choices(range(len(uv)), k=3) for _ in faces]
        lines = [["v", *(spelled(draw, x) for x in row), *draw.choice([[], ["1"]])] for row in at.tolist()]
        lines += [["vt", *(spelled(draw, x) for x in row), *draw.choice([[], ["0"]])] for row in uv.tolist()]
        for face, texture in zip(faces, mapped, strict=True):
            if draw.random() < 0.5:
                lines.append(["f", *(f"{k - len(at)}/{t - len(uv)}" for k, t in zip(face, texture, strict=True))])
            else:
                end = draw.choice(["", "/"])
                lines.append(["f", *(f"{k + 1}/{t + 1}{end}" for k, t in zip(face, texture, strict=True))])
        text = draw.choice(["", "\ufeff"])
        for line in lines:
            text += draw.choice(["", " ", "\t"]) + "".join(word + draw.choice(BLANKS) for word in line)
            text += draw.choice(NEWLINES)
        (tmp_path / "a.obj").write_bytes(text.encode())
        (part,) = silently(read_obj, tmp_path / "a.obj")
        # nine digits and more tell every float32, and the reader errs by less than half the way to the next one
        np.testing.assert_array_equal(triangles(part), at[faces])
        expected = (uv[mapped].astype(float) * (1.0, -1.0) + (0.0, 1.0)).astype(np.float32)
        # v is taken from 1 before it is rounded: half a float32's step below 1, at ten digits either way
        np.testing.assert_allclose(part.mesh.uv[part.mesh.triangles], expected, rtol=0, atol=6e-8)


PIECES = [" ", "\t", "\n", "\r", "\\\n", "#", "#a \\\n", "-", "/", "0", "9", "x", ".", ".#", "nan", "1e99"] + [
    "v",
    "f",
    "vt",
    "s",
    "o",
    "1/2/3",
    "99999999999",
    "\0",
    "usemtl",
]


def test_damaged_files_are_read_or_refused_and_the_first_pass_counts_enough(tmp_path):
    """What the second pass would write beyond the arrays would be lost at best: it must never count more."""
    whole = (
        "mtllib a.mtl\no box\n" + SQUARE + "vt 0 0\nvt 1 0\nvt 1 1\nvn 0 0 1\ns 1\nusemtl red # c\n"
        "f 1/1/1 2/2/1 3/3/1\nf 1 2 3 4\ng x\ns off\nf -4 -3 -2\nl 1 2\nf 1//1 2//1 \\\n 4//1\n"
    )
    read, texts = 0, [SQUARE + "f 1 2 3\nf 1 x\n", SQUARE + "f 1 2 3#a \\\nf 1 2 3\n"]
    for seed in range(400):
        draw, text = random.Random(seed), whole
        for _ in range(draw.randint(1, 5)):
            at, cut = draw.randrange(len(text)), draw.choice([0, 0, 1, 5])
            text = text[:at] + draw.choice(PIECES) * (cut == 0) + text[at + cut :]
        texts.append(text)
    for text in texts:
        data = np.frombuffer(bytearray(text, "utf-8"), np.uint8)
        first, second = np.zeros(len(Count), np.int64), np.zeros(len(Count), np.int64)
        scan(data, None, first)
        scan(data, ObjArrays.of(first), second)
        for count in (Count.POSITIONS, Count.COORDINATES, Count.NORMALS, Count.CORNERS, Count.FACES, Count.STATEMENTS):
            assert second[count] <= first[count], (text, count)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RefletWarning)
            try:
                read += len(read_obj(write(tmp_path, text))) > 0
            except RefletError as error:
                assert str(error).endswith((".", "; export it again."))
    assert 50 < read < 350  # both ways are taken
