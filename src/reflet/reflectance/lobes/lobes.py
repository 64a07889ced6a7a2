"""Any isotropic BRDF as a few radially symmetric lobes, which prefiltered maps can hold.

A map prefiltered with a BRDF is five-dimensional in general [Heidrich00, eq. 14]. Kautz and McCool replace the BRDF by
p(n·r, r·l), radially symmetric about the mirrored direction r, and take n·l for n·r where the lobe is bright:

    L(v, n) = ∫ f·(n·l)·L(l) dω  ≈  (n·r)·∫ p(n·r, r·l)·L(l) dω            [Heidrich00, eqs 18 and 19]

three-dimensional: a map looked up by direction for each n·r = n·v. What a map needs is the kernel k = (n·r)·p itself,
so we fit it to the *product* f·(n·l), and not p to f: the assumption n·l ≈ n·r is then no source of error of its own.

**The fit.** For one view angle let q(l) = f·max(n·l, 0) on the whole sphere, 0 beneath the surface. Among kernels
k(angle to axis) the one of least ∫ (q - k)² dω is the mean of q over each circle about the axis: the averaging of
Kautz and McCool. It keeps the albedo, ∫ k dω = ∫ q dω. For several lobes we look for all kernels of least
∫ (q - Σ k)² dω together, each piecewise linear, Σ_j x_j·hat_j(θ) with x_j ≥ 0, and scale them to the albedo of q: in
a constant environment the lobes reflect what the BRDF reflects. Where lobes have two axes, each must fall off from its
own: else one would draw a part of the other as a ring about itself, at little gain (a hundredth of the error).

**Axes.** The retro lobe's is the view direction; the glossy lobe's lies in the plane of incidence (`lobe_axes`), a
table over the view angle. The diffuse lobe is the cosine about the normal, times an albedo.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy.optimize import isotonic_regression
from scipy.sparse import csr_array, dia_array, hstack

from reflet.errors import RefletError
from reflet.reflectance.brdfs.brdf import Brdf
from reflet.reflectance.lobes.lobe_axes import glossy_axes
from reflet.reflectance.lobes.lobe_frame import angle_to, cosine_weighted, polar_points

KINDS = ("diffuse", "glossy", "retro")
THETA = np.pi * np.linspace(0.0, 1.0, 97) ** 2
"""Angles to the axis, in radians, at which kernels are tabulated."""

_SWEEPS = 1000  # at most


@dataclass(frozen=True)
class Lobe:
    """One lobe for all view angles.

    ``axis_angle``: from the normal, in the plane of incidence, in radians, positive on the mirrored side and negative
    on the viewer's. ``densities``: the kernel at `THETA`, per steradian, the cosine n·l inside.
    """

    name: str
    axis_angle: Float[np.ndarray, "angles"]
    densities: Float[np.ndarray, "angles thetas channels"]

    @property
    def side(self) -> int:
        """1 for lobes about the mirrored direction, -1 for those about the viewer's."""
        return -1 if self.name == "retro" else 1

    @property
    def albedo(self) -> Float[np.ndarray, "angles channels"]:
        """∫ k dω."""
        return self._rings().sum(1)

    @property
    def half_width(self) -> float:
        """The least angle, in radians, within which half of a slice's albedo lies; slices of little albedo aside."""
        rings = self._rings().sum(-1)
        albedo = rings.sum(1)
        within = np.cumsum(rings, 1)[albedo > 0.1 * albedo.max()]
        return float(THETA[1 + (within < 0.5 * within[:, -1:]).sum(1).min(initial=len(THETA) - 2)])

    def _rings(self) -> Float[np.ndarray, "angles rings channels"]:
        """∫ k dω = 2π·∫ k·sin θ dθ between entries of `THETA`, by two Gauss nodes, good to (π/48)⁵."""
        node = np.array([-1.0, 1.0]) / np.sqrt(3.0)
        share = (0.5 + 0.5 * node)[:, None]
        theta = (1.0 - share) * THETA[:-1] + share * THETA[1:]
        weight = np.pi * np.sin(theta) * np.diff(THETA)  # 2π, halved for each of two nodes
        lower, upper = self.densities[:, None, :-1], self.densities[:, None, 1:]
        return np.einsum("st,astc->atc", weight, lower * (1.0 - share[..., None]) + upper * share[..., None])


