"""Layouts: pictures go on over every edge that two faces share, read as somebody inside sees them, and come back."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image, ImageDraw, ImageFont

from reflet.envmap.env_image import EnvImage
from reflet.envmap.mip_chain import MipChain
from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS
from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.parameterizations.dual_paraboloid import DualParaboloid
from reflet.envmap.parameterizations.octahedral import Octahedral
from reflet.envmap.texture_filter import sample
from reflet.errors import RefletError
from reflet.files.pictures.cube_layouts import (
    LAYOUTS,
    as_seen_inside,
    faces_from_picture,
    layout_of,
    layouts_of,
    picture_from_faces,
)

GOLDEN = Path(__file__).parents[1] / "golden/cube_layouts.png"


def directions_as_texels(laid_out, size):
    return EnvImage(laid_out, laid_out.texel_directions(size)[0].astype(np.float32))


@pytest.mark.parametrize("laid_out", PARAMETERIZATIONS.values(), ids=str)
def test_round_trip(laid_out):
    rng = np.random.default_rng(1)
    image = EnvImage(laid_out, rng.random((*laid_out.shape(4), 3)).astype(np.float32))
    for layout in layouts_of(laid_out):
        picture = picture_from_faces(image, layout)
        assert layout_of(laid_out, *picture.shape[:2]) == layout
        np.testing.assert_array_equal(faces_from_picture(picture, laid_out, layout).texels, image.texels)


@pytest.mark.parametrize("layout", ["horizontal-cross", "vertical-cross"])
def test_crosses_go_on_over_their_edges(layout):
    """Directions of neighbouring pixels are never further apart than the widest two texels of a face."""
    size = 16
    picture = picture_from_faces(directions_as_texels(CUBE, size), layout)
    step = 2.0 / size * 1.05  # at a face's middle; rounding of float32 and the bend over an edge are less
    filled = np.linalg.norm(picture, axis=-1) > 0.5
    assert filled.sum() == 6 * size**2
    for axis in (0, 1):
        beside = np.minimum(filled[1:], filled[:-1]) if axis == 0 else np.minimum(filled[:, 1:], filled[:, :-1])
        jump = np.linalg.norm(np.diff(picture, axis=axis), axis=-1)
        assert beside.sum() > 5 * size**2
        assert jump[beside].max() < step


@pytest.mark.parametrize("layout", LAYOUTS)
def test_pictures_are_seen_from_inside(layout):
    """Where a picture's columns go to the right and its rows down, the direction they look along is right × up.

    (In a right-handed world; a cube texture's faces are the other way around.)
    """
    size = 4
    picture = picture_from_faces(directions_as_texels(CUBE, size), layout).astype(np.float64)
    tiles = [
        picture[row : row + size, column : column + size]
        for row in range(0, picture.shape[0], size)
        for column in range(0, picture.shape[1], size)
        if picture[row, column].any()
    ]
    assert len(tiles) == 6
    for tile in tiles:
        right, up = tile[1, 2] - tile[1, 1], tile[1, 1] - tile[2, 1]
        forward = tile[1:3, 1:3].mean((0, 1))
        assert np.dot(np.cross(right, up), -forward) > 0.0


def test_names_are_those_of_tools():
    """Looking at pz, px is to the right and py above, as in left-handed tools; three.js looks px up along -x."""
    pictures = as_seen_inside(directions_as_texels(CUBE, 2).texels)
    middle = pictures.mean((1, 2))
    middle /= np.abs(middle).max(1, keepdims=True)
    expected = [[-1, 0, 0], [1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]]
    np.testing.assert_allclose(middle, expected, atol=1e-6)  # rounding of float32


def test_twice_is_once():
    texels = np.random.default_rng(2).random((6, 3, 3, 1)).astype(np.float32)
    np.testing.assert_array_equal(as_seen_inside(as_seen_inside(texels)), texels)


def test_where_the_faces_lie():
    """Each picture of one value; empty corners are 0."""
    texels = as_seen_inside(np.arange(1.0, 7.0, dtype=np.float32)[:, None, None, None])
    image = EnvImage(CUBE, texels)
    px, nx, py, ny, pz, nz = range(1, 7)
    expected = {
        "vertical-strip": [[px], [nx], [py], [ny], [pz], [nz]],
        "horizontal-strip": [[px, nx, py, ny, pz, nz]],
        "horizontal-cross": [[0, py, 0, 0], [nx, pz, px, nz], [0, ny, 0, 0]],
        "vertical-cross": [[0, py, 0], [nx, pz, px], [0, ny, 0], [0, nz, 0]],
    }
    assert set(expected) == set(LAYOUTS)
    for layout, grid in expected.items():
        np.testing.assert_array_equal(picture_from_faces(image, layout)[..., 0], grid)


def test_paraboloids_lie_side_by_side_as_they_are():
    image = directions_as_texels(DualParaboloid(), 4)
    picture = picture_from_faces(image)
    assert picture.shape == (4, 8, 3)
    np.testing.assert_array_equal(picture[:, :4], image.texels[0])


@pytest.mark.parametrize(
    ("height", "width", "layout"),
    [(24, 4, "vertical-strip"), (4, 24, "horizontal-strip"), (16, 12, "vertical-cross"), (12, 16, "horizontal-cross")],
)
def test_shapes_of_cubes(height, width, layout):
    assert layout_of(CUBE, height, width) == layout
    assert layout_of(CUBE, height, width + 1) is None


def test_layouts_that_a_map_does_not_have():
    with pytest.raises(RefletError, match="one of vertical-strip, horizontal-strip; vertical-cross came"):
        picture_from_faces(directions_as_texels(DualParaboloid(), 2), "vertical-cross")
    with pytest.raises(RefletError, match="is none, it is one picture"):
        picture_from_faces(directions_as_texels(Octahedral(), 2), "vertical-strip")
    with pytest.raises(RefletError, match="one of vertical-strip"):
        picture_from_faces(directions_as_texels(CUBE, 2), "spiral")


def labelled_latlong():
    """A lat-long picture with the axis written where each horizontal one is, readable from inside; coloured poles."""
    picture = Image.new("RGB", (256, 128), (40, 40, 40))
    draw = ImageDraw.Draw(picture)
    draw.rectangle((0, 0, 256, 12), fill=(60, 160, 60))
    draw.rectangle((0, 116, 256, 128), fill=(160, 60, 160))
    font = ImageFont.load_default(size=40)
    # u = 1/2 + atan2(z, x)/2π: -x -z +x +z from left to right; -x is on the border, where the picture is closed
    for u, text, color in ((0.25, "-z", (80, 160, 255)), (0.5, "+x", (255, 90, 90)), (0.75, "+z", (255, 220, 60))):
        draw.text((256 * u, 64), text, fill=color, font=font, anchor="mm")
    return EnvImage(PARAMETERIZATIONS["latlong"], np.asarray(picture, np.float32)[None] / 255.0)


def as_cube(image, size):
    """By the nearest texels' bilinear interpolation."""
    chain = MipChain(image.size, image.parameterization)
    texels = np.zeros((chain.texel_count, image.texels.shape[3]), np.float32)
    chain.level(texels, 0)[...] = image.texels
    directions = CUBE.texel_directions(size)[0].reshape(-1, 3)
    radiance = sample(chain, texels, directions, np.zeros(len(directions)))
    return EnvImage(CUBE, radiance.reshape(6, size, size, -1).astype(np.float32))


def test_labelled_faces():
    """Golden: both crosses of a labelled sky. The labels read from left to right, +z in the middle, +x left of it."""
    image = as_cube(labelled_latlong(), 32)

    def sheet(image):
        picture = np.zeros((128, 128 + 96, 3))
        picture[:96, :128] = picture_from_faces(image, "horizontal-cross")
        picture[:, 128:] = picture_from_faces(image, "vertical-cross")
        return 255.0 * picture

    with Image.open(GOLDEN) as golden:
        expected = np.asarray(golden, float)
    # fonts may differ by a pixel's edge between versions of the library; mirrored faces are further away by far
    assert np.abs(sheet(image) - expected).mean() < 0.3
    mirrored = EnvImage(CUBE, image.texels[:, :, ::-1])
    assert np.abs(sheet(mirrored) - expected).mean() > 1.0
