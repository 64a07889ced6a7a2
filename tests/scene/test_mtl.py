"""Materials of OBJ files, as tools write them."""

import warnings

import numpy as np
import pytest
from PIL import Image

from reflet.errors import RefletError, RefletWarning
from reflet.scene.readers.obj.mtl_textures import parse_texture
from reflet.scene.readers.obj.read import read_obj

SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
FACE = "f 1/1 2/2 3/3 4/4\n"


def picture(path, color, size=(2, 3)):
    path.parent.mkdir(parents=True, exist_ok=True)
    Image.new("RGB", size, color).save(path)


def square(folder, mtl, uses="m", lib="mtllib a.mtl\n"):
    (folder / "a.mtl").write_bytes(mtl if isinstance(mtl, bytes) else mtl.encode())
    (folder / "a.obj").write_text(lib + SQUARE + f"usemtl {uses}\n" + FACE)
    (part,) = read_obj(folder / "a.obj")
    return part


def silent_square(*arguments, **named):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return square(*arguments, **named)


def warned(folder, mtl, **named):
    with pytest.warns(RefletWarning) as caught:
        part = square(folder, mtl, **named)
    return part, [str(warning.message) for warning in caught]


@pytest.mark.parametrize(
    "mtl",
    [
        "newmtl m\nKd 1 .5 .25\nPm 1\nPr .25\n",
        "\tnewmtl\tm\n\tKd\t1\t.5\t.25\n\tPm\t1\n\tPr\t.25",
        "newmtl m\r\nKd  1  .5  .25 # red\r\nPm 1# all\r\nPr .25\r\n",
        "newmtl m\rKd 1 .5 .25\rPm 1\rPr .25",
        "\ufeffnewmtl m\nkd 1 .5 \\\n.25\nPM 1\npr 0.25\n",
        "# C:\\x\\\nnewmtl m # it\nKd 1 .5 .25\nKa 1 1 1\nKs 1 1 1\nNs 9\nNi 1.5\nillum 2\nd 1\nTr 0\nPm 1\nPr .25",
        "newmtl m\nNs 900\nKd 1 .5 .25\nPm 1\nPr .25\nPc 0\nPs 0\naniso 0\n",
        "newmtl other\nKd 0 0 0\nnewmtl m\nKd 1 .5 .25\nPm 1\nPr .25\n\n\nnewmtl last\nPm 0",
    ],
)
def test_every_way_of_writing_a_material(tmp_path, mtl):
    for uses in ("m", "\tm\t", "m # the one"):
        material = silent_square(tmp_path, mtl, uses).material
        assert material.base_color == (1.0, 0.5, 0.25)
        assert (material.metallic, material.perceptual_roughness) == (1.0, 0.25)


def test_materials_named_by_numbers_are_told_apart(tmp_path):
    mtl = "newmtl Material #25\nKd 1 0 0\nnewmtl Material #26\nKd 0 1 0\n"
    assert silent_square(tmp_path, mtl, "Material #26").material.base_color == (0.0, 1.0, 0.0)
    assert silent_square(tmp_path, mtl, "Material #25 # left").material.base_color == (1.0, 0.0, 0.0)
    assert silent_square(tmp_path, "newmtl red #f00\nKd 1 0 0\n", "red").material.base_color == (1.0, 0.0, 0.0)


