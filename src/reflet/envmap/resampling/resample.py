"""Env images from one parameterization and size to another: no aliasing, no seams, no light lost.

A destination texel is the mean of the bilinearly interpolated source over its footprint (`compiled_resample`), from
sub-samples about half a source texel apart. That is a matrix G with rows that sum to 1, so that a constant stays
constant. Energy is kept if its columns, weighted by the texels' solid angles, give the source's: Σᵢ Ωᵢ·Gᵢⱼ = Ωⱼ.
Sampling keeps that in the mean over neighbours, which serves all that is smooth or large, but a single texel j is off
by some per cent: the sub-samples that fall into its tent are few. A sun is such a texel, and may hold most of the
light. So what is above a *ceiling* c goes another way, texel by texel: of Lⱼ > c only c²/Lⱼ stays, and the flux of the
rest, Fⱼ = Ωⱼ·(Lⱼ - c²/Lⱼ), is spread over the destination texels around it with weights made to give exactly that flux
(`_spread`). The ceiling is so low that a texel near it holds too little for its error to count, and so high that few
texels exceed it.
"""

import numpy as np
from jaxtyping import Float, Int

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.equal_area_octahedral import EqualAreaOctahedral
from reflet.envmap.parameterizations.parameterization import NONE, Directions, Faces, Parameterization
from reflet.envmap.resampling.compiled_resample import footprint_means, patch_means
from reflet.envmap.resampling.compiled_spread import power
from reflet.envmap.resampling.mip_reduction import halved
from reflet.envmap.resampling.padding import continued, fill_padding, outside_disc, padded
from reflet.envmap.rotations import UNTURNED, Rotation

_DENSITY = 2.25  # sub-samples per source texel and axis
_WIDEST = 4.0  # source texels across a footprint: from here on the source is halved first
_CEILING = 8.0  # times the mean radiance, at the least
_CEILING_SHARE = 1e-4  # of all light: no texel of average solid angle below the ceiling holds more, but for the above
_TENT_POINTS = 8  # across a bright texel's tent, at the least
_BLOCK = 1 << 16  # points of bright texels at a time

Texels = Float[np.ndarray, "faces rows columns channels"]
Indices = Int[np.ndarray, "bright 3"]
_NONE, _NO_COLOURS = np.empty((0, 3), np.int64), np.empty((0, 3))


def resample(image: EnvImage, to: Parameterization, size: int, source_from_result: Rotation = UNTURNED) -> EnvImage:
    """The same radiance in the parameterization ``to``, with ``size`` rows a face, turned if so wished.

    ``source_from_result`` is a rotation: the result shows in direction d what the source shows in that matrix times d.

    Constants stay constant. Total radiance Σ Ω·L is kept, and so is that of any sun in it. Magnified, the source is
    interpolated bilinearly; minified, averaged over the footprints of the destination's texels. What the source holds
    outside the disc of a round map is not read. In the result it is the map's continuation (the gazing ball's: its
    rim), so that filters never meet black.

    Up to four channels, computed in single precision; the fourth, alpha, has no ceiling. Beside source and result one
    copy of the source is held, of round maps two while bright texels are cut. The source itself where nothing changes.
    """
    if to == image.parameterization and size == image.size and np.array_equal(source_from_result, UNTURNED):
        return image
    turn = np.array(source_from_result, np.float64)  # a copy: for read-only arrays the loops would be compiled anew
    ceiling, bright = _bright(image)
    ratio = _least_ratio(image.parameterization, to, turn) * image.size / size
    source = _padded_source(image.parameterization, image.texels, ratio, bright, _excess(image, ceiling, bright))
    out = np.empty((*to.shape(size), source.shape[3]), np.float32)
    footprint_means(source, image.parameterization.kind, to.kind, turn, out, _DENSITY)
    out = out[..., : image.texels.shape[3]]
    if len(bright):
        _spread(image, ceiling, bright, ratio, to, turn, out)
    return EnvImage(to, np.ascontiguousarray(out, image.texels.dtype))


