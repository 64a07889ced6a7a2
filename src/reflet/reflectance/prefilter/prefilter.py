"""Prefiltered maps, fast: the production path.

L(r) = ∫ k(θ)·L(ω) dω, where k falls over one scale in the middle of a lobe and over ever larger ones in its tail. So we
sum over a quadtree of the environment (`radiance_tree`), near cells small, far cells large, each standing for all its
light at its centre of light c: the deterministic limit of importance sampling with mip-filtered lookups, whose samples
read coarser levels where their density is lower [Colbert07]. As nothing is random and nothing left out, a sun of any
strength shows the kernel itself and no fireflies.

**Which cells.** Expand k about c over a cell with light of second moments Σ: the first order vanishes, c being the
centre, and what is left is ½·tr(Σ·Hess k). Evenly lit, a square of half diagonal R has R²/6 along each axis. We take
the error to be that of k averaged over four points at distance h = R/√3 around the centre, which has these moments:

    e(θ) = ¼·|k(θ - h) + k(θ + h) + 2k(√(θ² + h²)) - 4k(θ)|.

A cell is used if e ≤ tolerance·(k + 0.3/4π) wherever it may lie as seen from its tile, and else opened. The errors
of all cells add up to at most tolerance·(L(r) + 0.3·the mean of L over all directions); they are of both signs, and in
practice a tenth of that is left (up to an eighth with wide lobes, whose few cells are all alike: they get less of
it). A kernel's bend at the horizon makes e large on a thin ring and nowhere else: as it is the sum over cells that
counts, e may also pass by its mean over a fifth of θ to either side. That holds for light that is spread out. Bright
cells (suns, lamps), few as they are, must pass at every angle, with a tenth of the floor: near the horizon of a sun
there may be no other light to hide its error. Where opening ends, at the finest level, cells are used as they are.
Finally L is divided by Σ k·Ω and multiplied by ∫ k dω, as in `quadrature`, whose sum is
the limit for tolerance → 0.

**Narrow lobes** that hold few texels see the environment as it is shown, interpolated bilinearly; lobes that hold none
are a mirror's. A map can give no more than it knows between its texels: a gazing ball of R rows has but its last texel
within ψ = 4/√R rad of -z, where cos(ψ/2) = 1 - 2/R.

**Tiles.** Directions in one cell of a cube grid share the list of cells, found once for all of them.
"""

from collections.abc import Callable

import numpy as np
from jaxtyping import Bool, Float, Int, UInt8

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.cube import CUBE, face_from_direction
from reflet.envmap.parameterizations.parameterization import Parameterization
from reflet.envmap.resampling.resample import radiance_at, resample
from reflet.reflectance.brdfs.kernel import Kernel
from reflet.reflectance.brdfs.quadrature import check_radiance
from reflet.reflectance.prefilter.compiled_gather import OPEN, SKIP, TAKE, gather
from reflet.reflectance.prefilter.radiance_tree import RadianceTree, cell_radius, radiance_tree

TOLERANCE = 0.01
_WIDE, _OF_WIDE = 0.3, 0.6  # lobes of this half chord at half height and more get so much of the tolerance
_FLOOR = 0.3 / (4.0 * np.pi)  # see the module
_FINEST = 1024  # cells along a cube face's edge at most: 0.09°
_SUN = 512  # cells along the edge for the sake of suns, whatever the lobe, if texels are as small
_FINER = 16  # times finer than its texels an environment is interpolated at most
_PER_TILE = 16  # directions
_BINS = 4096  # of the half chord x = sin(θ/2), where verdicts are passed
_ENTRIES = 4096  # of the table of k
_TILES = 1024  # between two words on progress: some tenths of a second at most

Progress = Callable[[int, int], None]
"""Called with the number of directions done, and of all."""


def unheard(done: int, total: int) -> None:
    """Progress that nobody follows."""


def prefiltered(image: EnvImage, kernel: Kernel, to: Parameterization, size: int) -> EnvImage:
    """A prefiltered map of ``size`` rows a face, in float32: radiance, if the kernel is normalized.

    Raises RefletError for radiance that is negative or not finite.
    """
    return Prefilter(image).map(kernel, to, size)