# -- which file, which material ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("line", "files"),
    [
        ("mtllib\ta.mtl", ["a.mtl"]),
        ("mtllib my lib.mtl", ["my lib.mtl"]),
        ('mtllib "my lib.mtl"', ["my lib.mtl"]),
        ("mtllib .\\lib\\A.MTL", ["lib/a.mtl"]),
        ("mtllib C:\\Users\\x\\a.mtl", ["a.mtl"]),
        ("mtllib a.mtl # all of them", ["a.mtl"]),
        ("mtllib other.mtl a.mtl", ["other.mtl", "a.mtl"]),
        ("mtllib other lib.mtl my lib.mtl", ["other lib.mtl", "my lib.mtl"]),
        ("mtllib materials.txt a.mtl", ["a.mtl", "materials.txt"]),
        ("mtllib other.mtl \\\n a.mtl", ["other.mtl", "a.mtl"]),
        ("mtllib other.mtl\nmtllib a.mtl", ["other.mtl", "a.mtl"]),
    ],
)
def test_files_that_mtllib_lines_name(tmp_path, line, files):
    for file in files:
        (tmp_path / file).parent.mkdir(exist_ok=True)
        (tmp_path / file).write_text(f"newmtl {file.split('/')[-1]}\nKd 0 1 0\n")
    for file in files:
        (tmp_path / "a.obj").write_text(f"{line}\n{SQUARE}usemtl {file.split('/')[-1]}\n{FACE}")
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            (part,) = read_obj(tmp_path / "a.obj")
        assert part.material.base_color == (0.0, 1.0, 0.0)


def test_names_in_several_files_mean_the_nearest(tmp_path):
    (tmp_path / "a.mtl").write_text("newmtl m\nKd 1 0 0\n")
    (tmp_path / "b.mtl").write_text("newmtl m\nKd 0 1 0\nnewmtl later\nKd 0 0 1\n")
    text = "o first\nusemtl later\nf 1 2 3\nmtllib a.mtl\nusemtl m\no second\nf 1 2 3\nmtllib b.mtl\no third\nf 1 2 3\n"
    (tmp_path / "a.obj").write_text(SQUARE + text + "usemtl m\no fourth\nf 1 2 3\n")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        colors = {part.name: part.material.base_color for part in read_obj(tmp_path / "a.obj")}
    red, green, blue = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
    # the third object goes on with the material chosen before the second library
    assert colors == {"first": blue, "second": red, "third": red, "fourth": green}
    (tmp_path / "a.obj").write_text("mtllib b.mtl a.mtl\n" + SQUARE + "usemtl m\n" + FACE)
    with pytest.warns(RefletWarning, match="material m is in b.mtl and a.mtl; the first one is used"):
        (part,) = read_obj(tmp_path / "a.obj")
    assert part.material.base_color == green


def test_a_material_defined_twice(tmp_path):
    part, said = warned(tmp_path, "newmtl m\nKd 1 0 0\nPm 1\nnewmtl m\nKd 0 1 0\n")
    assert said == ["a.mtl: of several materials of one name the last one counts (m)."]
    assert part.material.base_color == (0.0, 1.0, 0.0) and part.material.metallic == 0.0


def test_missing_files_and_materials_are_said_truly(tmp_path):
    part, said = warned(tmp_path, "", lib="mtllib nowhere.mtl\n")
    assert part.material.metallic == 1.0 and part.material.base_color == (0.65, 0.65, 0.65)
    assert said == [
        f"a.obj: nowhere.mtl is not in {tmp_path}, in capitals or small letters; copy it there; "
        "until then its materials are mirrors.",
        "a.obj uses materials, which no .mtl file defines; they are mirrors: m.",
    ]
    part, said = warned(tmp_path, "", lib="")
    assert said == ["a.obj uses materials, but no mtllib line names a file that has them; they are mirrors: m."]


def test_a_missing_file_that_nobody_needs_costs_no_words(tmp_path):
    (tmp_path / "a.obj").write_text("mtllib nowhere.mtl\n" + SQUARE + FACE)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        read_obj(tmp_path / "a.obj")


# -- values ------------------------------------------------------------------------------------------------------------


def test_roughness_from_a_phong_exponent(tmp_path):
    """alpha² = 2/(N + 2), and alpha is the square of the roughness: N = 30 gives alpha 1/4 and roughness 1/2."""
    assert silent_square(tmp_path, "newmtl m\nNs 30\n").material.perceptual_roughness == 0.5
    assert silent_square(tmp_path, "newmtl m\n").material.perceptual_roughness == 1.0


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("Kd 0,5 0,5 0,5", "with decimal points"),
        ("Kd", "with decimal points"),
        ("Kd nan 0 0", "with decimal points"),
        ("Pm\tfull", "with decimal points"),
        ("Ke 1e99 0 0", "with decimal points"),
    ],
)
def test_broken_numbers_are_refused_by_line(tmp_path, line, said):
    with pytest.raises(RefletError) as caught:
        square(tmp_path, f"newmtl m\nKa 1 1 1\n{line}\n")
    text = " ".join(line.split())
    expected = (
        f'a.mtl is no valid material file: line 3 reads "{text}", where numbers {said} were expected; export it again.'
    )
    assert str(caught.value).endswith(expected)


