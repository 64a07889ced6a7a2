"""The loops of `facts`, compiled: one pass over the texels, with no array as large as the map beside it."""

import numpy as np
from numba import njit, prange

from reflet.envmap.parameterizations.compiled_parameterization import direction_at

BINS = 1 << 19
"""Of luminance: by the float's sign-less exponent and 11 bits of its mantissa, so that a bin is 1/2048 wide."""
_SHIFT = 12
_STRIPS = 4  # each with sums and a histogram of its own
SUMS = 7  # least, greatest, the brightest's luminance and place; ∫ L d dω


@njit(cache=True, parallel=True, error_model="numpy")
def scan(texels, solid_angle, kind, weights, sums, power, histogram):  # type: ignore[no-untyped-def]
    """Fills ``sums`` (strips, SUMS), ``power`` (strips, colours) and ``histogram`` (strips, BINS, 2).

    The histogram has solid angle and flux by luminance: the sum of ``weights`` times colours.
    """
    faces, rows, columns, _ = texels.shape
    colours, strips = power.shape[1], sums.shape[0]
    for strip in prange(strips):
        mine = np.zeros(1, np.float32)
        bits = mine.view(np.uint32)
        least, greatest, brightest, place = np.inf, -np.inf, -np.inf, -1
        tx = ty = tz = 0.0
        for line in range(strip, faces * rows, strips):
            face, row = line // rows, line % rows
            for column in range(columns):
                omega = solid_angle[face, row, column]
                if omega <= 0.0:
                    continue
                luminance = 0.0
                for k in range(colours):
                    value = np.float64(texels[face, row, column, k])
                    least, greatest = min(least, value), max(greatest, value)
                    power[strip, k] += omega * value
                    luminance += weights[k] * value
                if luminance > brightest:
                    brightest, place = luminance, line * columns + column
                flux = omega * luminance
                x, y, z = direction_at(kind, face, (column + 0.5) / columns, (row + 0.5) / rows)
                tx, ty, tz = tx + flux * x, ty + flux * y, tz + flux * z
                mine[0] = max(luminance, 0.0)
                at = bits[0] >> np.uint32(_SHIFT)
                histogram[strip, at, 0] += omega
                histogram[strip, at, 1] += flux
        sums[strip, 0], sums[strip, 1], sums[strip, 2], sums[strip, 3] = least, greatest, brightest, place
        sums[strip, 4], sums[strip, 5], sums[strip, 6] = tx, ty, tz


def scanned(texels: np.ndarray, solid_angle: np.ndarray, kind: int, weights: np.ndarray) -> tuple[np.ndarray, ...]:
    """(least, greatest, place of the brightest, ∫ L d dω), ∫ colours dω, and (BINS, 2) of solid angle and flux."""
    sums = np.zeros((_STRIPS, SUMS))
    power = np.zeros((_STRIPS, len(weights)))
    histogram = np.zeros((_STRIPS, BINS, 2))
    scan(texels, solid_angle, kind, weights, sums, power, histogram)
    brightest = sums[np.argmax(sums[:, 2]), 3]
    return (
        np.array([sums[:, 0].min(), sums[:, 1].max(), brightest, *sums[:, 4:7].sum(0)]),
        power.sum(0),
        histogram.sum(0),
    )