@dataclass(frozen=True, eq=False)
class Lobes:
    """What stands for a BRDF: f·(n·l) ≈ diffuse·(n·l)/π + Σ lobes, at evenly spaced, ascending ``cos_theta_o`` up to 1.

    ``error`` is √(∫ (f·(n·l) - approximation)² dω / ∫ (f·(n·l))² dω) for each view angle, over the whole sphere: what
    lobes have beneath the surface counts.
    """

    cos_theta_o: Float[np.ndarray, "angles"]
    diffuse: Float[np.ndarray, "angles channels"]
    lobes: tuple[Lobe, ...]
    error: Float[np.ndarray, "angles"]

    def axis_angle(self, lobe: Lobe, n_dot_v: Float[np.ndarray, "*batch"]) -> Float[np.ndarray, "*batch"]:
        """A lobe's axis for any view angle. What is blended is its distance from the mirrored or view direction."""
        apart = lobe.axis_angle - lobe.side * np.arccos(self.cos_theta_o)
        view = np.arccos(np.clip(n_dot_v, -1.0, 1.0))
        return np.asarray(lobe.side * view + np.interp(n_dot_v, self.cos_theta_o, apart))

    def cosine_weighted(self, k: int, direction: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "n channels"]:
        """What stands for f·max(n·l, 0) at view angle number ``k``, as the function `cosine_weighted` gives it."""
        total = np.maximum(direction[:, 1:2], 0.0) / np.pi * self.diffuse[k]
        for lobe in self.lobes:
            hats = _hats(angle_to(direction, float(lobe.axis_angle[k])))
            total = total + hats @ lobe.densities[k]
        return total


def view_cosines(count: int) -> Float[np.ndarray, "count"]:
    """The view angles of a map's slices: cosines evenly spaced from 1/count to 1; grazing ones are the first's."""
    return np.linspace(1.0 / count, 1.0, count)


def fit_lobes(brdf: Brdf, kinds: tuple[str, ...] = KINDS, angles: int = 16) -> Lobes:
    """The BRDF as lobes of these kinds (of `KINDS`), for ``angles`` view angles (`view_cosines`).

    Implements [Heidrich00, sec. 3.2.3], after [KautzMcCool00], with one lobe ("glossy",) or several. Raises RefletError
    for kinds unknown or none, for fewer than two angles, and for BRDFs that are negative or not finite.
    """
    if not kinds or not set(kinds) <= set(KINDS) or len(set(kinds)) < len(kinds):
        raise RefletError(f"Lobes are one or more of {', '.join(KINDS)}, each once, not {', '.join(kinds) or 'none'}.")
    if angles < 2:
        raise RefletError(f"A BRDF's lobes need at least 2 view angles, not {angles}; 16 are usual.")
    cosines = view_cosines(angles)
    glossy = glossy_axes(brdf, kinds, cosines) if "glossy" in kinds else np.zeros(angles)
    fits: list[_Fit] = []
    for cosine, axis in zip(cosines, glossy, strict=True):
        fits.append(_fit(brdf, kinds, float(cosine), float(axis), fits[-1] if fits else None))
    named = [kind for kind in kinds if kind != "diffuse"]
    return Lobes(
        cosines,
        np.array([fit.diffuse for fit in fits]),
        tuple(
            Lobe(name, np.array([fit.axes[i] for fit in fits]), np.array([fit.densities[i] for fit in fits]))
            for i, name in enumerate(named)
        ),
        np.array([fit.error for fit in fits]),
    )


@dataclass(frozen=True)
class _Fit:
    diffuse: np.ndarray
    axes: tuple[float, ...]
    densities: np.ndarray  # (lobes, thetas, channels)
    error: float


