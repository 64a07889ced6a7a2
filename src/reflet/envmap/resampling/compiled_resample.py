"""The loops of `resample`, compiled: means of the bilinear source over the footprints of destination texels.

Where a destination texel reads is known exactly by two changes of parameterization, full of arc tangents. Those are
taken at few places only: over a block of destination texels the source coordinates are a biquadratic function of the
place to within `_ACCURACY`, which is verified for every block; a block that fails (at a seam, a fold, a pole) is cut
in four, down to `_SMALLEST` texels, whose sub-samples are then computed one by one.
"""

from math import ceil, sqrt

import numpy as np
from numba import njit, prange

from reflet.envmap.parameterizations.compiled_parameterization import GAZING_BALL, direction_at, point_of, rate_at

_BLOCK = 16  # rows and columns of destination texels that one biquadratic serves at most
_SMALLEST = 2
_ACCURACY = 1.0 / 256.0  # source texels: the precision of filter weights on GPUs
_INSET = 1e-5  # of a block: nodes stay off the edges of blocks, where seams like to lie
_DENSITY = 2.0  # sub-samples per source texel and axis
_MOST = 64  # sub-samples per destination texel and axis
_STACK = 64  # blocks waiting to be done: three a level of cutting, and one


@njit(cache=True, inline="always")
def _counts(distance, density):  # type: ignore[no-untyped-def]
    """Sub-samples for a footprint that is so many source texels wide: one where the source is magnified."""
    return int(min(max(ceil(density * distance - 0.25), 1.0), _MOST))


@njit(cache=True, inline="always")
def _turned_grid(i, j, count_u, count_v):  # type: ignore[no-untyped-def]
    """Place of a sub-sample in its texel, in [0, 1]²: a grid turned a little, so that no two are in a row or column.

    Summed over a grid of spacing h, a tent's weight is off by its spectrum sinc²(x)·sinc²(y) at the grid's frequencies,
    most at (1/h, 0) and (0, 1/h). Turned off the axes, they lie where both factors are small.
    """
    return (j + (i + 0.5) / count_v) / count_u, (i + 1.0 - (j + 0.5) / count_u) / count_v


@njit(cache=True, fastmath=True, inline="always")
def _bilinear(texels, start, pitch, channels, x, y):  # type: ignore[no-untyped-def]
    """Channels of a padded face at (x, y), in texels from the top left corner; the fourth is 0 where there is none.

    ``texels`` is flat: the face begins at ``start``, its rows are ``pitch`` numbers long.
    """
    # the padding shifts by one, the centres of texels by a half
    x, y = x + 0.5, y + 0.5
    column, row = np.int64(x), np.int64(y)
    right, down = np.float32(x - column), np.float32(y - row)
    left, up = np.float32(1.0) - right, np.float32(1.0) - down
    a, b, c, d = left * up, right * up, left * down, right * down
    i = start + row * pitch + column * channels
    j, k = i + channels, i + pitch
    l = k + channels
    alpha = np.float32(0.0)
    if channels == 4:
        alpha = a * texels[i + 3] + b * texels[j + 3] + c * texels[k + 3] + d * texels[l + 3]
    return (
        a * texels[i] + b * texels[j] + c * texels[k] + d * texels[l],
        a * texels[i + 1] + b * texels[j + 1] + c * texels[k + 1] + d * texels[l + 1],
        a * texels[i + 2] + b * texels[j + 2] + c * texels[k + 2] + d * texels[l + 2],
        alpha,
    )


@njit(cache=True, inline="always")
def _turned(turn, x, y, z):  # type: ignore[no-untyped-def]
    """A direction of the destination as the source has it; exactly itself where the matrix is the identity."""
    return (
        turn[0, 0] * x + turn[0, 1] * y + turn[0, 2] * z,
        turn[1, 0] * x + turn[1, 1] * y + turn[1, 2] * z,
        turn[2, 0] * x + turn[2, 1] * y + turn[2, 2] * z,
    )


