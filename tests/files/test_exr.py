import struct

import numpy as np
import OpenEXR
import pytest

from reflet.errors import RefletError
from reflet.files.pictures.exr import read_exr, read_exr_picture, write_exr

SCANLINES = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
TILES = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.tiledimage, "tiles": OpenEXR.TileDescription()}
LOSSLESS = ("NO", "RLE", "ZIPS", "ZIP", "PIZ")


def picture(height=20, width=36, channels=3, dtype=np.float32):
    return (np.random.default_rng(height).random((height, width, channels)) * 1e3).astype(dtype)


def save(path, header, channels):
    packed = {name: np.ascontiguousarray(c) if isinstance(c, np.ndarray) else c for name, c in channels.items()}
    with OpenEXR.File(dict(header), packed) as file:  # the library adds to it
        file.write(str(path))
    return path


def exr_by_hand(width, height, channels, chunks, version=2, extra=()):
    """A file without compression, byte by byte, for the library's Python does not write all that it reads.

    ``channels`` are names with their sampling, all of 32-bit floats; ``extra`` more attributes.
    """
    box = struct.pack("<4i", 0, 0, width - 1, height - 1)
    listed = b"".join(name.encode() + b"\0" + struct.pack("<iB3xii", 2, 0, step, step) for name, step in channels)
    attributes = [
        ("channels", "chlist", listed + b"\0"), ("compression", "compression", b"\0"), ("dataWindow", "box2i", box),
        ("displayWindow", "box2i", box), ("lineOrder", "lineOrder", b"\0"),
        ("pixelAspectRatio", "float", struct.pack("<f", 1)), ("screenWindowCenter", "v2f", struct.pack("<ff", 0, 0)),
        ("screenWindowWidth", "float", struct.pack("<f", 1)), *extra,
    ]  # fmt: skip
    header = struct.pack("<ii", 20000630, version)
    for name, kind, data in attributes:
        header += name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(data)) + data
    header += b"\0"
    at = len(header) + 8 * len(chunks) + np.cumsum([0] + [len(chunk) for chunk in chunks[:-1]])
    return header + at.astype("<u8").tobytes() + b"".join(chunks)


