"""An environment drawn by formula: a court with labelled, coloured walls under a sky with a sun.

Every direction can be told from its picture: the walls +X -X +Z -Z each have a colour and their name, as have the floor
-Y and a board overhead, +Y. Text reads as seen from inside; mirrored text in an environment map is a mirrored axis.
"""

from functools import lru_cache

import numpy as np
from jaxtyping import Float
from PIL import Image, ImageDraw, ImageFont
from scipy.ndimage import map_coordinates

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.cube import CUBE

SUN = np.array([0.52, 0.74, 0.42]) / np.linalg.norm([0.52, 0.74, 0.42])
SUN_RADIANCE = 2000.0
SUN_RADIUS = np.radians(1.2)  # larger than the sun's 0.27°, so that small maps show a disc

# Heights and half widths in units of the walls' distance from the middle, where the viewer is
_FLOOR, _WALL_TOP, _BEAM, _BEAM_TOP, _BOARD = -0.62, 0.34, 0.60, 0.71, 0.42
_LETTER = 0.62  # height of a label's sheet on its wall
_SHEET = 256  # pixels of that height

# Radiance: albedo times light
_WALLS = {"+X": (0.20, 0.045, 0.03), "-X": (0.02, 0.22, 0.20), "+Z": (0.06, 0.05, 0.20), "-Z": (0.55, 0.30, 0.03)}
_LABELS = (*_WALLS, "+Y", "-Y")
_STONE, _DARK_STONE, _PALE = np.array([0.42, 0.38, 0.33]), np.array([0.09, 0.08, 0.075]), np.array([0.85, 0.82, 0.75])
_GREEN, _MEDALLION = np.array([0.02, 0.14, 0.04]), np.array([0.20, 0.03, 0.12])
_ZENITH, _HORIZON, _HILLS = np.array([0.05, 0.14, 0.42]), np.array([0.55, 0.62, 0.72]), np.array([0.05, 0.09, 0.06])
_SUNLIGHT = np.array([1.0, 0.93, 0.82])

Directions = Float[np.ndarray, "*batch 3"]
Radiance = Float[np.ndarray, "*batch 3"]


def labelled_court(size: int, samples: int = 3) -> EnvImage:
    """The court as a cube of ``size``² texels a face, each the mean of ``samples``² points.

    Linear radiance, up to `SUN_RADIANCE` in the direction `SUN`.
    """
    fine, _ = CUBE.texel_directions(size * samples)
    texels = np.empty((6, size, size, 3), np.float32)
    for face in range(6):
        radiance = court_radiance(fine[face])
        texels[face] = radiance.reshape(size, samples, size, samples, 3).mean((1, 3))
    return EnvImage(CUBE, texels)


def court_radiance(direction: Directions) -> Radiance:
    """What is seen from the middle of the court in unit directions."""
    flat = direction.reshape(-1, 3)
    x, y, z = flat.T
    on_x = np.abs(x) >= np.abs(z)
    reach = np.maximum(np.where(on_x, np.abs(x), np.abs(z)), 1e-9)
    # On the plane of the wall ahead: to the right, as seen from inside, and up
    along, height = np.where(on_x, np.sign(x) * z, -np.sign(z) * x) / reach, y / reach
    overhead = _BOARD * y > reach
    floor = height < _FLOOR
    wall = (height < _WALL_TOP) & ~floor
    beam = (height > _BEAM) & (height < _BEAM_TOP)
    pillar = (height < _BEAM_TOP) & (np.abs(np.abs(along) - 0.5) > 0.44)
    stone = (beam | pillar) & ~wall & ~floor
    sky = ~(overhead | floor | wall | stone)
    side = np.where(on_x, np.where(x >= 0.0, 0, 1), np.where(z >= 0.0, 2, 3))
    out = np.empty_like(flat)
    out[sky] = _sky(flat[sky])
    out[stone] = _STONE * (0.55 + 0.45 * np.abs(along[stone, None]))
    out[wall] = _wall(side[wall], along[wall], height[wall])
    out[floor] = _floor(flat[floor])
    out[overhead] = _board(flat[overhead])
    return out.reshape(direction.shape)


