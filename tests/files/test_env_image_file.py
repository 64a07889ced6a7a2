"""The entrance for files: every form keeps what it can, kinds are told or guessed, and the rest is one sentence."""

import struct
import warnings
from contextlib import nullcontext
from pathlib import Path

import numpy as np
import OpenEXR
import pytest
from env_image_files import ANGULAR, LATLONG, PARABOLOID, STEP, random_image, random_levels
from textures import random_texture

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS
from reflet.envmap.parameterizations.cube import CUBE, FACES
from reflet.envmap.resampling.resample import resample
from reflet.errors import RefletError, RefletWarning
from reflet.files.env_image_file import file_facts, read_env_image, read_levels, write_env_image
from reflet.files.pictures.cube_layouts import LAYOUTS, layouts_of, picture_from_faces
from reflet.files.pictures.exr import read_exr, write_exr
from reflet.files.pictures.hdr import write_hdr
from reflet.files.pictures.png import write_png
from reflet.files.pictures.six_files import NAMES
from reflet.files.textures.dds import write_dds_texture
from reflet.files.textures.ktx2_container import write_texture
from reflet.files.textures.texel_formats import TEXEL_FORMATS
from reflet.files.textures.texture import Texture

CAPTURE = Path(__file__).parents[3] / "shared/data/two_param"
SQUARE = ("gazing_ball", "angular", "octahedral", "equal_area_octahedral")


@pytest.mark.parametrize("suffix", STEP)
@pytest.mark.parametrize("laid_out", PARAMETERIZATIONS.values(), ids=str)
def test_round_trip(tmp_path, laid_out, suffix):
    """All levels where there are several; the kind is known without asking, but for squares in DDS."""
    image = random_image(laid_out)
    levels = random_levels(laid_out) if suffix in (".ktx2", ".ktx", ".dds") else [image]
    path = tmp_path / f"map{suffix}"
    write_env_image(path, levels)
    told = laid_out if suffix == ".dds" and laid_out.name in SQUARE else None
    read = read_levels(path, told)
    assert [level.parameterization for level in read] == [laid_out] * len(levels)
    for ours, theirs in zip(read, levels, strict=True):
        np.testing.assert_allclose(ours.texels, theirs.texels, rtol=0, atol=STEP[suffix])
        assert ours.texels.dtype == np.float32
    assert file_facts(path).level_count == len(levels)
    assert file_facts(path).parameterization == (None if told else laid_out)


@pytest.mark.parametrize("suffix", [".hdr", ".exr", ".png"])
@pytest.mark.parametrize("laid_out", [CUBE, PARABOLOID], ids=str)
def test_layouts(tmp_path, laid_out, suffix):
    image = random_image(laid_out)
    for layout in layouts_of(laid_out):
        write_env_image(tmp_path / f"map{suffix}", [image], layout)
        np.testing.assert_allclose(
            read_env_image(tmp_path / f"map{suffix}").texels, image.texels, rtol=0, atol=STEP[suffix]
        )
        assert file_facts(tmp_path / f"map{suffix}").layout == layout


@pytest.mark.parametrize("suffix", [".hdr", ".exr", ".png"])
@pytest.mark.parametrize("names", NAMES, ids=lambda names: names[0])
def test_six_files(tmp_path, names, suffix):
    """Written as px nx …, read under each set of names: by a folder, and by a name with a place for the face's."""
    image = random_image(CUBE)
    write_env_image(tmp_path / "written" / f"{{face}}{suffix}", [image])
    assert sorted(file.name for file in (tmp_path / "written").iterdir()) == sorted(f"{f}{suffix}" for f in FACES)
    (tmp_path / "named").mkdir()
    for ours, theirs in zip(FACES, names, strict=True):
        (tmp_path / "written" / f"{ours}{suffix}").rename(tmp_path / "named" / f"Sky_{theirs}{suffix}")
    (tmp_path / "named" / "readme.txt").write_text("px")
    for path in (
        tmp_path / "named",
        tmp_path / "named" / f"Sky_{{face}}{suffix}",
        tmp_path / "named" / f"Sky_{names[4]}{suffix}",
    ):
        doubted = pytest.warns(RefletWarning, match="0 1 2 3 4 5 are taken as px nx py ny pz nz")
        with doubted if names[0] == "0" else nullcontext():
            read = read_env_image(path)
        np.testing.assert_allclose(read.texels, image.texels, rtol=0, atol=STEP[suffix])
        assert (file_facts(path).layout, file_facts(path).parameterization) == ("faces", CUBE)