class Prefilter:
    """An environment ready to be filtered with any number of kernels; its trees are built on demand and kept.

    There are two at most: one of its texels, and for narrow lobes one of what is interpolated between them.
    """

    def __init__(self, image: EnvImage, tolerance: float = TOLERANCE) -> None:
        """Raises RefletError for radiance that is negative or not finite."""
        check_radiance(image)
        self.image = image
        self.tolerance = tolerance
        self._trees: dict[bool, RadianceTree] = {}  # by whether the environment is interpolated

    def map(self, kernel: Kernel, to: Parameterization, size: int, progress: Progress = unheard) -> EnvImage:
        """See `prefiltered`."""
        direction, _ = to.texel_directions(size)
        return EnvImage(to, self.radiance(kernel, direction.reshape(-1, 3), progress).reshape(*to.shape(size), -1))

    def radiance(
        self, kernel: Kernel, direction: Float[np.ndarray, "n 3"], progress: Progress = unheard
    ) -> Float[np.ndarray, "n channels"]:
        """The environment filtered with ``kernel`` around unit directions."""
        table, width = _table(kernel)
        total = np.float32(_total(kernel, width))
        tree = self._tree_for(2.0 * np.arcsin(width))
        if tree is None:
            return radiance_at(self.image, direction).astype(np.float32) * total
        order, starts, centre, radius = _tiles(direction)
        tolerance = self.tolerance * (_OF_WIDE if width >= _WIDE else 1.0)
        verdict = _verdicts(kernel, tree.level_count, radius, tolerance)
        ordered = direction[order].astype(np.float32)
        channels = tree.light.shape[1] - 1
        texels = np.empty((len(direction), channels), np.float32)
        pieces = range(0, len(centre), _TILES)
        for first in range(0, channels, 3):
            some = min(3, channels - first)
            light = np.zeros((len(tree.light), 4), np.float32)
            light[:, :some], light[:, 3] = tree.light[:, first : first + some], tree.light[:, -1]
            sums = np.empty((len(direction), 4), np.float32)
            for tile in pieces:
                some_starts, some_centres = starts[tile : tile + _TILES + 1], centre[tile : tile + _TILES]
                gather(
                    *(sums, ordered, some_starts, some_centres),
                    *(tree.centre, light, tree.bright, tree.starts, verdict, table, width),
                )
                progress(first * len(direction) + some * int(some_starts[-1]), channels * len(direction))
            weight = np.maximum(sums[:, 3:], np.finfo(np.float32).tiny)
            texels[order, first : first + some] = sums[:, :some] / weight * total
        return texels

    def _tree_for(self, half_width: float) -> RadianceTree | None:
        """A tree whose cells are small against a lobe's angle of half height; None for lobes that are but a mirror's.

        Cells are as small as texels if need be. Where three texels do not fit into that angle, what lies between their
        centres matters: then the environment is interpolated, and where even that is too coarse, looked up.
        """
        texels = int(np.prod(self.image.parameterization.shape(self.image.size)))
        own = _power_of_two(np.sqrt(texels / 12.0))  # cells of half to two texels
        within = 0.5 * np.pi / half_width  # texels of this angle along a cube face's edge
        if own > 3.0 * within:
            size = min(max(_power_of_two(6.0 * within), _SUN), own, _FINEST)
        else:
            size = min(_power_of_two(6.0 * within), _FINER * own, _FINEST)
            if size < 2.0 * within:
                return None
        interpolated = size > own
        # A tree of what is interpolated, made before for narrower lobes, would serve too, but interpolation blurs: most
        # at creases and rims, where a gazing ball's texels are long.
        if interpolated not in self._trees or self._trees[interpolated].size < size:
            image = resample(self.image, CUBE, size) if interpolated else self.image
            self._trees[interpolated] = radiance_tree(image, size)
        return self._trees[interpolated]


def _power_of_two(number: float) -> int:
    return 1 << max(int(np.ceil(np.log2(number))), 1)


