"""Light too bright for a texel format, spread over the directions around it: none is lost, and its middle stays.

A half float ends at 65504, and a sun in a picture of its true radiance is brighter than that by far. Cut off, it would
take its share of all light away: a third of an outdoor sky's, often. So what is too bright becomes a disc of even
radiance, the smallest around its own centre of gravity that the format can hold: it sends the same flux, of the same
colour, from the same direction.
"""

import warnings
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from reflet.envmap.env_image import EnvImage
from reflet.envmap.resampling.compiled_spread import TILE, fill_disc, power, sums_by_chord
from reflet.errors import RefletWarning

HALF_MAX = 65504.0
"""The largest half float."""

_STEPS_A_TEXEL = 4.0  # of a disc's radius
_MOST_STEPS = 1 << 14
_MOST_DISCS = 256  # what is left then is cut
_GROWTH = 3.0  # of the reach in which a disc is looked for


@dataclass(frozen=True)
class SpreadLight:
    """``share`` of all light was brighter than could be held; its widest disc has ``radius_deg``.

    ``lost`` is the share that is brighter still: of an image that is too bright on the mean.
    """

    image: EnvImage
    share: float
    radius_deg: float
    lost: float


def held(levels: Sequence[EnvImage], most: float, holder: str, instead: str | None = None) -> tuple[EnvImage, ...]:
    """The levels, each with what is above ``most`` spread (`spread_light`).

    Where there was any, a RefletWarning says of the level with most of it what share of the light it is. ``holder`` is
    what cannot hold it, in words; ``instead`` what to do to keep it as it is, by default to dim it all.
    """
    spread = [spread_light(level, most) for level in levels]
    worst = max(spread, key=lambda each: (each.lost, each.share))
    if worst.share > 0.0:
        said = f"{percent(worst.share)} of the light is brighter than {holder} can hold ({most:.0f})"
        if worst.lost > 0.0:
            said += f"; {percent(worst.lost)} is lost, for all is too bright on the mean"
        else:
            said += f"; none is lost, it now comes from up to {worst.radius_deg:.2g}° around"
        warnings.warn(f"{said}. {instead or _dimmed(levels, most)}", RefletWarning, stacklevel=2)
    return tuple(each.image for each in spread)


def _dimmed(levels: Sequence[EnvImage], most: float) -> str:
    """What helps where nothing but half floats will do: one factor, of a digit, for the whole environment."""
    factor = most / max(float(level.texels[..., :3].max()) for level in levels)
    digit = 10.0 ** np.floor(np.log10(factor))
    return f"To keep it as it is, dim it all: reflet convert IN OUT --scale {np.floor(factor / digit) * digit:g}."


def warn_of_cut(image: EnvImage) -> None:
    """A RefletWarning with the share of the light above 1, which is what .png files call white; under alpha, alpha."""
    color, alpha = image.texels[..., :3], image.texels[..., 3:]
    excess = np.maximum(color - (alpha if alpha.shape[-1] else np.float32(1.0)), 0.0)
    if not excess.any():
        return
    solid_angle = image.parameterization.texel_solid_angle(image.size)
    share = float(power(excess, solid_angle).sum() / power(color, solid_angle).sum())
    warnings.warn(
        f"{percent(share)} of the light is above 1, where .png files end, and is cut; write .hdr or .exr to keep it.",
        RefletWarning,
        stacklevel=2,
    )


def percent(share: float) -> str:
    """A share in words."""
    return f"{100.0 * share:.0f} %" if share >= 0.1 else f"{100.0 * share:.2g} %"