def test_six_files_hold_what_strips_hold(tmp_path):
    image = random_image(CUBE)
    write_env_image(tmp_path / "{face}.exr", [image])
    write_env_image(tmp_path / "strip.exr", [image], "vertical-strip")
    np.testing.assert_array_equal(
        read_env_image(tmp_path / "{face}.exr").texels, read_env_image(tmp_path / "strip.exr").texels
    )


def test_six_files_that_are_not_there(tmp_path):
    write_env_image(tmp_path / "{face}.exr", [random_image(CUBE)])
    write_exr(tmp_path / "nz.exr", np.zeros((4, 4, 3), np.float32))
    with pytest.raises(RefletError, match=r"nz.exr is 4×4 pixels; a cube's six files are alike"):
        read_env_image(tmp_path)
    (tmp_path / "py.exr").unlink()
    for path in (tmp_path, tmp_path / "{face}.exr"):
        with pytest.raises(RefletError, match=r"six files of a cube: beside px.exr those called py are missing"):
            read_env_image(path)
    with pytest.raises(RefletError, match=r"beside px.exr those called py are missing"):
        read_env_image(tmp_path / "px.exr")  # any one of them
    with pytest.raises(RefletError, match="does not name the six files of a cube; call them px nx"):
        read_env_image(tmp_path / "c_{face}.exr")
    write_env_image(tmp_path / "a_{face}.hdr", [random_image(CUBE)])
    write_env_image(tmp_path / "b_{face}.hdr", [random_image(CUBE)])
    with pytest.raises(RefletError, match=r"holds several cubes \(a_px.hdr and b_px.hdr\)"):
        read_env_image(tmp_path)
    with pytest.raises(RefletError, match="Six files are a cube, not latlong"):
        read_env_image(tmp_path / "a_{face}.hdr", LATLONG)


@pytest.mark.parametrize(
    ("texel_format", "step"),
    [("half", 2.0**-12), ("float", 0.0), ("rgb9e5", 2.0**-10), ("r11g11b10f", 2.0**-7)],
)  # half a step in [0.5, 1]: 11 bits, 24, 9 with the exponent of the largest, 6 (blue, with its leading one)
@pytest.mark.parametrize("zstd", [False, True])
def test_texel_formats(tmp_path, texel_format, step, zstd):
    image = random_image(PARABOLOID)
    write_env_image(tmp_path / "map.ktx2", random_levels(PARABOLOID), texel_format=texel_format, zstd=zstd)
    read = read_levels(tmp_path / "map.ktx2")
    assert len(read) == 4
    np.testing.assert_allclose(read[0].texels, image.texels, rtol=0, atol=step)
    assert file_facts(tmp_path / "map.ktx2").supercompression == ("zstd" if zstd else None)


def test_half_exr(tmp_path):
    image = random_image(LATLONG)
    write_env_image(tmp_path / "map.exr", [image], texel_format="half")
    np.testing.assert_array_equal(read_env_image(tmp_path / "map.exr").texels, image.texels.astype(np.float16))