def _tiles(
    direction: Float[np.ndarray, "n 3"],
) -> tuple[Int[np.ndarray, "n"], Int[np.ndarray, "tiles_and_one"], Float[np.ndarray, "tiles 3"], float]:
    """Directions sorted by the cell of a cube grid: order, each tile's first, its middle, and the largest radius."""
    edge = max(int(np.sqrt(len(direction) / 6.0 / _PER_TILE)), 4)
    face, s, t = face_from_direction(direction)
    column, row = (np.minimum((0.5 + 0.5 * x) * edge, edge - 1).astype(np.int64) for x in (s, t))
    tile = (face * edge + row) * edge + column
    order = np.argsort(tile, kind="stable")
    starts = np.concatenate([[0], np.flatnonzero(np.diff(tile[order])) + 1, [len(direction)]])
    centre = np.add.reduceat(direction[order], starts[:-1])
    centre /= np.linalg.norm(centre, axis=-1, keepdims=True)
    apart = direction[order] - np.repeat(centre, np.diff(starts), 0)
    return order, starts, centre.astype(np.float32), float(2.0 * np.arcsin(0.5 * np.linalg.norm(apart, axis=-1).max()))


def _verdicts(kernel: Kernel, levels: int, tile_radius: float, tolerance: float) -> UInt8[np.ndarray, "2 levels bins"]:
    """What to do with plain and with bright cells of each level, by their half chord to the tile's middle."""
    theta = 2.0 * np.arcsin((np.arange(_BINS) + 0.5) / _BINS)

    def k(angle: np.ndarray) -> np.ndarray:
        return kernel.density(np.sin(0.5 * np.minimum(np.abs(angle), np.pi)) ** 2)

    here = k(theta)
    most, most_bright = tolerance * (here + _FLOOR), tolerance * (here + 0.1 * _FLOOR)
    verdict = np.empty((2, levels, _BINS), np.uint8)
    for level in range(levels):
        radius = cell_radius(level)
        h = radius / np.sqrt(3.0)
        error = 0.25 * np.abs(k(theta - h) + k(theta + h) + 2.0 * k(np.hypot(theta, h)) - 4.0 * here)
        used = _any_within(here > 0.0, theta, tile_radius + 2.0 * radius)
        for row, large in enumerate(((error > most) & (_mean_around(error, theta) > most), error > most_bright)):
            opened = _any_within(large, theta, tile_radius + 0.5 * radius) & (level < levels - 1)
            verdict[row, level] = np.where(used, np.where(opened, OPEN, TAKE), SKIP)
    return verdict


def _mean_around(value: Float[np.ndarray, "bins"], theta: Float[np.ndarray, "bins"]) -> Float[np.ndarray, "bins"]:
    """Means over [0.8·θ, 1.2·θ]."""
    width = np.gradient(theta)
    sums = np.concatenate([[0.0], np.cumsum(value * width)])
    widths = np.concatenate([[0.0], np.cumsum(width)])
    first, last = np.searchsorted(theta, 0.8 * theta), np.searchsorted(theta, 1.2 * theta, side="right")
    return np.asarray((sums[last] - sums[first]) / (widths[last] - widths[first]))


def _any_within(mask: Bool[np.ndarray, "bins"], theta: Float[np.ndarray, "bins"], reach: float) -> np.ndarray:
    """Whether the mask holds anywhere within ``reach`` radians, or in the bins that these end in."""
    counts = np.concatenate([[0], np.cumsum(mask)])
    first = np.maximum(np.searchsorted(theta, theta - reach) - 1, 0)
    last = np.minimum(np.searchsorted(theta, theta + reach, side="right") + 1, len(mask))
    return np.asarray(counts[last] > counts[first])


def _table(kernel: Kernel) -> tuple[Float[np.ndarray, "entries"], float]:
    """k at evenly spaced x·(1 + width)/(x + width), and the width: where k has fallen to half its most.

    Half of the entries are for x < width: linear interpolation errs by some (1/2000)²/8 there.
    """
    x = np.append(np.linspace(0.0, 1.0, 1 << 16)[1:], 1e-5)
    density = kernel.density(x * x)
    width = float(x[density >= 0.5 * density.max()].max())
    u = np.linspace(0.0, 1.0, _ENTRIES + 1)
    x = np.minimum(width * u / (1.0 + width - u), 1.0)
    return kernel.density(x * x).astype(np.float32), width


def _total(kernel: Kernel, width: float) -> float:
    """∫ k dω = 4π·∫ k·2x dx, in the u of `_table`: dx/du = width·(1 + width)/(1 + width - u)²."""
    u = (np.arange(1 << 16) + 0.5) / (1 << 16)
    x = width * u / (1.0 + width - u)
    return float(
        4.0 * np.pi * np.mean(kernel.density(x * x) * 2.0 * x * width * (1.0 + width) / (1.0 + width - u) ** 2)
    )