def _sky(direction: Directions) -> Radiance:
    """A gradient, hills, and the sun with its glow."""
    x, y, z = direction.T
    elevation, azimuth = np.arcsin(np.clip(y, -1.0, 1.0)), np.arctan2(z, x)
    out = _HORIZON + (_ZENITH - _HORIZON) * np.maximum(y, 0.0)[:, None] ** 0.6
    cosine = direction @ SUN
    glow = 1.2 * np.maximum(cosine, 0.0) ** 600 + 0.3 * np.maximum(cosine, 0.0) ** 24
    out += glow[:, None] * _SUNLIGHT
    hills = np.radians(25.0 + 3.0 * np.sin(3.0 * azimuth + 1.0) + 1.5 * np.sin(7.0 * azimuth))
    out[elevation < hills] = _HILLS
    out[cosine > np.cos(SUN_RADIUS)] = SUN_RADIANCE * _SUNLIGHT
    return out


def _wall(side: np.ndarray, along: np.ndarray, height: np.ndarray) -> Radiance:
    """A coloured wall with a coping, its label in the middle, darker towards floor and corners."""
    up = (height - _FLOOR) / (_WALL_TOP - _FLOOR)
    shade = (0.55 + 0.45 * up) * (0.7 + 0.3 * np.minimum(4.0 * (1.0 - np.abs(along)), 1.0))
    courses = np.where(np.mod(up * 8.0, 1.0) < 0.06, 0.82, 1.0)
    out = np.array(list(_WALLS.values()))[side] * courses[:, None]
    ink = _ink(side, along / _LETTER, (height - 0.5 * (_FLOOR + _WALL_TOP)) / _LETTER)
    out = (out + (_PALE - out) * ink[:, None]) * shade[:, None]
    out[height > _WALL_TOP - 0.05] = 0.8 * _PALE
    return out


def _floor(direction: Directions) -> Radiance:
    """Tiles, and the label for those who look down with -z ahead."""
    x, y, z = direction.T
    right, ahead = x * _FLOOR / y, -z * _FLOOR / y
    out = np.where(((np.floor(right * 5.0) + np.floor(ahead * 5.0)) % 2)[:, None] > 0.5, _STONE, _DARK_STONE)
    medallion = np.hypot(right, ahead) < 0.3
    out[medallion] = _MEDALLION
    ink = _ink(np.full(len(y), 5), right / 0.42, ahead / 0.42) * medallion
    return out + (_PALE - out) * ink[:, None]


def _board(direction: Directions) -> Radiance:
    """A framed board with its label, for those who look up with +z at the top of their view."""
    x, y, z = direction.T
    right, ahead = x / (_BOARD * y), z / (_BOARD * y)
    ink = _ink(np.full(len(y), 4), 0.7 * right, 0.7 * ahead)
    out = _GREEN + (_PALE - _GREEN) * ink[:, None]
    out[np.maximum(np.abs(right), np.abs(ahead)) > 0.86] = 0.7 * _STONE
    return out


def _ink(label: np.ndarray, right: np.ndarray, up: np.ndarray) -> np.ndarray:
    """Where a label has ink, in [0, 1]: its sheet reaches from -1 to 1 to the right and from -1/2 to 1/2 up."""
    sheets = _label_sheets()
    row = (np.clip(0.5 - up, 0.0, 1.0) + label) * _SHEET - 0.5
    column = (1.0 + right) * _SHEET - 0.5
    return map_coordinates(sheets, np.stack([row, column]), order=1, mode="constant")


@lru_cache(maxsize=1)
def _label_sheets() -> Float[np.ndarray, "rows columns"]:
    """All labels, one below the other."""
    sheets = Image.new("L", (2 * _SHEET, len(_LABELS) * _SHEET))
    draw, font = ImageDraw.Draw(sheets), ImageFont.load_default(0.8 * _SHEET)
    for number, label in enumerate(_LABELS):
        draw.text((_SHEET, (number + 0.5) * _SHEET), label, fill=255, font=font, anchor="mm", stroke_width=5)
    return np.asarray(sheets, np.float64) / 255.0
