"""How the faces of a map lie in one picture: strips, crosses, and the names of six files.

**Pictures are what somebody inside the cube sees.** A cube texture is not: its faces are those of a left-handed world,
px to the right of pz, so that in ours, right-handed, where right of +z is -x, every face is a mirror image. The tools
that make and take crosses, strips and six files deal in plain pictures, px to the right of pz nonetheless, and
right-handed renderers look them up with x negated (three.js does). Here the same happens at the file boundary: the
picture called px is the face nx, mirrored left to right; the one called nx is px; the other four are just mirrored.
Done twice it is undone. KTX and DDS hold textures, which stay as they are. So do the two faces of a dual paraboloid,
the pictures in its mirrors.

Crosses, with pz in the middle; every two pictures that touch go on into each other:

    horizontal:   .  py  .  .      vertical:   .  py  .
                 nx  pz  px  nz               nx  pz  px
                  .  ny  .  .                  .  ny  .
                                               .  nz  .    (nz turned by 180°)

Strips are px nx py ny pz nz, from left to right or from top to bottom; a dual paraboloid's are front, back.
"""

import numpy as np
from jaxtyping import Float

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.parameterizations.parameterization import Parameterization
from reflet.errors import RefletError

LAYOUTS = ("vertical-strip", "horizontal-strip", "vertical-cross", "horizontal-cross")
"""Of cubes in one picture; dual paraboloids have the two strips. Six files are a matter of `six_files`."""

_PLACES = {  # row and column of each face in a cross, and half turns
    "horizontal-cross": ((1, 2, 0), (1, 0, 0), (0, 1, 0), (2, 1, 0), (1, 1, 0), (1, 3, 0)),
    "vertical-cross": ((1, 2, 0), (1, 0, 0), (0, 1, 0), (2, 1, 0), (1, 1, 0), (3, 1, 2)),
}
_GRIDS = {"horizontal-cross": (3, 4), "vertical-cross": (4, 3)}

Picture = Float[np.ndarray, "height width channels"]
Faces = Float[np.ndarray, "faces rows columns channels"]


def layouts_of(laid_out: Parameterization) -> tuple[str, ...]:
    """How the faces of such a map may lie in a picture; "single" is the one way if it has one face."""
    if laid_out.face_count == 1:
        return ("single",)
    return LAYOUTS if laid_out == CUBE else tuple(name for name in LAYOUTS if name not in _PLACES)


def layout_of(laid_out: Parameterization, height: int, width: int) -> str | None:
    """The layout in which a picture of this size holds such a map; "single" for those of one face; None if in none."""
    for layout in layouts_of(laid_out):
        down, across = _grid(laid_out, layout)
        size = height // down
        if size and (height, width) == (down * size, across * laid_out.aspect * size):
            return layout
    return None


def _grid(laid_out: Parameterization, layout: str) -> tuple[int, int]:
    """Faces from top to bottom and from left to right."""
    strips = {"vertical-strip": (laid_out.face_count, 1), "horizontal-strip": (1, laid_out.face_count)}
    return {**_GRIDS, **strips, "single": (1, 1)}[layout]


def faces_from_picture(picture: Picture, laid_out: Parameterization, layout: str) -> EnvImage:
    """The map in a picture whose size suits ``layout`` (`layout_of`)."""
    down, across = _grid(laid_out, layout)
    tiles = _tiles(picture, down, across)
    if layout in _PLACES:
        faces = np.stack([np.rot90(tiles[row, column], turns) for row, column, turns in _PLACES[layout]])
    else:
        faces = tiles.reshape(-1, *tiles.shape[2:])
    return EnvImage(laid_out, as_seen_inside(faces) if laid_out == CUBE else faces)


def picture_from_faces(image: EnvImage, layout: str | None = None) -> Picture:
    """The picture of a map; what a cross leaves empty is 0.

    By default cubes are vertical strips and dual paraboloids lie side by side. Raises RefletError where the map has no
    such layout.
    """
    laid_out, texels = image.parameterization, image.texels
    possible = layouts_of(laid_out)
    if layout is None:
        layout = "horizontal-strip" if laid_out.face_count == 2 else possible[0]
    if layout not in possible:
        what = f"one of {', '.join(possible)}" if len(possible) > 1 else "none, it is one picture"
        raise RefletError(f"The layout of a {laid_out} map is {what}; {layout} came, which is for cubes (--to cube).")
    faces = as_seen_inside(texels) if laid_out == CUBE else texels
    down, across = _grid(laid_out, layout)
    _, rows, columns, channels = faces.shape
    picture = np.zeros((down * rows, across * columns, channels), faces.dtype)
    tiles = _tiles(picture, down, across)
    if layout in _PLACES:
        for face, (row, column, turns) in zip(faces, _PLACES[layout], strict=True):
            tiles[row, column] = np.rot90(face, -turns)
    else:
        tiles[...] = faces.reshape(tiles.shape)
    return picture


def as_seen_inside(faces: Faces) -> Faces:
    """Cube faces as pictures, or such pictures as faces; see above."""
    return np.ascontiguousarray(faces[[1, 0, 2, 3, 4, 5]][:, :, ::-1])


def _tiles(picture: np.ndarray, down: int, across: int) -> np.ndarray:
    """View of a picture as (down, across, rows, columns, channels)."""
    height, width, channels = picture.shape
    return picture.reshape(down, height // down, across, width // across, channels).swapaxes(1, 2)