@pytest.mark.parametrize(
    ("lines", "said"),
    [
        ("Kd 255 128 0", "Kd below 0 or above 1 is taken as the nearer of them (m)."),
        ("Pr 2", "Pr beyond 0 to 1 is taken as the nearer of them (m)."),
        ("d 0", "what d or Tr would hide altogether is shown (m)."),
        ("Tr 1", "what d or Tr would hide altogether is shown (m)."),
        ("Ps 0.5", "sheen is left out (m)."),
        ("aniso 0.5", "anisotropy is left out: highlights are round (m)."),
        ("map_Ns a.png", "map_Ns is left out, for tools disagree on what it holds; give the roughness by map_Pr (m)."),
        ("Ni 0.5", "Ni below 1 is taken as 1.5 (m)."),
        ("illum 0", "illum 0, colour without light, is taken as illum 1 (m)."),
        ("disp a.png", "displacement and decals are left out (m)."),
        ("refl -type sphere a.png", "reflection maps are left out (m)."),
        ("Kd xyz 1 1 1", "colours given as spectra or as XYZ are left out (m)."),
        ("glow 5\nshine 3", '2 lines of unknown kind are left out (the first is line 2, "glow 5").'),
    ],
)
def test_what_is_not_honoured_is_said_once(tmp_path, lines, said):
    part, told = warned(tmp_path, f"newmtl m\n{lines}\nnewmtl unused\nPs 0.1\n")
    assert told == [f"a.mtl: {said}"]
    assert max(part.material.base_color) <= 1.0 and part.material.perceptual_roughness <= 1.0


def test_materials_that_share_a_lack_share_a_sentence(tmp_path):
    names = [f"m{k}" for k in range(10)]
    (tmp_path / "a.mtl").write_text("".join(f"newmtl {name}\nPs .5\n" for name in names))
    (tmp_path / "a.obj").write_text("mtllib a.mtl\n" + SQUARE + "".join(f"usemtl {name}\n{FACE}" for name in names))
    with pytest.warns(RefletWarning) as caught:
        read_obj(tmp_path / "a.obj")
    listed = "m0, m1, m2, m3, m4, m5, m6, m7 and 2 more"
    assert [str(w.message) for w in caught] == [f"a.mtl: sheen is left out ({listed})."]


# -- textures ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("tex.png", {}),
        ("-clamp on tex.png", {"wraps": ("clamp", "clamp")}),
        ("-clamp off tex.png", {}),
        ("-s 2 3 1 tex.png", {"scale": (2.0, 3.0)}),
        ("-s 2 tex.png", {"scale": (2.0, 1.0)}),
        ("-o .5 -0.25 0 -s\t2 2 1\ttex.png", {"offset": (0.5, -0.25), "scale": (2.0, 2.0)}),
        ("-bm 0.5 -blendu on -blendv off -boost 1 -texres 512 -cc on tex.png", {"bump": 0.5}),
        ("-imfchan G -mm 0 1 -t 0 0 0 tex.png", {"channel": "g"}),
        ("-mm 0.1 2 -t 1 0 0 -type sphere tex.png", {"odd": ("-mm", "-t", "-type")}),
        ("my brick wall.png", {"name": "my brick wall.png"}),
        ("-s 2 2 1 my brick wall 2.png", {"scale": (2.0, 2.0), "name": "my brick wall 2.png"}),
        ("-s 2 2 1 2 bricks.png", {"scale": (2.0, 2.0), "name": "2 bricks.png"}),
        ("tex.png -s 2 2 1", {"scale": (2.0, 2.0)}),
        ("tex -s.png", {"name": "tex -s.png"}),
        ("-unknown.png", {"name": "-unknown.png"}),
        ("maps\\tex.png", {"name": "maps\\tex.png"}),
    ],
)
def test_options_before_the_name(text, expected):
    statement = parse_texture(text)
    defaults = {"name": "tex.png", "scale": (1.0, 1.0), "offset": (0.0, 0.0), "wraps": ("repeat", "repeat"),
                "bump": 1.0, "channel": "", "odd": ()}  # fmt: skip
    assert {key: getattr(statement, key) for key in defaults} == defaults | expected


