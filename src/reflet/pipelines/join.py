"""Two round pictures from files, joined into the file of one environment map."""

import warnings
from pathlib import Path

import numpy as np
from jaxtyping import Float

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.parameterization import Parameterization
from reflet.envmap.resampling.hemispheres import DUAL_PARABOLOID, HALF_TURN, HemispherePicture, join_hemispheres
from reflet.errors import RefletError, RefletWarning
from reflet.files.pictures.picture_file import READ, clipped_sentence, read_picture_file, unread_sentence
from reflet.pipelines.convert import WITH_MIP_LEVELS, check_size, write_levels
from reflet.progress import ProgressCallback, silent

Circle = tuple[float, float, float]
Picture = Float[np.ndarray, "height width channels"]
Half = Float[np.ndarray, "rows columns channels"]

_DARK_CORNERS = 0.1  # of the light inside: what flare and a lens's soft edge leave around its circle


def join(
    front: str | Path,
    back: str | Path | None,
    out: str | Path,
    *,
    projection: str = "equidistant",
    fov_deg: float | None = None,
    circle: Circle | None = None,
    back_circle: Circle | None = None,
    front_from_back: Float[np.ndarray, "3 3"] = HALF_TURN,
    blend_deg: float | None = None,
    balance: bool = False,
    to: Parameterization = DUAL_PARABOLOID,
    size: int | None = None,
    layout: str | None = None,
    progress: ProgressCallback = silent,
) -> EnvImage:
    """Joins picture files as `join_hemispheres` does, writes the map to ``out`` and returns it.

    Both were taken with the same ``projection`` and ``fov_deg``; ``back_circle`` is by default ``circle``. Without
    ``back`` both circles are in ``front`` where ``back_circle`` says so, or, no circle being given, where that is 2:1
    or 1:2: front and back side by side or one above the other, as cameras of two lenses write them. Pictures of 8 bits
    are taken as sRGB, alpha is left out. Warns of what is read with a doubt. Raises RefletError for what cannot be
    read, joined or written.
    """
    check_size(size)
    progress("read", 0, 1)
    first = _radiance(front)
    if back is not None:
        second: Picture | None = _radiance(back)
    elif circle is None and back_circle is None:
        first, second = _halves(front, first)
    else:
        second = first if back_circle is not None else None
    progress("read", 1, 1)
    ahead = HemispherePicture(first, projection, fov_deg, circle)
    behind = HemispherePicture(second, projection, fov_deg, back_circle or circle) if second is not None else None
    progress("join", 0, 1)
    image = join_hemispheres(
        ahead,
        behind,
        front_from_back=front_from_back,
        blend_deg=blend_deg,
        balance=balance,
        to=to,
        size=size,
    )
    progress("join", 1, 1)
    progress("write", 0, 1)
    with_mips = Path(out).suffix.lower() in WITH_MIP_LEVELS and image.size.bit_count() == 1
    write_levels(out, (image,), with_mips, layout=layout)
    progress("write", 1, 1)
    return image


def _halves(path: str | Path, pixels: Picture) -> tuple[Half, Half | None]:
    """The two squares of a picture of 2:1 or 1:2; any other picture, and None."""
    height, width = pixels.shape[:2]
    if width == 2 * height:
        halves = pixels[:, :height], pixels[:, height:]
    elif height == 2 * width:
        halves = pixels[:width], pixels[width:]
    else:
        return pixels, None
    if max(_light_in_corners(half) for half in halves) > _DARK_CORNERS:
        warnings.warn(
            f"{path} is taken for two circles beside each other, though it is not dark in the corners around them; "
            "if there is one, say where (--circle X,Y,R).",
            RefletWarning,
            stacklevel=3,
        )
    return halves


def _light_in_corners(square: Picture) -> float:
    """Mean radiance outside the circle that fills a square, over that inside."""
    at = (2.0 * np.arange(len(square)) + 1.0) / len(square) - 1.0
    radius = np.hypot(at, at[:, None])
    inside, outside = (float(square[where].mean()) for where in (radius < 1.0, radius > 1.1))
    return outside / inside if inside > 0.0 else 0.0


def _radiance(path: str | Path) -> Picture:
    """Red, green and blue, or grey, of a picture that is light."""
    if Path(path).suffix.lower() not in READ:
        raise RefletError(unread_sentence(path, "picture", READ))
    picture = read_picture_file(path)
    pixels = picture.pixels[..., : 3 if picture.pixels.shape[2] >= 3 else 1]
    if not np.isfinite(pixels).all():
        raise RefletError(f"{path} holds radiance that is not finite (NaN or infinite); mend them in a picture editor.")
    doubts = list(picture.doubts)
    clipped = pixels[(pixels >= picture.most).any(-1)]
    if clipped.size:
        share = float(clipped.sum(dtype=np.float64) / pixels.sum(dtype=np.float64))
        doubts.append(clipped_sentence(path, picture.most, share))
    for doubt in doubts:
        warnings.warn(doubt, RefletWarning, stacklevel=3)
    return pixels


def camera_turn(yaw_deg: float, pitch_deg: float, roll_deg: float) -> Float[np.ndarray, "3 3"]:
    """front_from_back of a camera that was turned by yaw about +y, pitched by pitch and rolled by roll about its axis.

    Yaw 180 is `HALF_TURN`; a positive pitch looks up, a positive roll turns the camera clockwise as its user sees it.
    """
    yaw, pitch, roll = np.radians([yaw_deg, -pitch_deg, roll_deg])
    about_y = np.array([[np.cos(yaw), 0.0, np.sin(yaw)], [0.0, 1.0, 0.0], [-np.sin(yaw), 0.0, np.cos(yaw)]])
    about_x = np.array([[1.0, 0.0, 0.0], [0.0, np.cos(pitch), -np.sin(pitch)], [0.0, np.sin(pitch), np.cos(pitch)]])
    about_z = np.array([[np.cos(roll), -np.sin(roll), 0.0], [np.sin(roll), np.cos(roll), 0.0], [0.0, 0.0, 1.0]])
    return about_y @ about_x @ about_z