@njit(cache=True, fastmath=True, error_model="numpy")
def _one_by_one(padded, source_kind, to_kind, turn, face, row, column, size, aspect, density, sum_of):  # type: ignore[no-untyped-def]
    """Mean over one destination texel's footprint, every sub-sample exactly placed."""
    channels = padded.shape[3]
    rows, columns = padded.shape[1] - 2, padded.shape[2] - 2
    pitch, face_pitch, texels = (columns + 2) * channels, (rows + 2) * (columns + 2) * channels, padded.ravel()
    step_u, step_v = 1.0 / (aspect * size), 1.0 / size
    u, v = (column + 0.5) * step_u, (row + 0.5) * step_v
    x, y, z = direction_at(to_kind, face, u, v)
    x_at, y_at, z_at = _turned(turn, x, y, z)
    texels_per_radian = sqrt(rate_at(source_kind, x_at, y_at, z_at)) * rows
    across = down = 0.0
    for side in (-0.5, 0.5):
        x_on, y_on, z_on = direction_at(to_kind, face, u + side * step_u, v)
        across += sqrt((x_on - x) ** 2 + (y_on - y) ** 2 + (z_on - z) ** 2)
        x_on, y_on, z_on = direction_at(to_kind, face, u, v + side * step_v)
        down += sqrt((x_on - x) ** 2 + (y_on - y) ** 2 + (z_on - z) ** 2)
    count_u, count_v = _counts(across * texels_per_radian, density), _counts(down * texels_per_radian, density)
    sum_of[:] = 0.0
    count = 0
    for i in range(count_v):
        for j in range(count_u):
            along, below = _turned_grid(i, j, count_u, count_v)
            u, v = (column + along) * step_u, (row + below) * step_v
            # Outside its disc the ball sees nothing: all of that is one direction, of no solid angle.
            if to_kind == GAZING_BALL and (u - 0.5) ** 2 + (v - 0.5) ** 2 > 0.25:
                continue
            x, y, z = direction_at(to_kind, face, u, v)
            x, y, z = _turned(turn, x, y, z)
            on, u_on, v_on = point_of(source_kind, x, y, z)
            r, g, b, a = _bilinear(texels, on * face_pitch, pitch, channels, u_on * columns, v_on * rows)
            sum_of[0] += r
            sum_of[1] += g
            sum_of[2] += b
            sum_of[3] += a
            count += 1
    if count == 0:
        x, y, z = direction_at(to_kind, face, (column + 0.5) * step_u, (row + 0.5) * step_v)
        x, y, z = _turned(turn, x, y, z)
        on, u_on, v_on = point_of(source_kind, x, y, z)
        sum_of[0], sum_of[1], sum_of[2], sum_of[3] = _bilinear(
            texels, on * face_pitch, pitch, channels, u_on * columns, v_on * rows
        )
        count = 1
    sum_of /= np.float32(count)


@njit(cache=True, error_model="numpy")
def _place(source_kind, to_kind, turn, face, u, v, columns, rows):  # type: ignore[no-untyped-def]
    x, y, z = direction_at(to_kind, face, u, v)
    x, y, z = _turned(turn, x, y, z)
    on, u_on, v_on = point_of(source_kind, x, y, z)
    return on, u_on * columns, v_on * rows


