"""An environment as a quadtree of cube cells: its light, summed over ever larger pieces of the sphere."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, UInt8
from numba import njit

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.compiled_parameterization import direction_at, face_of, project

_COARSEST = 2  # cells along a cube face's edge at the root level
BRIGHT = 4.0
_FAINT = 1e-3  # of the mean radiance: what the darkest texel counts for a cell's centre of light


@dataclass(frozen=True)
class RadianceTree:
    """All levels' cells, the coarsest level first. On a level cells are ordered by face, then along a Morton curve, so
    that the children of a level's cell i are the next level's cells 4i to 4i + 3.

    ``light`` holds radiance times solid angle summed over a cell for each channel, and last the solid angle itself in
    steradians: 0 where no texel centre lies in the cell. ``centre`` is the cell's centre of light, a unit vector.
    ``bright`` is 1 where the cell's mean radiance is more than `BRIGHT` times that of the whole environment, else 0.
    Memory: 4·(channels + 4) bytes a cell, 8·size² cells; three times that while it is made.
    """

    size: int  # cells along an edge of the finest level
    centre: Float[np.ndarray, "cells 3"]
    light: Float[np.ndarray, "cells channels_and_one"]
    bright: UInt8[np.ndarray, "cells"]

    @property
    def level_count(self) -> int:
        """Number of levels."""
        return (self.size // _COARSEST).bit_length()

    @property
    def starts(self) -> np.ndarray:
        """Index of each level's first cell."""
        counts = [6 * cells_along(level) ** 2 for level in range(self.level_count)]
        return np.cumsum([0] + counts[:-1])


def cells_along(level: int) -> int:
    """Cells along a cube face's edge."""
    return _COARSEST << level


def cell_radius(level: int) -> float:
    """Angle in radians from a cell's middle to its corners at most: half a diagonal in the middle of a face."""
    return float(np.sqrt(2.0) / cells_along(level))


def radiance_tree(image: EnvImage, size: int) -> RadianceTree:
    """The tree of an environment, with ``size`` (a power of two, at least 2) cells along a face's edge at the finest.

    Every texel's light goes to the cell that its centre lies in. Sums are exact to rounding: no light is lost, and
    a cell's centre of light is that of its texels, weighted by their light in all channels together.
    """
    channels = image.texels.shape[-1]
    solid_angle = image.parameterization.texel_solid_angle(image.size)
    sums = np.zeros((6 * size * size, channels + 4), np.float32)
    mean = float(image.texels.mean())
    _sum_into(sums, image.parameterization.kind, image.texels, solid_angle, size, _FAINT * mean + 1e-30)
    levels = [sums]
    while len(levels[-1]) > 6 * _COARSEST**2:
        levels.append(levels[-1].reshape(-1, 4, channels + 4).sum(1))
    sums = np.concatenate(levels[::-1])
    length = np.linalg.norm(sums[:, :3], axis=-1, keepdims=True)
    centre = sums[:, :3] / np.where(length > 0.0, length, 1.0)
    light = sums[:, 3:].copy()
    limit = BRIGHT * light[:, :-1].sum() / max(light[:, -1].sum(), 1e-30)
    bright = light[:, :-1].sum(-1) > limit * light[:, -1]
    return RadianceTree(size, centre, light, bright.astype(np.uint8))


@njit(cache=True, error_model="numpy")
def _sum_into(sums, kind, texels, solid_angle, size, faint):  # type: ignore[no-untyped-def]
    """Adds (moment, light, solid angle) of all texels to their cells."""
    faces, rows, columns, channels = texels.shape
    for face in range(faces):
        for row in range(rows):
            for column in range(columns):
                omega = solid_angle[face, row, column]
                if omega <= 0.0:
                    continue
                x, y, z = direction_at(kind, face, (column + 0.5) / columns, (row + 0.5) / rows)
                on = face_of(x, y, z)
                s, t, _ = project(on, x, y, z)
                u = min(int((0.5 + 0.5 * s) * size), size - 1)
                v = min(int((0.5 + 0.5 * t) * size), size - 1)
                cell = sums[on * size * size + _morton(u, v)]
                brightness = faint
                for c in range(channels):
                    cell[3 + c] += omega * texels[face, row, column, c]
                    brightness += texels[face, row, column, c]
                cell[0] += omega * brightness * x
                cell[1] += omega * brightness * y
                cell[2] += omega * brightness * z
                cell[3 + channels] += omega


@njit(cache=True)
def _morton(u, v):  # type: ignore[no-untyped-def]
    """The bits of two numbers, interleaved."""
    code, bit = 0, 0
    while u or v:
        code |= (u & 1) << bit | (v & 1) << (bit + 1)
        u, v, bit = u >> 1, v >> 1, bit + 2
    return code
