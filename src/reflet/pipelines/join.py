"""Two round pictures from files, joined into the file of one environment map."""

from pathlib import Path

import numpy as np
from jaxtyping import Float

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.parameterization import Parameterization
from reflet.envmap.resampling.hemispheres import DUAL_PARABOLOID, HALF_TURN, HemispherePicture, join_hemispheres
from reflet.errors import RefletError
from reflet.files.pictures.picture_file import READ, read_picture_file
from reflet.pipelines.convert import WITH_MIP_LEVELS, check_size, write_levels
from reflet.progress import ProgressCallback, silent

Circle = tuple[float, float, float]


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

    Both were taken with the same ``projection`` and ``fov_deg``; ``back_circle`` is by default ``circle``. Pictures of
    8 bits are taken as sRGB, alpha is left out. Raises RefletError for what cannot be read, joined or written.
    """
    check_size(size)
    progress("read", 0, 1)
    pictures = [_radiance(path) for path in (front, back) if path is not None]
    progress("read", 1, 1)
    ahead = HemispherePicture(pictures[0], projection, fov_deg, circle)
    behind = HemispherePicture(pictures[1], projection, fov_deg, back_circle or circle) if back is not None else None
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


def _radiance(path: str | Path) -> Float[np.ndarray, "height width channels"]:
    """Red, green and blue, or grey, of a picture that is light."""
    if Path(path).suffix.lower() not in READ:
        raise RefletError(f"{path} is no picture that can be read; give a file that ends in {' '.join(READ)}.")
    pixels = read_picture_file(path).pixels
    pixels = pixels[..., : 3 if pixels.shape[2] >= 3 else 1]
    if not np.isfinite(pixels).all():
        raise RefletError(f"{path} holds radiance that is not finite (NaN or infinite); repair these pixels.")
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