@njit(cache=True, error_model="numpy")
def _fit(source_kind, to_kind, turn, face, row, column, height, width, size, aspect, columns, rows, node, fit):  # type: ignore[no-untyped-def]
    """Writes the biquadratic of one block: ``fit[axis, p, q]`` of s^p·t^q, s to the right, t down, in [0, 1].

    Returns the source's face, -1 where there is no one biquadratic.
    """
    step_u, step_v = 1.0 / (aspect * size), 1.0 / size
    on = -1
    for i in range(3):
        t = _INSET + 0.5 * i * (1.0 - 2.0 * _INSET)
        for j in range(3):
            s = _INSET + 0.5 * j * (1.0 - 2.0 * _INSET)
            u, v = (column + s * width) * step_u, (row + t * height) * step_v
            at, x, y = _place(source_kind, to_kind, turn, face, u, v, columns, rows)
            if on >= 0 and at != on:
                return -1
            on = at
            node[0, j, i], node[1, j, i] = x, y
    # Three values at 0, 1/2, 1 are f0 + (-3f0 + 4f1 - f2)s + (2f0 - 4f1 + 2f2)s².
    for axis in range(2):
        for i in range(3):
            f0, f1, f2 = node[axis, 0, i], node[axis, 1, i], node[axis, 2, i]
            node[axis, 1, i], node[axis, 2, i] = -3.0 * f0 + 4.0 * f1 - f2, 2.0 * (f0 - 2.0 * f1 + f2)
        for j in range(3):
            f0, f1, f2 = node[axis, j, 0], node[axis, j, 1], node[axis, j, 2]
            fit[axis, j, 0] = f0
            fit[axis, j, 1], fit[axis, j, 2] = -3.0 * f0 + 4.0 * f1 - f2, 2.0 * (f0 - 2.0 * f1 + f2)
    for i in range(2):
        for j in range(2):
            s, t = 0.25 + 0.5 * j, 0.25 + 0.5 * i
            u, v = (column + s * width) * step_u, (row + t * height) * step_v
            at, x, y = _place(source_kind, to_kind, turn, face, u, v, columns, rows)
            error = 0.0
            for axis in range(2):
                value = 0.0
                for p in range(2, -1, -1):
                    value = value * s + (fit[axis, p, 0] + t * (fit[axis, p, 1] + t * fit[axis, p, 2]))
                error = max(error, abs(value - (x if axis == 0 else y)))
            if at != on or not error < _ACCURACY:
                return -1
    return on


@njit(cache=True, error_model="numpy")
def _widths(fit, height, width):  # type: ignore[no-untyped-def]
    """Largest distances in source texels that one destination texel to the right and down cover in a block."""
    across = down = 0.0
    for i in range(2):
        for j in range(2):
            s, t = float(j), float(i)
            x_s = y_s = x_t = y_t = 0.0
            for p in range(3):
                for q in range(3):
                    if p > 0:
                        x_s += p * fit[0, p, q] * s ** (p - 1) * t**q
                        y_s += p * fit[1, p, q] * s ** (p - 1) * t**q
                    if q > 0:
                        x_t += q * fit[0, p, q] * s**p * t ** (q - 1)
                        y_t += q * fit[1, p, q] * s**p * t ** (q - 1)
            across = max(across, sqrt(x_s * x_s + y_s * y_s) / width)
            down = max(down, sqrt(x_t * x_t + y_t * y_t) / height)
    return across, down


@njit(cache=True, fastmath=True, error_model="numpy")
def _whole_block(padded, on, fit, out, face, row, column, height, width, density, sums):  # type: ignore[no-untyped-def]
    """Means over the footprints of a block's texels, sub-samples placed by its biquadratic."""
    wide, high = _widths(fit, height, width)
    count_u, count_v = _counts(wide, density), _counts(high, density)
    channels, source_channels = out.shape[3], padded.shape[3]
    pitch, texels = padded.shape[2] * source_channels, padded.ravel()
    start = on * padded.shape[1] * pitch
    scale = np.float32(1.0 / (count_u * count_v))
    for down in range(height):
        sums[:width] = 0.0
        for i in range(count_v):
            for j in range(count_u):
                along, below = _turned_grid(i, j, count_u, count_v)
                t = (down + below) / height
                x0 = fit[0, 0, 0] + t * (fit[0, 0, 1] + t * fit[0, 0, 2])
                x1 = fit[0, 1, 0] + t * (fit[0, 1, 1] + t * fit[0, 1, 2])
                x2 = fit[0, 2, 0] + t * (fit[0, 2, 1] + t * fit[0, 2, 2])
                y0 = fit[1, 0, 0] + t * (fit[1, 0, 1] + t * fit[1, 0, 2])
                y1 = fit[1, 1, 0] + t * (fit[1, 1, 1] + t * fit[1, 1, 2])
                y2 = fit[1, 2, 0] + t * (fit[1, 2, 1] + t * fit[1, 2, 2])
                for c in range(width):
                    s = (c + along) / width
                    r, g, b, a = _bilinear(
                        texels, start, pitch, source_channels, x0 + s * (x1 + s * x2), y0 + s * (y1 + s * y2)
                    )
                    sums[c, 0] += r
                    sums[c, 1] += g
                    sums[c, 2] += b
                    sums[c, 3] += a
        for c in range(width):
            for k in range(channels):
                out[face, row + down, column + c, k] = sums[c, k] * scale