def test_a_layer_is_read_by_its_name(tmp_path):
    channels = {f"{name}.{c}": np.full((4, 8), k, np.float32) for k, name in enumerate(("sky", "sun")) for c in "RGB"}
    with OpenEXR.File({"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}, channels) as file:
        file.write(str(tmp_path / "map.exr"))
    assert (read_env_image(tmp_path / "map.exr", layer="sun").texels == 1.0).all()
    write_env_image(tmp_path / "map.ktx2", [random_image(LATLONG)])
    write_env_image(tmp_path / "map.hdr", [random_image(LATLONG)])
    for name in ("map.ktx2", "map.hdr"):
        with pytest.raises(RefletError, match=r"no layers, for only .exr files have; leave sun out"):
            read_levels(tmp_path / name, layer="sun")


@pytest.mark.parametrize("name", ["map.png", "map.ktx2", "{face}.png"])
def test_light_that_eight_bits_cut_is_said_by_its_share(tmp_path, name):
    """A face of white among black ones and one of code 128: what may have been brighter is the white one's share."""
    codes = np.zeros((6, 4, 4, 4), np.uint8)
    codes[2, ..., :3], codes[3, ..., :3], codes[..., 3] = 255, 128, 255
    if name == "map.ktx2":
        form = TEXEL_FORMATS["rgba8_srgb"]
        head = struct.pack("<9I4I2Q", 43, 1, 4, 4, 0, 0, 6, 1, 0, 0, 0, 0, 0, 0, 0) + struct.pack("<3Q", 104, 384, 384)
        (tmp_path / name).write_bytes(b"\xabKTX 20\xbb\r\n\x1a\n" + head + codes.tobytes())
        assert form.most == 1.0
    elif name == "map.png":
        write_png(tmp_path / name, codes[..., :3].reshape(24, 4, 3))
    else:
        for face, picture in zip(FACES, codes, strict=True):
            write_png(tmp_path / name.replace("{face}", face), picture[..., :3])
    grey = ((128 / 255 + 0.055) / 1.055) ** 2.4
    with pytest.warns(
        RefletWarning, match=rf"no radiance above 1: {100 / (1 + grey):.3g} % of its light is there and may"
    ):
        read_env_image(tmp_path / name)
    codes[codes == 255] = 254
    write_png(tmp_path / "dim.png", codes[..., :3].reshape(24, 4, 3))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        read_env_image(tmp_path / "dim.png")


def test_what_is_read_with_a_doubt_is_said_once(tmp_path):
    header = {"displayWindow": (np.int32([0, 0]), np.int32([7, 3])), "type": OpenEXR.scanlineimage}
    with OpenEXR.File(header, {"RGB": np.ones((2, 8, 3), np.float32)}) as file:
        file.write(str(tmp_path / "map.exr"))
    with pytest.warns(RefletWarning, match="is cropped: 50 % of") as said:
        read_env_image(tmp_path / "map.exr")
        file_facts(tmp_path / "map.exr")
    assert len(said) == 1


def test_grey_becomes_three_channels(tmp_path):
    write_exr(tmp_path / "map.exr", np.full((4, 8, 1), 0.5, np.float32))
    np.testing.assert_array_equal(read_env_image(tmp_path / "map.exr").texels, np.full((1, 4, 8, 3), 0.5, np.float32))


def test_sizes_that_are_no_powers_of_two(tmp_path):
    """Levels of a lat-long texture that is 6 high are 12×6 and 6×3; then it is 3×1, which is no lat-long map."""
    write_texture(tmp_path / "map.ktx2", random_texture("rgba16f", 6, 12, 4))
    assert [level.size for level in read_levels(tmp_path / "map.ktx2")] == [6, 3]


@pytest.mark.parametrize(
    ("width", "height", "kind"),
    [(8, 4, "latlong"), (24, 4, "cube"), (4, 24, "cube"), (16, 12, "cube"), (12, 16, "cube")],
)
def test_guesses_by_shape(tmp_path, width, height, kind):
    write_hdr(tmp_path / "map.hdr", np.ones((height, width, 3), np.float32))
    assert read_env_image(tmp_path / "map.hdr").parameterization == PARAMETERIZATIONS[kind]


@pytest.mark.parametrize(("images", "rows", "columns", "kind"), [(1, 4, 8, "latlong"), (2, 4, 4, "dual_paraboloid")])
def test_guesses_of_textures(tmp_path, images, rows, columns, kind):
    write_texture(tmp_path / "map.ktx2", random_texture("rgba16f", rows, columns, layers=images))
    assert read_env_image(tmp_path / "map.ktx2").parameterization == PARAMETERIZATIONS[kind]


def test_squares_are_asked_about(tmp_path):
    write_hdr(tmp_path / "map.hdr", np.ones((4, 4, 3), np.float32))
    write_texture(tmp_path / "map.ktx2", random_texture("rgba16f", 4, 4))
    for name in ("map.hdr", "map.ktx2"):
        with pytest.raises(
            RefletError, match=r"gazing_ball or angular or octahedral or equal_area_octahedral \(--from"
        ):
            read_env_image(tmp_path / name)
        assert read_env_image(tmp_path / name, ANGULAR).parameterization == ANGULAR
        assert file_facts(tmp_path / name).parameterization is None


def test_what_the_user_says_outweighs_what_the_file_says(tmp_path):
    for name in ("map.exr", "map.ktx2", "map.hdr", "map.png"):
        write_env_image(tmp_path / name, [random_image(PARAMETERIZATIONS["octahedral"])])
        assert read_env_image(tmp_path / name, ANGULAR).parameterization == ANGULAR


@pytest.mark.parametrize("layout", LAYOUTS)
def test_a_texture_that_holds_a_cube_as_pictures_do(tmp_path, layout):
    """Crosses in DDS are as old as cubes: the same as in a picture."""
    image = random_image(CUBE)
    picture = np.ones((*picture_from_faces(image, layout).shape[:2], 4), np.float32)
    picture[..., :3] = picture_from_faces(image, layout)
    form = TEXEL_FORMATS["rgba32f"]
    texture = Texture(form, *picture.shape[:2], False, (form.encode(picture[None]),))
    write_dds_texture(tmp_path / "map.dds", texture)
    with pytest.warns(RefletWarning, match=f"holds the faces of a cube as a {layout} of pictures"):
        read = read_env_image(tmp_path / "map.dds")
    np.testing.assert_array_equal(read.texels, image.texels)
    assert (file_facts(tmp_path / "map.dds").parameterization, file_facts(tmp_path / "map.dds").layout) == (
        CUBE,
        layout,
    )


def test_six_square_layers_are_a_cube(tmp_path):
    texture = random_texture("rgba32f", 4, 4, layers=6)
    write_texture(tmp_path / "map.ktx2", texture)
    write_dds_texture(tmp_path / "map.dds", texture)
    for name in ("map.ktx2", "map.dds"):
        with pytest.warns(RefletWarning, match="six square layers that it does not call a cube"):
            read = read_env_image(tmp_path / name)
        assert read.parameterization == CUBE
        np.testing.assert_array_equal(read.texels[..., :3], texture.decode(0)[..., :3])
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # nothing is in doubt where it was said
        assert read_env_image(tmp_path / "map.ktx2", CUBE).parameterization == CUBE


@pytest.mark.parametrize("laid_out", [LATLONG, CUBE], ids=str)
def test_openexr_layout(tmp_path, laid_out):
    """Smooth radiance survives both ways: samples on the border, then between them, move it by a texel's curvature."""
    size = 64
    direction = laid_out.texel_directions(size)[0]
    image = EnvImage(laid_out, (1.0 + 0.3 * direction * direction[..., [1, 2, 0]]).astype(np.float32))
    write_env_image(tmp_path / "map.exr", [image], "openexr")
    read = read_env_image(tmp_path / "map.exr")
    assert read.parameterization == laid_out
    assert file_facts(tmp_path / "map.exr").layout == "openexr"
    # the second derivative is at most 0.6·2, a step π/64: each bilinear interpolation is within h²/8 of that
    np.testing.assert_allclose(read.texels, image.texels, rtol=0, atol=2 * 1.2 * (np.pi / size) ** 2 / 8 * 2)
    with pytest.raises(RefletError, match=f"OpenEXR's {laid_out} map, not angular"):
        read_env_image(tmp_path / "map.exr", ANGULAR)


@pytest.mark.skipif(not CAPTURE.exists(), reason="the two captures are not here")
def test_a_lat_long_capture_written_as_openexrs_cube(tmp_path):
    """Sample by sample what somebody else made of the same capture: log-correlation at least 0.99 on every face.

    Theirs is not filtered as ours is; the face that looks up, all smooth, agrees to 0.9999.
    """
    cube = resample(read_env_image(CAPTURE / "KernerEnvLatLong.exr"), CUBE, 256)
    write_env_image(tmp_path / "cube.exr", [cube], "openexr")
    ours, theirs = (
        np.log(read_exr(path)[..., :3] + 1e-4).reshape(6, -1)
        for path in (tmp_path / "cube.exr", CAPTURE / "KernerEnvCube.exr")
    )
    correlation = [np.corrcoef(a, b)[0, 1] for a, b in zip(ours, theirs, strict=True)]
    assert min(correlation) > 0.99
    assert max(correlation) > 0.9999


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_radiance_that_is_not_finite(tmp_path, bad):
    texels = np.ones((4, 8, 3), np.float32)
    texels[1, 2, 0] = bad
    write_exr(tmp_path / "map.exr", texels)
    kind = "1 not a number" if np.isnan(bad) else "1 infinite"
    with pytest.raises(
        RefletError, match=f"not finite: {kind} of 32 texels, in row 1, .*; reflet convert --repair mends it"
    ):
        read_env_image(tmp_path / "map.exr")
    with pytest.warns(RefletWarning, match=f"is repaired: it held {kind} of 32 texels, in row 1, "):
        assert (read_env_image(tmp_path / "map.exr", repair=True).texels == 1.0).all()
    for suffix in STEP:
        with pytest.raises(RefletError, match="not finite everywhere"):
            write_env_image(tmp_path / f"out{suffix}", [EnvImage(LATLONG, texels[None])])
        assert not (tmp_path / f"out{suffix}").exists()


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("none.hdr", "does not exist"),
        ("none.exr", "does not exist"),
        ("none.png", "does not exist"),
        ("none.ktx2", "does not exist"),
        ("map.txt", "no environment map that can be read; give a file that ends in .hdr"),
        ("map.tif", "map.tif is TIFF, which is not read; save it as .exr"),
        ("map.heic", "is HEIC, which is not read; save it as .exr"),
        ("text.ktx2", "neither a KTX nor a DDS file"),
        ("text.dds", "neither a KTX nor a DDS file"),
        ("empty.ktx", "neither a KTX nor a DDS file"),
        ("odd.png", "no map of any kind; lat-long is 2:1"),
        ("strip.png", r"no map of any kind; if it shows the whole way around, .* \(--from latlong\): it is put"),
    ],
)
def test_what_cannot_be_read(tmp_path, name, said):
    for file in ("map.txt", "text.ktx2", "text.dds"):
        (tmp_path / file).write_text("some text")
    (tmp_path / "empty.ktx").touch()
    write_png(tmp_path / "odd.png", np.zeros((7, 3, 3), np.uint8))
    write_png(tmp_path / "strip.png", np.zeros((3, 10, 3), np.uint8))
    with pytest.raises(RefletError, match=said):
        read_levels(tmp_path / name)


