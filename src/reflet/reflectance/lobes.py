"""Any isotropic BRDF as a few radially symmetric lobes, which prefiltered maps can hold.

A map prefiltered with a BRDF is five-dimensional in general [Heidrich00, eq. 14]. Kautz and McCool replace the BRDF by
p(n·r, r·l), radially symmetric about the mirrored direction r, and take n·l for n·r where the lobe is bright:

    L(v, n) = ∫ f·(n·l)·L(l) dω  ≈  (n·r)·∫ p(n·r, r·l)·L(l) dω            [Heidrich00, eqs 18 and 19]

three-dimensional: a map looked up by direction for each n·r = n·v. What a map needs is the kernel k = (n·r)·p itself,
so we fit it to the *product* f·(n·l), and not p to f: the assumption n·l ≈ n·r is then no source of error of its own.

**The fit.** For one view angle let q(l) = f·max(n·l, 0) on the whole sphere, 0 beneath the surface. Among kernels
k(angle to axis) the one of least ∫ (q - k)² dω is the mean of q over each circle about the axis: the averaging of
Kautz and McCool. It keeps the albedo, ∫ k dω = ∫ q dω. For several lobes, each k a piecewise linear function
Σ_j x_j·hat_j(θ), the least ∫ (q - Σ k)² dω over all x_j ≥ 0 together is a non-negative least-squares problem. Its
solution is scaled to the albedo of q: in a constant environment the lobes reflect what the BRDF reflects.

**Axes.** The retro lobe's is the view direction. The glossy lobe's lies in the plane of incidence at the angle that
makes the error of circle means least, which is not the mirrored direction where a BRDF has an off-specular peak, or
where the horizon cuts a lobe: a table over the view angle. The diffuse lobe is the cosine about the normal, times an
albedo.

**Integrals.** Polar grids around every lobe's axis at angles θ = π·u², dense in the middle, over half the sphere (the
plane of incidence is a mirror for isotropic BRDFs); a point that lies in several grids counts 1/Σ of their densities.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy.optimize import minimize_scalar

from reflet.errors import RefletError
from reflet.reflectance.brdf import Brdf

KINDS = ("diffuse", "glossy", "retro")
THETA = np.pi * np.linspace(0.0, 1.0, 97) ** 2
"""Angles to the axis, in radians, at which kernels are tabulated."""

_RINGS, _SPOKES = 144, 24  # of a polar grid
_SWEEPS = 400  # at most


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


def view_cosines(count: int) -> Float[np.ndarray, "count"]:
    """The view angles of a map's slices: cosines evenly spaced from 1/count to 1; grazing ones are the first's."""
    return np.linspace(1.0 / count, 1.0, count)


def fit_lobes(brdf: Brdf, kinds: tuple[str, ...] = KINDS, angles: int = 16) -> Lobes:
    """The BRDF as lobes of these kinds (of `KINDS`), for ``angles`` view angles (`view_cosines`).

    Implements [Heidrich00, sec. 3.2.3] with one lobe ("glossy",) or several. Raises RefletError for kinds unknown or
    none, for fewer than two angles, and for BRDFs that are negative or not finite.
    """
    if not kinds or not set(kinds) <= set(KINDS) or len(set(kinds)) < len(kinds):
        raise RefletError(f"Lobes are one or more of {', '.join(KINDS)}, each once, not {', '.join(kinds) or 'none'}.")
    if angles < 2:
        raise RefletError(f"A BRDF's lobes need at least 2 view angles, not {angles}; 16 are usual.")
    cosines = view_cosines(angles)
    fits = [_fit(brdf, kinds, float(cosine)) for cosine in cosines]
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


def _fit(brdf: Brdf, kinds: tuple[str, ...], cos_theta_o: float) -> _Fit:
    theta_o = float(np.arccos(cos_theta_o))
    glossy = _best_axis(brdf, kinds, cos_theta_o) if "glossy" in kinds else 0.0
    axes = tuple(glossy if kind == "glossy" else -theta_o for kind in kinds if kind != "diffuse")
    direction, solid_angle = _points(axes or (0.0,))
    q = cosine_weighted(brdf, cos_theta_o, direction)
    n_dot_l = np.maximum(direction[:, 1], 0.0)
    hats = [_hats(_angle_to(direction, axis)) for axis in axes]
    columns = [n_dot_l[:, None] / np.pi] if "diffuse" in kinds else []
    matrix = np.concatenate(columns + hats, -1)
    x = _non_negative_least_squares(matrix, q, solid_angle)
    reflected = solid_angle @ matrix @ x
    x = x * np.divide(solid_angle @ q, reflected, out=np.ones_like(reflected), where=reflected > 0.0)
    rest = q - matrix @ x
    error = np.sqrt((solid_angle @ rest**2).sum() / max(float((solid_angle @ q**2).sum()), 1e-300))
    albedo = x[0] if "diffuse" in kinds else np.zeros(q.shape[1])
    densities = x[len(x) - len(axes) * len(THETA) :].reshape(len(axes), len(THETA), q.shape[1])
    return _Fit(albedo, axes, densities, float(error))


def _non_negative_least_squares(
    matrix: Float[np.ndarray, "points unknowns"],
    target: Float[np.ndarray, "points channels"],
    weight: Float[np.ndarray, "points"],
) -> Float[np.ndarray, "unknowns channels"]:
    """The x ≥ 0 of least Σ weight·(A·x - target)², by coordinate descent on the normal equations.

    It starts at 0, so that of unknowns which do the same (all lobes' at normal incidence) the first take all.
    """
    square = matrix.T @ (matrix * weight[:, None])
    right = matrix.T @ (target * weight[:, None])
    x = np.zeros(right.shape)
    seen = np.flatnonzero(np.diag(square) > 1e-12 * square.diagonal().max())
    for _ in range(_SWEEPS):
        before = x.copy()
        for j in seen:
            x[j] = np.maximum(x[j] + (right[j] - square[j] @ x) / square[j, j], 0.0)
        if np.abs(x - before).max() <= 1e-5 * np.abs(x).max():
            break
    return x


def cosine_weighted(
    brdf: Brdf, cos_theta_o: float, direction: Float[np.ndarray, "n 3"]
) -> Float[np.ndarray, "n channels"]:
    """f·max(n·l, 0) in directions of the frame in which n = +y and the mirrored side is +x.

    Raises RefletError for BRDFs that are negative or not finite.
    """
    above = direction[:, 1] > 1e-4
    x, y, z = direction[above].T
    across = np.maximum(np.hypot(x, z), 1e-12)
    values = brdf.evaluate(y, np.array([max(cos_theta_o, 1e-4)]), np.clip(-x / across, -1.0, 1.0))
    if not np.isfinite(values).all() or values.min(initial=0.0) < 0.0:
        raise RefletError("A BRDF must be finite and not negative for all directions above the surface; repair it.")
    q = np.zeros((len(direction), values.shape[-1]))
    q[above] = values * y[:, None]
    return q


def _points(axes: tuple[float, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Directions over the half sphere z > 0, each standing for a solid angle (doubled for the other half)."""
    u = (np.arange(_RINGS) + 0.5) / _RINGS
    spoke = (np.arange(_SPOKES) + 0.5) / _SPOKES * np.pi
    theta = np.pi * u[:, None] ** 2
    along, side, up = np.sin(theta) * np.cos(spoke), np.sin(theta) * np.sin(spoke), np.cos(theta) + 0.0 * spoke
    grids = [
        np.stack([np.sin(a) * up + np.cos(a) * along, np.cos(a) * up - np.sin(a) * along, side], -1).reshape(-1, 3)
        for a in axes
    ]
    direction = np.concatenate(grids)
    density = sum(_points_per_steradian(_angle_to(direction, a)) for a in axes)
    return direction, 2.0 / np.asarray(density)


def _points_per_steradian(theta: np.ndarray) -> np.ndarray:
    """dω = sin θ dθ dφ, dθ = 2π·u du, over φ in [0, π]."""
    theta = np.clip(theta, 1e-9, np.pi - 1e-6)
    return _RINGS * _SPOKES / (np.pi * 2.0 * np.sqrt(np.pi * theta) * np.sin(theta))


def _angle_to(direction: Float[np.ndarray, "n 3"], axis_angle: float) -> Float[np.ndarray, "n"]:
    apart = direction - np.array([np.sin(axis_angle), np.cos(axis_angle), 0.0])
    return np.asarray(2.0 * np.arcsin(np.minimum(0.5 * np.linalg.norm(apart, axis=-1), 1.0)))


def _hats(theta: Float[np.ndarray, "n"]) -> Float[np.ndarray, "n thetas"]:
    """Weights of the entries of `THETA` in linear interpolation."""
    at = np.clip(np.searchsorted(THETA, theta, side="right") - 1, 0, len(THETA) - 2)
    share = (theta - THETA[at]) / (THETA[at + 1] - THETA[at])
    weights = np.zeros((len(theta), len(THETA)))
    rows = np.arange(len(theta))
    weights[rows, at], weights[rows, at + 1] = 1.0 - share, share
    return weights


def _best_axis(brdf: Brdf, kinds: tuple[str, ...], cos_theta_o: float) -> float:
    """The glossy lobe's: the angle about which circle means of q, less what other lobes take, err least.

    It is searched about the mean direction weighted by q², as far as q² spreads.
    """
    theta_o = float(np.arccos(cos_theta_o))
    if theta_o < 1e-6:
        return 0.0  # all directions are alike
    floor = _floor(brdf, cos_theta_o) if "diffuse" in kinds else 0.0
    reach = max(theta_o, 0.2) if "retro" in kinds else np.pi  # circles beyond it would meet the retro lobe

    def glossy_share(axis: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        direction, solid_angle = _points((axis,))
        q = cosine_weighted(brdf, cos_theta_o, direction).mean(-1)
        q = np.maximum(q - floor * np.maximum(direction[:, 1], 0.0), 0.0)
        return direction, q, solid_angle

    direction, q, solid_angle = glossy_share(theta_o)
    weight = q**2 * solid_angle * (_angle_to(direction, theta_o) <= reach)
    x, y = weight @ direction[:, 0], weight @ direction[:, 1]
    if weight.sum() <= 1e-9:
        return theta_o
    middle = float(np.arctan2(x, y))
    spread = max(float(np.sqrt(weight @ _angle_to(direction, middle) ** 2 / weight.sum())), 1e-3)

    def error(axis: float) -> float:
        direction, q, solid_angle = glossy_share(axis)
        near = _angle_to(direction, axis) <= reach
        rings = q.reshape(_RINGS, _SPOKES)
        rest = (rings - rings.mean(-1, keepdims=True)).ravel()
        return float(solid_angle @ (rest**2 * near) / max(float(solid_angle @ (q**2 * near)), 1e-300))

    bounds = (max(middle - spread, 0.0), min(middle + spread, 0.5 * np.pi))
    best = minimize_scalar(error, bounds=bounds, method="bounded", options={"xatol": 0.01 * spread, "maxiter": 24})
    return float(best.x)


def _floor(brdf: Brdf, cos_theta_o: float) -> float:
    """The least value of f within 60° of the normal, where both diffuse and glossy reflection are met."""
    direction, _ = _points((0.0,))
    direction = direction[direction[:, 1] > 0.5]
    return float((cosine_weighted(brdf, cos_theta_o, direction).mean(-1) / direction[:, 1]).min())