@njit(cache=True, parallel=True, error_model="numpy")
def footprint_means(padded, source_kind, to_kind, turn, out, density):  # type: ignore[no-untyped-def]
    """Fills ``out`` (faces, rows, columns, up to 4 channels) from a padded source of 3 or 4 channels, float32 both.

    ``turn`` is source_from_destination, a rotation of directions (3, 3).
    """
    faces, size, width_of_face, channels = out.shape
    aspect = width_of_face // size
    rows, columns = padded.shape[1] - 2, padded.shape[2] - 2
    strips = (size + _BLOCK - 1) // _BLOCK
    for strip in prange(faces * strips):
        face, top = strip // strips, (strip % strips) * _BLOCK
        stack = np.empty((_STACK, 4), np.int64)
        node, fit = np.empty((2, 3, 3)), np.empty((2, 3, 3))
        sums = np.empty((_BLOCK, 4), np.float32)
        for left in range(0, width_of_face, _BLOCK):
            stack[0] = top, left, min(_BLOCK, size - top), min(_BLOCK, width_of_face - left)
            waiting = 1
            while waiting > 0:
                waiting -= 1
                row, column, height, width = stack[waiting]
                if height <= _SMALLEST and width <= _SMALLEST:
                    for r in range(row, row + height):
                        for c in range(column, column + width):
                            _one_by_one(padded, source_kind, to_kind, turn, face, r, c, size, aspect, density, sums[0])
                            for k in range(channels):
                                out[face, r, c, k] = sums[0, k]
                    continue
                on = _fit(
                    source_kind, to_kind, turn, face, row, column, height, width, size, aspect, columns, rows, node, fit
                )
                if on >= 0:
                    _whole_block(padded, on, fit, out, face, row, column, height, width, density, sums)
                    continue
                half_height, half_width = (height + 1) // 2, (width + 1) // 2
                for down in range(0, height, half_height):
                    for right in range(0, width, half_width):
                        stack[waiting] = (
                            row + down, column + right, min(half_height, height - down), min(half_width, width - right),
                        )  # fmt: skip
                        waiting += 1


@njit(cache=True, parallel=True, error_model="numpy")
def patch_means(padded, source_kind, directions, widths, out, density):  # type: ignore[no-untyped-def]
    """Fills ``out`` (n, channels) with means over square patches around unit directions, ``widths`` radians wide."""
    channels = padded.shape[3]
    rows, columns = padded.shape[1] - 2, padded.shape[2] - 2
    pitch, face_pitch, texels = (columns + 2) * channels, (rows + 2) * (columns + 2) * channels, padded.ravel()
    for n in prange(directions.shape[0]):
        x, y, z = directions[n, 0], directions[n, 1], directions[n, 2]
        # two axes across the direction [Duff17, eq. 3]
        sign = 1.0 if z >= 0.0 else -1.0
        a = -1.0 / (sign + z)
        b = x * y * a
        sx, sy, sz = 1.0 + sign * x * x * a, sign * b, -sign * x
        tx, ty, tz = b, sign + y * y * a, -y
        count = _counts(widths[n] * sqrt(rate_at(source_kind, x, y, z)) * rows, density)
        red = green = blue = alpha = 0.0
        for i in range(count):
            for j in range(count):
                s, t = _turned_grid(i, j, count, count)
                s, t = (s - 0.5) * widths[n], (t - 0.5) * widths[n]
                on, u, v = point_of(source_kind, x + s * sx + t * tx, y + s * sy + t * ty, z + s * sz + t * tz)
                r, g, b_, al = _bilinear(texels, on * face_pitch, pitch, channels, u * columns, v * rows)
                red, green, blue, alpha = red + r, green + g, blue + b_, alpha + al
        scale = 1.0 / count**2
        out[n, 0] = red * scale
        if out.shape[1] > 1:
            out[n, 1] = green * scale
        if out.shape[1] > 2:
            out[n, 2] = blue * scale
        if out.shape[1] > 3:
            out[n, 3] = alpha * scale