@pytest.mark.parametrize("laid_out", PARAMETERIZATIONS.values(), ids=str)
def test_shapes_that_do_not_suit_what_was_said(tmp_path, laid_out):
    write_hdr(tmp_path / "map.hdr", np.ones((7, 3, 3), np.float32))
    write_dds_texture(tmp_path / "map.dds", random_texture("rgba16f", 7, 3))
    for name in ("map.hdr", "map.dds"):
        with pytest.raises(RefletError, match=f"no {laid_out} map; "):
            read_env_image(tmp_path / name, laid_out)


def test_suffixes_of_textures_are_only_hints(tmp_path):
    """A KTX 2.0 file called .ktx is one nonetheless."""
    write_texture(tmp_path / "map.ktx", random_texture("rgba16f", 4, 4, is_cube=True))
    assert file_facts(tmp_path / "map.ktx").form == "KTX 2.0"


def test_facts(tmp_path):
    write_env_image(tmp_path / "map.ktx2", random_levels(PARABOLOID), zstd=True)
    facts = file_facts(tmp_path / "map.ktx2")
    assert (facts.form, facts.layout, facts.rows, facts.columns) == ("KTX 2.0", "layers", 8, 8)
    assert (facts.image_count, facts.level_count, facts.channels, facts.texel_format) == (2, 4, 4, "rgba16f")
    assert facts.metadata["RefletParameterization"] == "dual_paraboloid"
    write_env_image(tmp_path / "map.hdr", [random_image(PARABOLOID)])
    facts = file_facts(tmp_path / "map.hdr")
    assert (facts.form, facts.layout, facts.texel_format) == ("Radiance", "horizontal-strip", "rgbe")
    assert facts.metadata["parameterization"] == "dual_paraboloid"
    assert set(LAYOUTS) >= {facts.layout}


def test_binary_metadata_is_told_by_its_length(tmp_path):
    write_texture(tmp_path / "map.ktx2", random_texture("r16f", 4, 8, metadata={"b": b"\x00\x01\xff", "t": b"text"}))
    assert file_facts(tmp_path / "map.ktx2").metadata == {"b": "3 bytes", "t": "text"}