def radiance_at(
    image: EnvImage, direction: Directions, solid_angle: float | Float[np.ndarray, "*batch"] = 0.0
) -> Float[np.ndarray, "*batch channels"]:
    """Radiance in directions of any length but zero: the mean over a square patch around each, seamless.

    ``solid_angle`` is the patch's in steradians; 0 asks for the bilinearly interpolated radiance itself. Up to four
    channels, computed in single precision.
    """
    flat = np.reshape(direction, (-1, 3)).astype(np.float64)
    flat /= np.linalg.norm(flat, axis=-1, keepdims=True)
    width = np.sqrt(np.broadcast_to(np.asarray(solid_angle, np.float64), direction.shape[:-1])).ravel()
    texels_per_radian = np.sqrt(image.parameterization.sampling_rate(flat)) * image.size
    ratio = float((width * texels_per_radian).min(initial=1.0))
    source = _padded_source(image.parameterization, image.texels, ratio)
    out = np.empty((len(flat), source.shape[3]), np.float32)
    patch_means(source, image.parameterization.kind, flat, width, out, _DENSITY)
    out = out[:, : image.texels.shape[3]].astype(image.texels.dtype, copy=False)
    return out.reshape(*direction.shape[:-1], -1)


def _least_ratio(source: Parameterization, to: Parameterization, turn: Rotation) -> float:
    """Source texels across a destination texel, of equal sizes, where they are fewest."""
    everywhere = EqualAreaOctahedral().texel_directions(64)[0]
    return float(np.sqrt(source.sampling_rate(everywhere @ turn.T) / to.sampling_rate(everywhere)).min())


def _padded_source(
    parameterization: Parameterization,
    texels: Texels,
    ratio: float,
    bright: Indices = _NONE,
    excess: Float[np.ndarray, "bright colours"] = _NO_COLOURS,
) -> Float[np.ndarray, "faces padded_rows padded_columns at_least_three"]:
    """What the compiled loops read: a padded copy in single precision of 3 or 4 channels, halved while it is too fine.

    Where footprints are everywhere wider than `_WIDEST` texels, two by two of them can be averaged before: halves of
    `_WIDEST` are still fine enough not to be seen, and the work is bounded. ``bright`` texels have the ``excess`` taken
    from them.
    """
    channels = texels.shape[3]
    if channels > 4:
        raise ValueError(f"up to 4 channels expected, {channels} came")
    is_halved = ratio >= _WIDEST and texels.shape[1] % 2 == 0
    if channels >= 3 and not is_halved and not parameterization.is_round:
        source = padded(parameterization, texels.astype(np.float32, copy=False))
        if len(bright):
            source[:, 1:-1, 1:-1, :3][tuple(bright.T)] -= excess
            fill_padding(parameterization, source)
        return source
    if len(bright):
        texels = texels.copy()
        texels[..., :3][tuple(bright.T)] -= excess
    texels = continued(parameterization, texels, outside_disc(parameterization, texels.shape[1]))
    while ratio >= _WIDEST and texels.shape[1] % 2 == 0:
        texels, ratio = halved(parameterization, texels), ratio / 2.0
    if channels < 3:
        texels = np.pad(texels, ((0, 0), (0, 0), (0, 0), (0, 3 - channels)))
    return padded(parameterization, texels.astype(np.float32, copy=False))


def _bright(image: EnvImage) -> tuple[float, Indices]:
    """The ceiling, and (face, row, column) of the texels with a colour channel above it."""
    texels, size = image.texels, image.size
    colours = min(texels.shape[3], 3)
    solid_angle = image.parameterization.texel_solid_angle(size)
    flux = power(texels if texels.dtype.itemsize >= 4 else texels.astype(np.float32), solid_angle)
    mean = float(np.max(flux[:colours])) / (4.0 * np.pi)
    ceiling = mean * max(_CEILING, _CEILING_SHARE * texels[..., 0].size)
    rows = np.argwhere(texels.reshape(*texels.shape[:2], -1).max(-1) > ceiling)
    found, column = np.nonzero((texels[rows[:, 0], rows[:, 1], :, :colours] > ceiling).any(-1))
    return ceiling, np.concatenate([rows[found], column[:, None]], -1)


def _excess(image: EnvImage, ceiling: float, bright: Indices) -> Float[np.ndarray, "bright colours"]:
    """What of the colours of bright texels goes its own way."""
    colours = image.texels[..., :3][tuple(bright.T)].astype(np.float64)
    return np.where(colours > ceiling, colours - ceiling**2 / np.maximum(colours, ceiling), 0.0)