def spread_light(image: EnvImage, most: float) -> SpreadLight:
    """The image with no colour above ``most``, and its flux kept.

    From the brightest texel on, each that is above becomes a disc of one radiance, their mean, the smallest disc around
    the centre of gravity of its light for which that is at most ``most``. The flux is kept to a float's precision, its
    direction to a fraction of a texel. Beside the image, which is copied where anything is spread, memory is small.
    """
    texels = image.texels
    if not texels[..., :3].max() > most:
        return SpreadLight(image, 0.0, 0.0, 0.0)
    solid_angle = image.parameterization.texel_solid_angle(image.size)
    total = float(power(texels, solid_angle)[:3].sum())
    out = texels.astype(np.float32) if texels.shape[3] >= 3 else np.repeat(texels.astype(np.float32), 3, -1)
    bright = _bright(out, solid_angle, most)
    before = _above(out, solid_angle, bright, most)
    radius = 0.0
    left = bright
    for _ in range(_MOST_DISCS):
        brightness = out[..., :3][left].max(-1)
        still = brightness > most
        if not still.any():
            break
        left = tuple(index[still] for index in left)
        k = int(np.argmax(brightness[still]))
        radius = max(
            radius, _to_disc(image, out, solid_angle, (int(left[0][k]), int(left[1][k]), int(left[2][k])), most)
        )
    lost = _above(out, solid_angle, bright, most)
    np.minimum(out[..., :3], np.float32(most), out=out[..., :3])
    spread = EnvImage(image.parameterization, out[..., : texels.shape[3]].astype(texels.dtype, copy=False))
    return SpreadLight(spread, before / total, np.degrees(radius), lost / total if lost > 1e-6 * before else 0.0)


def _bright(texels: np.ndarray, solid_angle: np.ndarray, most: float) -> tuple[np.ndarray, ...]:
    """(faces, rows, columns) of the texels above ``most``, row by row: few, as a rule."""
    lines = np.argwhere(texels[..., :3].max((2, 3)) > most)
    found, column = np.nonzero((texels[lines[:, 0], lines[:, 1], :, :3] > most).any(-1))
    face, row = lines[found].T
    seen = solid_angle[face, row, column] > 0.0
    return face[seen], row[seen], column[seen]


def _above(texels: np.ndarray, solid_angle: np.ndarray, bright: tuple[np.ndarray, ...], most: float) -> float:
    """Flux of all colours beyond ``most``."""
    excess = np.maximum(texels[..., :3][bright].astype(np.float64) - most, 0.0).sum(-1)
    return float(excess @ solid_angle[bright])


def _to_disc(
    image: EnvImage, texels: np.ndarray, solid_angle: np.ndarray, brightest: tuple[int, int, int], most: float
) -> float:
    """Evens out the disc around one texel; returns its radius in radians."""
    kind, (rows, columns) = image.parameterization.kind, texels.shape[1:3]
    face, row, column = brightest
    uv = np.array([[(column + 0.5) / columns, (row + 0.5) / rows]])
    start = middle = image.parameterization.direction_from_uv(np.array([face]), uv)[0][0]
    omega = float(solid_angle[brightest])
    step = np.sqrt(omega) / _STEPS_A_TEXEL
    reach = 4.0 * np.sqrt(omega * max(float(texels[brightest][:3].max()) / most, 1.0))
    for centred in (False, False, True):
        while True:
            reach = min(reach, 2.0)
            step = max(step, reach / _MOST_STEPS)
            sums = np.zeros((len(texels) * -(-rows // TILE), int(reach / step) + 2, 7))
            sums_by_chord(texels, solid_angle, kind, middle, step, sums)
            disc = np.cumsum(sums.sum(0), 0)
            least = int(np.linalg.norm(start - middle) / step + 0.5)  # the brightest texel is in it
            mean = disc[:, :3] / np.maximum(disc[:, 3:4], 1e-300)
            fits = np.nonzero(mean[least:].max(-1) <= most)[0]
            if len(fits) or reach >= 2.0:
                break
            reach *= _GROWTH
        last = least + int(fits[0]) if len(fits) else len(disc) - 1
        if not centred:
            towards = disc[last, 4:]
            length = np.linalg.norm(towards)
            middle = towards / length if length > 0.0 else middle
    fill_disc(texels, kind, middle, step, last, mean[last])
    return float(2.0 * np.arcsin(min(0.5 * step * (last + 0.5), 1.0)))
