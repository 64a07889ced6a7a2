"""Radiance that no light has: not a number, infinite or negative. Found, told of, and put right."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Int

from reflet.envmap.env_image import EnvImage
from reflet.envmap.facts import azimuth_and_elevation

_MOST_ROUNDS = 64  # texels farther than so many from the nearest number become black


@dataclass(frozen=True)
class Flaws:
    """Texels with a component that is not a number, is infinite, or is negative, and where they are."""

    nan: int
    infinite: int
    negative: int
    rows: tuple[int, int]  # the first and the last row of a face with such a texel
    around: tuple[float, float]  # azimuth and elevation of their mean direction in degrees (`azimuth_and_elevation`)
    negative_share: float  # of the light, all components being taken as positive
    texel_count: int  # of the whole image

    def __str__(self) -> str:
        kinds = [f"{self.nan} not a number"] * (self.nan > 0) + [f"{self.infinite} infinite"] * (self.infinite > 0)
        if self.negative:
            kinds.append(f"{self.negative} negative ({100.0 * self.negative_share:.3g} % of the light)")
        first, last = self.rows
        azimuth, elevation = self.around
        rows = f"row {first}" if first == last else f"rows {first} to {last}"
        where = f"in {rows}, around azimuth {azimuth:.0f}°, elevation {elevation:.0f}°"
        return f"{', '.join(kinds)} of {self.texel_count} texels, {where}"


def flaws_of(image: EnvImage) -> Flaws | None:
    """What is wrong with an image's radiance, None where nothing is. No array as large as the image is made for that.

    Rows are counted from 0 at the top of a face.
    """
    texels = image.texels
    low, high = texels.min(), texels.max()  # not a number if one texel is
    if low >= 0.0 and high < np.inf:
        return None
    is_nan, is_infinite = np.isnan(texels).any(-1), np.isinf(texels).any(-1)
    with np.errstate(invalid="ignore"):
        is_negative = ((texels < 0.0) & (texels > -np.inf)).any(-1)
    return Flaws(
        int(is_nan.sum()),
        int(is_infinite.sum()),
        int(is_negative.sum()),
        *_where(image, is_nan | is_infinite | is_negative),
        _negative_share(image) if is_negative.any() else 0.0,
        is_nan.size,
    )


def repaired(image: EnvImage) -> tuple[EnvImage, Flaws | None]:
    """The image with finite radiance of at least 0, and what was wrong with it; the same image where nothing was.

    Negative components become 0. Infinite ones become the largest finite number of that channel in the image, for what
    overflowed was at least as bright; minus infinity is negative. What is not a number becomes the mean of the numbers
    around it on its face, and farther than 64 texels from any, 0.
    """
    flaws = flaws_of(image)
    if flaws is None:
        return image, None
    texels = np.array(image.texels)
    bright = np.isposinf(texels)
    if bright.any():
        finite = np.where(np.isfinite(texels), texels, 0.0).max((0, 1, 2))
        texels[bright] = np.broadcast_to(finite, texels.shape)[bright]
    with np.errstate(invalid="ignore"):
        np.copyto(texels, 0.0, where=texels < 0.0)
    _fill(texels, np.argwhere(np.isnan(texels)))
    return EnvImage(image.parameterization, texels), flaws


def _fill(texels: np.ndarray, missing: Int[np.ndarray, "n 4"]) -> None:
    """Replaces the components at (face, row, column, channel), ring after ring from the outside."""
    rows, columns = texels.shape[1:3]
    for _ in range(_MOST_ROUNDS):
        if not len(missing):
            return
        face, row, column, channel = missing.T
        total, count = np.zeros(len(missing)), np.zeros(len(missing))
        for down in (-1, 0, 1):
            for right in (-1, 0, 1):
                r, c = row + down, column + right
                there = (r >= 0) & (r < rows) & (c >= 0) & (c < columns)
                value = texels[face, np.clip(r, 0, rows - 1), np.clip(c, 0, columns - 1), channel]
                there &= ~np.isnan(value)
                total[there] += value[there]
                count += there
        known = count > 0
        if not known.any():
            break
        texels[tuple(missing[known].T)] = total[known] / count[known]
        missing = missing[~known]
    texels[tuple(missing.T)] = 0.0


def _where(
    image: EnvImage, flawed: Bool[np.ndarray, "faces rows columns"]
) -> tuple[tuple[int, int], tuple[float, float]]:
    """First and last row, and azimuth and elevation of the mean direction."""
    face, row, column = np.nonzero(flawed)
    _, rows, columns = flawed.shape
    uv = np.stack([(column + 0.5) / columns, (row + 0.5) / rows], -1)
    x, y, z = image.parameterization.direction_from_uv(face, uv)[0].mean(0).tolist()
    return (int(row.min()), int(row.max())), azimuth_and_elevation((x, y, z))


def _negative_share(image: EnvImage) -> float:
    colors = image.texels[..., :3]
    weight = image.parameterization.texel_solid_angle(image.size)
    with np.errstate(invalid="ignore"):
        finite = np.where(np.isfinite(colors), colors, 0.0)
    negative = float(np.einsum("frc,frck->", weight, np.maximum(-finite, 0.0)))
    total = float(np.einsum("frc,frck->", weight, np.abs(finite)))
    return negative / total if total else 0.0