def _spread(
    image: EnvImage, ceiling: float, bright: Indices, ratio: float, to: Parameterization, turn: Rotation, out: Texels
) -> None:
    """Adds to ``out`` the excess of bright texels j: exactly the flux Fⱼ of each.

    The shape is the texel's bilinear tent, sampled by points p of weight wₚ, Σ wₚ = 1, each shared among the four
    destination texels i around it by their own bilinear weights bᵢₚ, which keeps its centre of gravity. Texel i gains
    the radiance Σₚ wₚ·bᵢₚ·Fⱼ/(κⱼ·Tᵢ) with Tᵢ the solid angle of the whole texel, half of it where the disc of a round
    map cuts more off: a sliver must not be blinding for want of solid angle. Then κⱼ = Σᵢₚ wₚ·bᵢₚ·Ωᵢ/Tᵢ, which is
    nearly 1 away from rims, makes the flux gained, Σᵢ Ωᵢ·(…), exactly Fⱼ.
    """
    colours, size = min(out.shape[3], 3), out.shape[1]
    solid_angle = image.parameterization.texel_solid_angle(image.size)
    solid_angle_to = to.texel_solid_angle(size)
    points = max(_TENT_POINTS, 2 * int(np.ceil(2.0 / ratio)))  # half a destination texel apart or less
    for some in np.array_split(bright, np.ceil(len(bright) * points**2 / _BLOCK)):
        flux = solid_angle[tuple(some.T)][:, None] * _excess(image, ceiling, some)
        direction, tent = _tents(image, some, points)
        taps, share = _taps(to, size, direction @ turn)  # by the transpose: back into the result
        flat, inverse = np.unique(np.ravel_multi_index(taps, out.shape[:3]), return_inverse=True)
        texel: tuple[Faces, ...] = np.unravel_index(flat, out.shape[:3])
        caught = solid_angle_to[texel]
        whole = np.maximum(caught, 0.5 * _whole_solid_angle(to, size, texel))
        inverse = inverse.reshape(len(some), -1)
        share = (share * tent[:, None]).reshape(inverse.shape) / whole[inverse]
        share /= (share * caught[inverse]).sum(-1, keepdims=True)
        for channel in range(colours):
            gain = np.bincount(inverse.ravel(), (share * flux[:, channel, None]).ravel(), len(flat))
            out[..., channel][texel] += gain
    # The rest of the flux's tents, outside the disc of a round map.
    out[...] = continued(to, out, solid_angle_to[0] == 0.0)


def _tents(
    image: EnvImage, texels: Indices, points: int
) -> tuple[Float[np.ndarray, "bright points 3"], Float[np.ndarray, "points"]]:
    """Directions of a square grid of points over each texel's bilinear tent, and their weights, which sum to 1.

    The tent of a texel at the edge of a face is half as wide, so as not to leave the face.
    """
    offset = (np.arange(points) + 0.5) * (2.0 / points) - 1.0
    weight = 1.0 - np.abs(offset)
    weight = np.outer(weight, weight).ravel() / weight.sum() ** 2
    _, rows, columns = image.parameterization.shape(image.size)
    face, row, column = texels.T[..., None]
    at_edge = (row == 0) | (row == rows - 1) | (column == 0) | (column == columns - 1)
    reach = np.where(at_edge, 0.5, 1.0)
    down, right = np.meshgrid(offset, offset, indexing="ij")
    u = (column + 0.5 + reach * right.ravel()) / columns
    v = (row + 0.5 + reach * down.ravel()) / rows
    direction, _ = image.parameterization.direction_from_uv(np.broadcast_to(face, u.shape), np.stack([u, v], -1))
    return direction, weight


def _taps(
    to: Parameterization, size: int, direction: Directions
) -> tuple[tuple[Int[np.ndarray, "*batch taps"], ...], Float[np.ndarray, "*batch taps"]]:
    """(face, row, column) of the four texels around each direction, and their bilinear weights.

    At a cube's corner a tap is missing; it has no weight.
    """
    face, uv = to.uv_from_direction(direction)
    _, rows, columns = to.shape(size)
    x, y = uv[..., 0, None] * columns - 0.5, uv[..., 1, None] * rows - 0.5
    column, row = np.floor(x) + np.array([0, 1, 0, 1]), np.floor(y) + np.array([0, 0, 1, 1])
    weight = (1.0 - np.abs(x - column)) * (1.0 - np.abs(y - row))
    # A direction exactly on an edge may round to one texel further than its neighbour.
    column, row = (np.clip(i.astype(np.int64), -1, n) for i, n in ((column, columns), (row, rows)))
    face, row, column = to.across_seams(np.broadcast_to(face[..., None], row.shape).copy(), row, column, size)
    return (np.maximum(face, 0), row, column), np.where(face == NONE, 0.0, weight)


def _whole_solid_angle(to: Parameterization, size: int, texel: tuple[Faces, ...]) -> Float[np.ndarray, "texels"]:
    """About the solid angle of texels, were they not cut by the disc of a round map."""
    face, row, column = texel
    _, rows, columns = to.shape(size)
    direction, _ = to.direction_from_uv(face, np.stack([(column + 0.5) / columns, (row + 0.5) / rows], -1))
    return 1.0 / (to.sampling_rate(direction) * size**2)