def tiled_exr(levels, tile, mode):
    """``levels`` are pictures by (level in x, level in y), in the file's order."""
    chunks = []
    for (level_x, level_y), image in levels.items():
        for y, x in np.ndindex(-(-image.shape[0] // tile), -(-image.shape[1] // tile)):
            pixels = image[y * tile : (y + 1) * tile, x * tile : (x + 1) * tile, ::-1]
            data = pixels.transpose(0, 2, 1).astype("<f4").tobytes()
            chunks.append(struct.pack("<5i", x, y, level_x, level_y, len(data)) + data)
    height, width, _ = levels[0, 0].shape
    tiles = ("tiles", "tiledesc", struct.pack("<IIB", tile, tile, mode))
    return exr_by_hand(width, height, [("B", 1), ("G", 1), ("R", 1)], chunks, 2 | 0x200, [tiles])


@pytest.mark.parametrize("channels", [1, 3, 4])
def test_round_trip_is_exact(tmp_path, channels):
    image = picture(channels=channels)
    write_exr(tmp_path / "a.exr", image)
    np.testing.assert_array_equal(read_exr(tmp_path / "a.exr"), image)


def test_half_floats_round_and_end(tmp_path):
    image = picture()
    write_exr(tmp_path / "a.exr", image, half=True)
    np.testing.assert_array_equal(read_exr(tmp_path / "a.exr"), image.astype(np.float16).astype(np.float32))
    with pytest.raises(RefletError, match="65504"):
        write_exr(tmp_path / "b.exr", image * 100.0, half=True)


@pytest.mark.parametrize("layout", ["latlong", "cube", None])
def test_the_layout_is_written_and_read(tmp_path, layout):
    write_exr(tmp_path / "a.exr", picture(), layout)
    assert read_exr_picture(tmp_path / "a.exr").layout == layout


@pytest.mark.parametrize("dtype", [np.float16, np.float32])
@pytest.mark.parametrize("header", [SCANLINES, TILES], ids=["scanlines", "tiles"])
@pytest.mark.parametrize("compression", LOSSLESS)
def test_samples_of_every_storage(tmp_path, dtype, header, compression):
    header = {**header, "compression": getattr(OpenEXR, f"{compression}_COMPRESSION")}
    image = picture(70, 90, dtype=dtype)  # more than a tile of 64
    path = save(tmp_path / "a.exr", header, {"RGB": image})
    np.testing.assert_array_equal(read_exr(path), image.astype(np.float32))


LOSSY = [name for name in dir(OpenEXR) if name.endswith("_COMPRESSION")]


@pytest.mark.parametrize("compression", LOSSY)
def test_every_compression_of_the_library(tmp_path, compression):
    t, s = np.meshgrid(np.linspace(0, 1, 64), np.linspace(0, 1, 96), indexing="ij")
    smooth = np.stack([1.0 + s, 1.0 + t, 2.0 - s], -1).astype(np.float16)
    path = save(tmp_path / "a.exr", {**SCANLINES, "compression": getattr(OpenEXR, compression)}, {"RGB": smooth})
    # DWA and B44, the lossiest, promise what the eye cannot see
    np.testing.assert_allclose(read_exr(path), smooth.astype(np.float32), rtol=0.02)


def test_channels_of_different_types_are_not_mixed_up(tmp_path):
    image = picture()
    channels = {"R": image[..., 0].astype(np.float16), "G": image[..., 1], "B": image[..., 2].astype(np.float16)}
    read = read_exr(save(tmp_path / "a.exr", SCANLINES, channels))
    for k, name in enumerate("RGB"):
        np.testing.assert_array_equal(read[..., k], channels[name].astype(np.float32))


def parts(tmp_path):
    depth, beauty, sky = picture(channels=1).reshape(20, 36), picture(), 2.0 * picture()
    named = [
        OpenEXR.Part(dict(SCANLINES), {"Z": depth}, "depth"),
        OpenEXR.Part(dict(SCANLINES), {"RGB": beauty}, "beauty"),
        OpenEXR.Part({**SCANLINES, "envmap": OpenEXR.ENVMAP_LATLONG}, {"RGB": sky}, "sky"),
    ]
    with OpenEXR.File(named) as file:
        file.write(str(tmp_path / "a.exr"))
    return tmp_path / "a.exr", beauty, sky


def test_parts_are_chosen_by_name_or_by_what_they_hold(tmp_path):
    path, beauty, sky = parts(tmp_path)
    read = read_exr_picture(path)
    image, layout = read.pixels, read.layout
    np.testing.assert_array_equal(image, beauty)
    assert layout is None
    read = read_exr_picture(path, "sky")
    image, layout = read.pixels, read.layout
    np.testing.assert_array_equal(image, sky)
    assert layout == "latlong"
    for name in ("night", "depth"):
        with pytest.raises(RefletError, match=f"no layer {name} of colours; it has beauty, sky"):
            read_exr(path, name)


def test_of_several_pictures_the_first_is_read_and_the_others_are_named(tmp_path):
    path, _, _ = parts(tmp_path)
    assert read_exr_picture(path).doubts == (
        f"{path} holds several pictures; beauty is read, not sky; reflet convert --layer NAME writes one out.",
    )
    assert read_exr_picture(path, "beauty").doubts == ()


def layered(tmp_path, *names, **plain):
    """A file of named layers, and what each holds; normals and depths stand between them."""
    held = {name: picture(4, 8) + 1e4 * k for k, name in enumerate(names)}
    channels = {f"{name}.{c}": image[..., k] for name, image in held.items() for k, c in enumerate("RGB")}
    channels |= {f"ViewLayer.Normal.{c}": picture(4, 8, 1)[..., 0] for c in "XYZ"}
    channels |= {"ViewLayer.Depth.Z": picture(4, 8, 1)[..., 0], "ViewLayer.Combined.A": np.ones((4, 8), np.float32)}
    return save(tmp_path / "a.exr", SCANLINES, {**channels, **plain}), held


def test_layers_are_read_by_name(tmp_path):
    path, held = layered(tmp_path, "ViewLayer.Combined", "ViewLayer.DiffCol", "Composite.Combined")
    for name, image in held.items():
        read = read_exr(path, name)
        np.testing.assert_array_equal(read[..., :3], image)
        assert read.shape[2] == (4 if name == "ViewLayer.Combined" else 3)
    with pytest.raises(
        RefletError,
        match=r"holds the layers Composite.Combined, ViewLayer.Combined, ViewLayer.DiffCol; write one out",
    ):
        read_exr(path)
    with pytest.raises(RefletError, match=r"no layer Combined of colours; it has Composite.Combined, "):
        read_exr(path, "Combined")


def test_the_only_layer_is_the_picture(tmp_path):
    """Normals, whose Y is no luminance, and depths do not count."""
    path, held = layered(tmp_path, "ViewLayer.Combined")
    np.testing.assert_array_equal(read_exr(path)[..., :3], held["ViewLayer.Combined"])


def test_plain_channels_are_the_picture_whatever_layers_there_are(tmp_path):
    plain = {"r": picture(4, 8, 1)[..., 0], "g": picture(4, 8, 1)[..., 0], "b": picture(4, 8, 1)[..., 0]}
    path, _ = layered(tmp_path, "diffuse", "gloss", **plain)
    read = read_exr_picture(path)
    np.testing.assert_array_equal(read.pixels, np.stack(list(plain.values()), -1))
    assert read.doubts == ()
    with pytest.raises(RefletError, match="no layer night of colours; it has diffuse, gloss"):
        read_exr(path, "night")


@pytest.mark.parametrize("names", ["XYZ", "xyz"])
def test_a_vector_is_no_luminance(tmp_path, names):
    """A pass of normals in a part of its own has X, Y and Z: not grey by its Y."""
    path = save(tmp_path / "a.exr", SCANLINES, {name: picture(4, 8, 1)[..., 0] for name in names})
    with pytest.raises(RefletError, match=f"holds the channels {', '.join(names)}; expected"):
        read_exr(path)


def test_the_library_reads_a_part_of_the_layers_name(tmp_path):
    """Multi-part files have the layer's name as the part's, or both, with the part's before it."""
    first, second = picture(4, 8), picture(4, 9)[:, 1:]
    named = [
        OpenEXR.Part(
            dict(SCANLINES), {f"Combined.{c}": np.ascontiguousarray(image[..., k]) for k, c in enumerate("RGB")}, n
        )
        for n, image in (("ViewLayer", first), ("Other", second))
    ]
    with OpenEXR.File(named) as file:
        file.write(str(tmp_path / "a.exr"))
    np.testing.assert_array_equal(read_exr(tmp_path / "a.exr", "Other.Combined"), second)
    np.testing.assert_array_equal(read_exr(tmp_path / "a.exr", "ViewLayer.Combined"), first)


def window(x, y, width, height):
    return np.int32([x, y]), np.int32([x + width - 1, y + height - 1])


def test_the_display_window_is_the_picture(tmp_path):
    """Overscan is cut off, a border that is not stored is black; wherever the windows lie."""
    image = picture(6, 10)
    header = {**SCANLINES, "dataWindow": window(-3, 100, 10, 6), "displayWindow": window(-1, 98, 12, 7)}
    read = read_exr(save(tmp_path / "a.exr", header, {"RGB": image}))
    expected = np.zeros((7, 12, 3), np.float32)
    expected[2:, :8] = image[:5, 2:]
    np.testing.assert_array_equal(read, expected)
    assert read_exr_picture(tmp_path / "a.exr").doubts == (  # 44 of 84 pixels
        f"{tmp_path / 'a.exr'} is cropped: 52.4 % of its display window's pixels are not stored and are black.",
    )


def test_the_data_window_is_the_environment(tmp_path):
    image = picture(6, 12)
    header = {**SCANLINES, "dataWindow": window(5, 5, 12, 6), "displayWindow": window(0, 0, 40, 40)}
    header["envmap"] = OpenEXR.ENVMAP_LATLONG
    np.testing.assert_array_equal(read_exr(save(tmp_path / "a.exr", header, {"RGB": image})), image)


@pytest.mark.parametrize("display", [window(0, 0, 4000, 4000), window(50, 50, 6, 6)])
def test_impossible_windows_are_refused(tmp_path, display):
    path = save(tmp_path / "a.exr", {**SCANLINES, "displayWindow": display}, {"RGB": picture(6, 12)})
    with pytest.raises(RefletError, match="window"):
        read_exr(path)


def test_luminance_and_chroma_become_colours(tmp_path):
    """Where chroma varies linearly, half of its samples say it all; past the last one it stays."""
    height, width = 8, 12
    column = np.arange(width, dtype=np.float32) + np.zeros((height, 1), np.float32)
    red_y, blue_y = 0.02 * column, -0.03 * column
    luminance = picture(height, width, 1)[..., 0]
    lines = []
    for row in range(height):
        chroma = [blue_y[row, ::2], red_y[row, ::2]] if row % 2 == 0 else []
        data = np.concatenate([*chroma, luminance[row]]).astype("<f4").tobytes()
        lines.append(struct.pack("<ii", row, len(data)) + data)
    (tmp_path / "a.exr").write_bytes(exr_by_hand(width, height, [("BY", 2), ("RY", 2), ("Y", 1)], lines))
    read = read_exr(tmp_path / "a.exr")
    red, blue = (1.0 + np.minimum(red_y, 0.2)) * luminance, (1.0 + np.maximum(blue_y, -0.3)) * luminance
    np.testing.assert_allclose(read[..., 0], red, rtol=1e-6)
    np.testing.assert_allclose(read[..., 2], blue, rtol=1e-6)
    # the luminance of Rec. 709 [ITU-R BT.709], of four digits
    np.testing.assert_allclose(read @ [0.2126, 0.7152, 0.0722], luminance, rtol=1e-4)


def test_other_primaries_are_converted(tmp_path):
    rec2020 = (0.708, 0.292, 0.170, 0.797, 0.131, 0.046, 0.3127, 0.3290)
    image = np.zeros((2, 4, 4), np.float32)
    image[:, :2] = (0.0, 1.0, 0.0, 0.5)
    image[:, 2:] = (2.0, 2.0, 2.0, 0.5)
    read = read_exr(save(tmp_path / "a.exr", {**SCANLINES, "chromaticities": rec2020}, {"RGBA": image}))
    # [ITU-R BT.2087], its matrix has 4 digits; what lies outside the gamut is cut at its border
    np.testing.assert_allclose(read[0, 0], [0.0, 1.1329, 0.0, 0.5], atol=1e-4)
    np.testing.assert_allclose(read[0, 3], [2.0, 2.0, 2.0, 0.5], rtol=1e-6)


@pytest.mark.parametrize(
    ("channels", "sentence"),
    [
        (
            {"R": np.ones((4, 8), np.uint32), "G": np.ones((4, 8), np.uint32), "B": np.ones((4, 8), np.uint32)},
            "integers",
        ),
        ({"diffuse.R": picture(4, 8, 1)[..., 0]}, r"diffuse\.R; expected R, G, B or Y"),
        ({"R": picture(4, 8, 1)[..., 0]}, "channels R; expected"),
        ({"Z": picture(4, 8, 1)[..., 0]}, "channels Z; expected"),
    ],
)
def test_what_is_no_picture_is_refused_in_a_sentence(tmp_path, channels, sentence):
    with pytest.raises(RefletError, match=sentence):
        read_exr(save(tmp_path / "a.exr", SCANLINES, channels))


def test_deep_samples_are_refused(tmp_path):
    deep = np.empty((4, 8), dtype=object)
    for at in np.ndindex(4, 8):
        deep[at] = np.ones(2, np.float32)
    path = save(
        tmp_path / "a.exr", {"compression": OpenEXR.ZIPS_COMPRESSION, "type": OpenEXR.deepscanline}, {"Z": deep}
    )
    with pytest.raises(RefletError, match="deep"):
        read_exr(path)


@pytest.mark.parametrize("mode", [0, 1, 2], ids=["one level", "mip-mapped", "rip-mapped"])
def test_tiled_files_give_the_finest_level(tmp_path, mode):
    image = picture(12, 20)
    levels = {(0, 0): image}
    if mode == 1:
        levels |= {(k, k): picture(max(12 >> k, 1), max(20 >> k, 1)) for k in range(1, 5)}
    if mode == 2:
        sizes = {(kx, ky): (max(12 >> ky, 1), max(20 >> kx, 1)) for ky in range(4) for kx in range(5)}
        levels = {level: image if level == (0, 0) else picture(*size) for level, size in sizes.items()}
    (tmp_path / "a.exr").write_bytes(tiled_exr(levels, 8, mode))
    np.testing.assert_array_equal(read_exr(tmp_path / "a.exr"), image)