def _fit(brdf: Brdf, kinds: tuple[str, ...], cos_theta_o: float, glossy: float, before: _Fit | None) -> _Fit:
    """For one view angle; the search begins at the fit ``before``, of the next view angle."""
    theta_o = float(np.arccos(cos_theta_o))
    axes = tuple(glossy if kind == "glossy" else -theta_o for kind in kinds if kind != "diffuse")
    direction, solid_angle = polar_points(axes or (0.0,))
    q = cosine_weighted(brdf, cos_theta_o, direction)
    n_dot_l = np.maximum(direction[:, 1], 0.0)
    hats = [_hats(angle_to(direction, axis)) for axis in axes]
    columns = [csr_array(n_dot_l[:, None] / np.pi)] if "diffuse" in kinds else []
    matrix = csr_array(hstack([*columns, *hats]))
    blocks = [block.shape[1] for block in (*columns, *hats)]
    if before is None:
        start = np.zeros((matrix.shape[1], q.shape[1]))
    else:
        diffuse = [before.diffuse[None]] if "diffuse" in kinds else []
        start = np.concatenate([*diffuse, *before.densities])
    x = _least_squares(matrix, q, solid_angle, blocks, start, falls=float(np.ptp(axes or (0.0,))) > 1e-6)
    reflected = solid_angle @ (matrix @ x)
    x = x * np.divide(solid_angle @ q, reflected, out=np.ones_like(reflected), where=reflected > 0.0)
    rest = q - matrix @ x
    error = np.sqrt((solid_angle @ rest**2).sum() / max(float((solid_angle @ q**2).sum()), 1e-300))
    albedo = x[0] if "diffuse" in kinds else np.zeros(q.shape[1])
    densities = x[len(x) - len(axes) * len(THETA) :].reshape(len(axes), len(THETA), q.shape[1])
    return _Fit(albedo, axes, densities, float(error))


def _least_squares(
    matrix: csr_array,
    target: Float[np.ndarray, "points channels"],
    weight: Float[np.ndarray, "points"],
    blocks: list[int],
    start: Float[np.ndarray, "unknowns channels"],
    falls: bool,
) -> Float[np.ndarray, "unknowns channels"]:
    """The x ≥ 0 of least Σ weight·(A·x - target)², where it ``falls`` not ascending within any block of unknowns.

    Block by block: hats overlap with their neighbours alone, and add up to 1, so that within a block AᵀWA is at most
    the diagonal matrix D of its row sums. Hence (y - z)ᵀD(y - z) with y = x + D⁻¹·gradient bounds what is to be made
    small from above and touches it at z = x: its least value under the conditions, an isotonic regression, is a step
    down. Blocks that do the same, as all lobes at normal incidence, keep what they ``start`` with, up to what the first
    of them takes or leaves: what they share must not jump between view angles that playback blends.
    """
    square = (matrix.T @ (dia_array((weight[None], 0), shape=(len(weight), len(weight))) @ matrix)).toarray()
    right = matrix.T @ (target * weight[:, None])
    x = start
    ends = np.cumsum(blocks)
    spans = [slice(end - count, end) for end, count in zip(ends, blocks, strict=True)]
    bounds = [np.maximum(square[span, span].sum(1), 1e-300) for span in spans]
    for _ in range(_SWEEPS):
        before = x.copy()
        for span, bound in zip(spans, bounds, strict=True):
            aim = x[span] + (right[span] - square[span] @ x) / bound[:, None]
            if falls:
                each = [isotonic_regression(aim[:, c], weights=bound, increasing=False).x for c in range(aim.shape[1])]
                aim = np.stack(each, -1)
            x[span] = np.maximum(aim, 0.0)
        if np.abs(x - before).max() <= 1e-5 * np.abs(x).max():
            break
    return x


def _hats(theta: Float[np.ndarray, "n"]) -> csr_array:
    """Weights (n, thetas) of the entries of `THETA` in linear interpolation."""
    at = np.clip(np.searchsorted(THETA, theta, side="right") - 1, 0, len(THETA) - 2)
    share = (theta - THETA[at]) / (THETA[at + 1] - THETA[at])
    weights = np.stack([1.0 - share, share], -1).ravel()
    columns = np.stack([at, at + 1], -1).ravel()
    return csr_array((weights, columns, 2 * np.arange(len(theta) + 1)), shape=(len(theta), len(THETA)))
