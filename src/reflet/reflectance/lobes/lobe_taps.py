"""Lobes as few taps from a smooth pyramid: what a GPU reads a texel when it prefilters a cube in every frame.

A tap is a lookup of the pyramid in some direction, on a level whose texels are as wide as the tap is to be blurred. So
a lobe is made of a few blurs: one in its middle, and rings around it. Averaged over the azimuth, a ring at angle t of
blurs of standard deviation σ (per axis) has the density of von Mises and Fisher, convolved with a circle:

    g(θ) = c·exp((cos θ·cos t - 1)/σ²)·I₀(sin θ·sin t/σ²),    c = 1/(2πσ²·(1 - exp(-2/σ²))).

We choose rings, blurs and weights so that the lobes' distance ∫ |Σ w·g - k| dω is least: an upper bound of the
relative L1 error of what is filtered. Weights come from least squares with none below zero, reweighted to approach
that distance; rings and blurs from a search over them. Manson and Sloan [Manson16] fit taps for all places on a cube's
face and tabulate polynomials. We read a pyramid whose texels are nearly of one size instead (`probe_filter.wgsl`): a
lobe's taps are the same everywhere, and any kernel's are found in a tenth of a second.

Blurs are kept narrower than the lobe, for a level's texels are no true blurs, but depend on how they lie to the tap;
the middle's most of all, which is one tap, where eight of a ring's level each other out.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float
from scipy.optimize import minimize, nnls
from scipy.special import i0e

from reflet.reflectance.brdfs.kernel import Kernel
from reflet.reflectance.brdfs.phong import PhongKernel

RINGS, PER_RING = 6, 8  # many rings of few taps: tails of narrow lobes reach over decades of angles
MOST_TAPS = 64  # that shaders have room for
_LEAST_BLUR = 0.5  # of the step from tap to tap: such blurs join to a ring
_MOST_BLUR = 0.45  # of a ring's angle, or the lobe's half width at half height
_MOST_MIDDLE = 0.2  # of the half width: a wider one would make most of the peak alone, which then depends on its place
_WIDEST_BLUR = 0.235  # radians: of levels down to four texels to a right angle (0.6 texels); below, they are no blurs
_PHONG_PER_RING = 12
_PHONG_RING, _PHONG_BLUR = np.array([0.0, 0.62, 1.05, 1.54]), np.array([0.38, 0.37, 0.51, 0.69])  # of exponent 100
_EDGE = np.concatenate([[0.0], np.geomspace(1e-3, 1.0, 160)]) * np.pi
_ANGLE = np.concatenate([[0.6 * _EDGE[1]], np.sqrt(_EDGE[1:-1] * _EDGE[2:])])  # radians; each stands for its bin
_SOLID_ANGLE = -2.0 * np.pi * np.diff(np.cos(_EDGE))


@dataclass(frozen=True)
class LobeTaps:
    """Unit directions around +z, standard deviations per axis in radians, and weights.

    Weights are one for all channels, their sum 1, or three for each tap, for red, green and blue, whose sum is what the
    lobe reflects.
    """

    direction: Float[np.ndarray, "taps 3"]
    blur: Float[np.ndarray, "taps"]
    weight: Float[np.ndarray, "taps *channels"]


def lobe_taps(kernel: Kernel) -> LobeTaps:
    """Taps for a kernel that falls off from its middle: at most 1 + RINGS·PER_RING of them.

    Takes a tenth of a second.
    """
    density = density_over_bins(kernel)[:, None]
    search = RingSearch(density)
    angle, blur = search.rings(search.least(search.start(), 1000))
    return taps_of_rings(angle, blur, ring_weights(density, angle, blur)[0][:, 0])


@dataclass(frozen=True, eq=False)
class RingSearch:
    """Rings and blurs for a lobe's ``density``, in each channel as `density_over_bins` gives it.

    It goes over ``free``: logarithms of the steps from ring to ring, then of the middle's and the rings' blurs.
    """

    density: Float[np.ndarray, "angles channels"]

    def start(self) -> Float[np.ndarray, "free"]:
        """Rings that share the lobe out evenly."""
        return self._from_rings(self._even(self.density.mean(1) * _SOLID_ANGLE, RINGS))

    def start_with_floor(self) -> Float[np.ndarray, "free"]:
        """The last ring far out, for lobes of which a part lies beyond three half widths, broad and dim."""
        light = self.density.mean(1) * _SOLID_ANGLE
        far = np.where(3.0 * self._half_width < _ANGLE, light, 0.0)
        if far.sum() < 1e-3:
            return self.start()
        ring = self._even(light - far, RINGS - 1)
        return self._from_rings(np.append(ring, max(float(far @ _ANGLE / far.sum()), ring[-1] + 0.01)))

    @staticmethod
    def _even(light: Float[np.ndarray, "angles"], count: int) -> Float[np.ndarray, "rings"]:
        return np.interp(np.arange(1, count + 1) / (count + 1), np.cumsum(light) / light.sum(), _ANGLE)

    @staticmethod
    def _from_rings(ring: Float[np.ndarray, "rings"]) -> Float[np.ndarray, "free"]:
        return np.log(np.concatenate([np.diff(ring, prepend=0.0) + 1e-4, [0.5 * ring[0]], _MOST_BLUR * ring]))

    def rings(self, free: Float[np.ndarray, "free"]) -> tuple[np.ndarray, np.ndarray]:
        """Angles and blurs, the middle's first, within the limits of the module."""
        angle = np.concatenate([[0.0], np.minimum(np.cumsum(np.exp(free[:RINGS])), 3.0)])
        most = np.minimum(_WIDEST_BLUR, np.maximum(_MOST_BLUR * angle, _MOST_BLUR * self._half_width))
        most[0] = min(most[0], _MOST_MIDDLE * self._half_width)
        least = np.minimum(_LEAST_BLUR * 2.0 * np.pi / PER_RING * angle, most)
        return angle, np.clip(np.exp(free[RINGS:]), least, most)

    @cached_property
    def _half_width(self) -> float:
        """Of the narrowest channel."""
        high = self.density >= 0.5 * self.density.max(0)
        return float(np.where(high, _ANGLE[:, None], 0.0).max(0).min())

    def distance(self, free: Float[np.ndarray, "free"]) -> float:
        """What the best weights leave, the mean of all channels."""
        return float(ring_weights(self.density, *self.rings(free))[1].mean())

    def least(self, start: Float[np.ndarray, "free"], most_steps: int) -> Float[np.ndarray, "free"]:
        """Where the distance is least, as far as so many steps of the search lead from ``start``."""
        options = {"maxfev": most_steps, "xatol": 1e-2, "fatol": 1e-4}
        return np.asarray(minimize(self.distance, start, method="Nelder-Mead", options=options).x)