def test_textures_are_found_scaled_and_moved(tmp_path):
    picture(tmp_path / "Maps/Brick wall.png", (10, 20, 30))
    part = silent_square(tmp_path, "newmtl m\nmap_Kd -s 2 3 1 -o .5 .25 0 C:\\proj\\maps\\brick wall.png\n")
    texture = part.material.base_color_texture_srgb
    np.testing.assert_array_equal(texture.pixels, np.broadcast_to(np.uint8([10, 20, 30, 255]), (3, 2, 4)))
    assert part.material.base_color == (1.0, 1.0, 1.0) and texture.wraps == ("repeat", "repeat")
    u, v = part.mesh.positions[:, 0], part.mesh.positions[:, 1]  # the square's own (u, v), v upwards
    np.testing.assert_array_equal(part.mesh.uv, np.column_stack([2 * u + 0.5, 1 - (3 * v + 0.25)]))


@pytest.mark.parametrize("kd", ["", "Kd 0 0 0\n", "Kd .5 .5 .5\n"])
@pytest.mark.parametrize(
    ("name", "data", "sentence"),
    [
        ("none.png", None, "none.png is not in .*, in capitals or small letters; copy it there"),
        ("a.png", b"", r"a.png is not a readable picture \(of no known format\)"),
        ("a.png", b"\x89PNG\r\n\x1a\n damaged", "a.png is not a readable picture"),
        ("a.svg", b"<svg/>", "a.svg is not a readable picture"),
        ("https://example.org/a.png", None, "is on the network; download it"),
        ("-s 2 2 1", None, "is not in"),
    ],
)
def test_missing_and_foreign_textures_fall_back_to_the_factor(tmp_path, kd, name, data, sentence):
    if data is not None:
        (tmp_path / name).write_bytes(data)
    with pytest.warns(RefletWarning, match=sentence) as caught:
        part = square(tmp_path, f"newmtl m\n{kd}map_Kd {name}\nmap_Ke {name}\nKe 1 1 1\n")
    (warning,) = caught
    assert str(warning.message).endswith("; until then shown without it (m).")
    factor = tuple(float(x) for x in kd.split()[1:]) or (1.0, 1.0, 1.0)
    assert part.material.base_color == factor and part.material.emission == (1.0, 1.0, 1.0)
    assert part.material.base_color_texture_srgb is None and part.material.emission_texture_srgb is None


@pytest.mark.parametrize("extension", ["png", "jpg", "tga", "bmp", "tif", "webp", "gif"])
def test_pictures_of_every_usual_kind(tmp_path, extension):
    picture(tmp_path / f"a.{extension}", (255, 255, 255))
    part = silent_square(tmp_path, f"newmtl m\nmap_Kd a.{extension}\n")
    assert part.material.base_color_texture_srgb.pixels.min() == 255


def test_a_factor_of_0_does_not_hide_its_texture(tmp_path):
    """Exporters that write a texture write Kd 0 or Ke 0 beside it."""
    picture(tmp_path / "a.png", (9, 9, 9))
    part, said = warned(tmp_path, "newmtl m\nKd 0 0 0\nmap_Kd a.png\nKe 0 0 0\nmap_Ke a.png\n")
    assert said == ["a.mtl: factors of 0 would hide their textures and are taken as 1 (m)."]
    assert part.material.base_color == part.material.emission == (1.0, 1.0, 1.0)


