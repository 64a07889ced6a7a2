"""Where the glossy lobe of a BRDF points, for every view angle.

About the best axis, circle means of q = f·(n·l) err least. That need not be the mirrored direction: some BRDFs have
off-specular peaks, and the horizon cuts lobes. Playback blends the axes of neighbouring view angles, so they must not
jump, as the best ones do where a BRDF has two peaks of like strength. Between two view angles an axis may turn by the
angle between them as it pleases, and against the mirrored direction by as much: so it may stay with the mirrored
direction, with the normal, or beyond both. What it turns by more is punished. We look for the axes of least

    Σ (squared error, as a share of ∫ q² dω) + STIFFNESS·Σ (excess of the turn, in radians)²,

first among a few candidates for every view angle, by dynamic programming, then nearby.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float
from scipy.optimize import minimize_scalar

from reflet.reflectance.brdfs.brdf import Brdf
from reflet.reflectance.lobes.lobe_frame import RINGS, SPOKES, angle_to, cosine_weighted, polar_points

STIFFNESS = 10.0
_CANDIDATES = 9


def glossy_axes(
    brdf: Brdf, kinds: tuple[str, ...], cos_theta_o: Float[np.ndarray, "angles"]
) -> Float[np.ndarray, "angles"]:
    """Angles from the normal, in [0, π/2], of the glossy lobe beside other lobes of these kinds."""
    views = [_View(brdf, kinds, float(cosine)) for cosine in cos_theta_o]
    places = [view.candidates() for view in views]
    least: list[np.ndarray] = []  # of the sums that end with each candidate
    came_from: list[np.ndarray] = []
    for k, (view, (axes, _)) in enumerate(zip(views, places, strict=True)):
        own = np.array([view.error(axis) for axis in axes])
        if k == 0:
            least.append(own)
            continue
        step = view.theta_o - views[k - 1].theta_o
        turn = axes - places[k - 1][0][:, None] - step  # against the mirrored direction
        sums = least[-1][:, None] + STIFFNESS * np.maximum(np.abs(turn) - abs(step), 0.0) ** 2
        came_from.append(sums.argmin(0))
        least.append(own + sums.min(0))
    best = int(least[-1].argmin())
    chosen = [best]
    for back in came_from[::-1]:
        best = int(back[best])
        chosen.append(best)
    return np.array(
        [view.refined(axes[k], step) for view, (axes, step), k in zip(views, places, chosen[::-1], strict=True)]
    )


@dataclass(frozen=True)
class _View:
    """What one viewer sees."""

    brdf: Brdf
    kinds: tuple[str, ...]
    cos_theta_o: float

    @property
    def theta_o(self) -> float:
        return float(np.arccos(self.cos_theta_o))

    @property
    def _along_normal(self) -> bool:
        return self.theta_o < 1e-6  # all directions are alike

    @property
    def _reach(self) -> float:
        """Circles about the mirrored direction beyond it would meet a retroreflecting lobe."""
        return max(self.theta_o, 0.2)

    def candidates(self) -> tuple[np.ndarray, float]:
        """Axes, and the step between them: around mean directions by q², as far as q² spreads."""
        if self._along_normal:
            return np.zeros(1), 0.0
        axes, steps = [np.array([self.theta_o])], [0.05]
        for reach in (self._reach,) if "retro" in self.kinds else (self._reach, np.pi):
            direction, q, solid_angle = self._glossy(self.theta_o)
            weight = q**2 * solid_angle * (angle_to(direction, self.theta_o) <= reach)
            if weight.sum() > 1e-9:
                middle = float(np.arctan2(weight @ direction[:, 0], weight @ direction[:, 1]))
                variance = float(weight @ angle_to(direction, middle) ** 2 / weight.sum())
                spread = max(np.sqrt(variance), 1e-3)
                axes.append(middle + spread * np.linspace(-1.0, 1.0, _CANDIDATES))
                steps.append(2.0 * spread / (_CANDIDATES - 1))
        return np.clip(np.concatenate(axes), 0.0, 0.5 * np.pi), max(steps[1:], default=steps[0])

    def refined(self, axis: float, step: float) -> float:
        """The best axis within a step."""
        if self._along_normal:
            return 0.0
        bounds = (max(axis - step, 0.0), min(axis + step, 0.5 * np.pi))
        options = {"xatol": 0.02 * step, "maxiter": 16}
        return float(minimize_scalar(self.error, bounds=bounds, method="bounded", options=options).x)

    def error(self, axis: float) -> float:
        """What circle means about the axis err, squared, as a share."""
        if self._along_normal:
            return 0.0
        direction, q, solid_angle = self._glossy(axis)
        near = angle_to(direction, axis) <= (self._reach if "retro" in self.kinds else np.pi)
        rings = q.reshape(RINGS, SPOKES)
        rest = (rings - rings.mean(-1, keepdims=True)).ravel()
        return float(solid_angle @ (rest**2 * near) / max(float(solid_angle @ (q**2 * near)), 1e-300))

    def _glossy(self, axis: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Directions about an axis, q less what a diffuse lobe takes, and solid angles."""
        direction, solid_angle = polar_points((axis,))
        q = cosine_weighted(self.brdf, self.cos_theta_o, direction).mean(-1)
        if "diffuse" in self.kinds:
            q = np.maximum(q - self._floor * np.maximum(direction[:, 1], 0.0), 0.0)
        return direction, q, solid_angle

    @cached_property
    def _floor(self) -> float:
        """The least value of f within 60° of the normal, where both diffuse and glossy reflection are met."""
        direction, _ = polar_points((0.0,))
        direction = direction[direction[:, 1] > 0.5]
        return float((cosine_weighted(self.brdf, self.cos_theta_o, direction).mean(-1) / direction[:, 1]).min())