def phong_taps(phong_exponent: float) -> LobeTaps:
    """Taps for Phong's lobe without a search, in some 0.3 ms: for exponents that change from frame to frame.

    With t = θ·√(N + 1) the lobe tends to exp(-t²/2) as N grows. So rings and blurs of one lobe serve all, divided by
    √(N + 1), and weights follow from N itself. The lobes' distance is below 0.007 from N = 20 on, below 0.03 from 1 on.
    Raises RefletError unless N > 0.
    """
    kernel = PhongKernel(phong_exponent)
    scale = 1.0 / np.sqrt(phong_exponent + 1.0)
    ring, blur = _PHONG_RING * scale, np.minimum(_PHONG_BLUR * scale, _WIDEST_BLUR)
    weight, _ = ring_weights(density_over_bins(kernel)[:, None], ring, blur)
    return taps_of_rings(ring, blur, weight[:, 0], _PHONG_PER_RING)


def density_over_bins(kernel: Kernel) -> Float[np.ndarray, "angles"]:
    """The kernel at the angles that the search looks at, each of which stands for a bin; its integral is 1."""
    density = kernel.density(np.sin(0.5 * _ANGLE) ** 2)
    return np.asarray(density / np.sum(density * _SOLID_ANGLE))


def ring_weights(
    density: Float[np.ndarray, "angles channels"], ring: Float[np.ndarray, "rings"], blur: Float[np.ndarray, "rings"]
) -> tuple[Float[np.ndarray, "rings channels"], Float[np.ndarray, "channels"]]:
    """The rings' weights for each channel, with sum 1, and the distances that are left."""
    rings = _ring_density(ring, blur)
    weights, distances = np.empty((len(ring), density.shape[1])), np.empty(density.shape[1])
    for c, wanted in enumerate(density.T):
        floor = 1e-2 * wanted + 1e-4
        importance = np.sqrt(_SOLID_ANGLE / floor)
        for _ in range(3):
            weight, _ = nnls(rings * importance[:, None], wanted * importance)
            importance = np.sqrt(_SOLID_ANGLE / (np.abs(rings @ weight - wanted) + floor))
        weights[:, c] = weight / weight.sum()
        distances[c] = np.abs(rings @ weights[:, c] - wanted) @ _SOLID_ANGLE
    return weights, distances


def _ring_density(
    ring: Float[np.ndarray, "rings"], blur: Float[np.ndarray, "rings"]
) -> Float[np.ndarray, "angles rings"]:
    """g of the module."""
    sharpness = 1.0 / np.square(blur)
    along = sharpness * np.sin(_ANGLE)[:, None] * np.sin(ring)
    across = sharpness * (np.cos(_ANGLE)[:, None] * np.cos(ring) - 1.0)
    scale = sharpness / (-2.0 * np.pi * np.expm1(-2.0 * sharpness))
    return np.asarray(scale * np.exp(across + along) * i0e(along))  # i0e is I₀ times exp(-along)


def taps_of_rings(
    ring: Float[np.ndarray, "rings"],
    blur: Float[np.ndarray, "rings"],
    weight: Float[np.ndarray, "rings *channels"],
    per_ring: int = PER_RING,
) -> LobeTaps:
    """Every other ring is turned by half a step."""
    used = weight.reshape(len(ring), -1).max(1) > 0.0
    count = np.where(used, np.where(ring == 0.0, 1, per_ring), 0)
    of = np.repeat(np.arange(len(ring)), count)
    step = np.concatenate([np.arange(each) for each in count]) + 0.5 * (of % 2)
    phi, theta = 2.0 * np.pi * step / per_ring, ring[of]
    direction = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], -1)
    return LobeTaps(direction, blur[of], (weight.T / np.maximum(count, 1)).T[of])