def test_normal_maps_by_their_own_word_or_by_their_texels(tmp_path):
    picture(tmp_path / "normal.png", (128, 128, 255))
    picture(tmp_path / "height.png", (128, 128, 128))
    for line in ("norm -bm .5 normal.png", "map_Bump -bm .5 normal.png", "bump -bm .5 normal.png"):
        part = silent_square(tmp_path, f"newmtl m\n{line}\n")
        assert part.material.normal_scale == 0.5
        assert tuple(part.material.normal_texture.pixels[0, 0]) == (128, 128, 255, 255)
        # along +u, and right-handed because the square is mapped the right way round
        np.testing.assert_allclose(part.mesh.tangents, [[1, 0, 0, 1]] * 4, atol=1e-6)
    part, said = warned(tmp_path, "newmtl m\nmap_Bump -bm .5 height.png\n")
    assert said == ["a.mtl: bump maps of heights are left out; give a normal map by norm (m)."]
    assert part.material.normal_texture is None


def packed(material):
    return [tuple(texel) for texel in material.metallic_roughness_texture.pixels[0, :, :3].tolist()]


def test_roughness_and_metal_from_one_picture_or_two(tmp_path):
    picture(tmp_path / "rough.png", (51, 51, 51), (1, 1))
    picture(tmp_path / "metal.png", (204, 204, 204), (2, 1))
    picture(tmp_path / "orm.png", (1, 51, 204), (2, 1))
    for lines in (
        "map_Pr rough.png\nmap_Pm metal.png",
        "map_Pr orm.png\nmap_Pm orm.png",
        "map_Pr -imfchan g orm.png\nmap_Pm -imfchan b orm.png",
        "map_ORM orm.png",
        "map_RMA -s 1 1 1 orm.png\nmap_Pr -imfchan g orm.png\nmap_Pm -imfchan b orm.png",
    ):
        material = silent_square(tmp_path, f"newmtl m\n{lines}\n").material
        assert (material.metallic, material.perceptual_roughness) == (1.0, 1.0)
        assert [texel[1:] for texel in packed(material)] == [(51, 204)] * 2
    material = silent_square(tmp_path, "newmtl m\nPm 0.5\nmap_Pr rough.png\n").material
    assert (material.metallic, material.perceptual_roughness, packed(material)) == (0.5, 1.0, [(255, 51, 255)])
    material = silent_square(tmp_path, "newmtl m\nPr 0.5\nmap_Pm metal.png\n").material
    assert (material.metallic, material.perceptual_roughness) == (1.0, 0.5)
    assert packed(material) == [(255, 255, 204)] * 2


def test_textures_placed_differently_are_said(tmp_path):
    picture(tmp_path / "a.png", (9, 9, 9))
    part, said = warned(tmp_path, "newmtl m\nmap_Kd -s 2 2 1 a.png\nmap_Ke -s 3 3 1 -mm .5 .5 a.png\n")
    assert said == [
        "a.mtl: textures of a material are placed differently, and all are placed like its first (m).",
        "a.mtl: the textures' option -mm is left out (m).",
    ]
    assert part.mesh.uv.max() == 2.0 and part.mesh.uv.min() == 1.0 - 2.0


def test_faces_without_coordinates_do_not_take_the_texture_from_the_others(tmp_path):
    picture(tmp_path / "a.png", (9, 9, 9))
    (tmp_path / "a.mtl").write_text("newmtl m\nmap_Kd a.png\nnewmtl plain\n")
    (tmp_path / "a.obj").write_text(
        f"mtllib a.mtl\n{SQUARE}usemtl m\n{FACE}f 1 2 3\nusemtl plain\no b\n{FACE}f 1 2 3\n"
    )
    mapped, bare, plain = read_obj(tmp_path / "a.obj")
    assert mapped.mesh.uv is not None and len(mapped.mesh.triangles) == 2
    assert bare.mesh.uv is None and len(bare.mesh.triangles) == 1
    assert plain.mesh.uv is None and len(plain.mesh.triangles) == 3
