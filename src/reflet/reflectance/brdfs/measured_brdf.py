"""Isotropic BRDFs given as a table, measured or computed.

The table holds f(θi, θo, Δφ) on a grid of angles; between them it is trilinear in the angles, beyond the first and last
it stays. The file format (`reflet.files.measured_brdf_file`) is a .npz archive of these four arrays.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float
from scipy.interpolate import RegularGridInterpolator

from reflet.errors import RefletError
from reflet.reflectance.brdfs.brdf import Brdf, Cosine, Values


@dataclass(frozen=True)
class MeasuredBrdf(Brdf):
    """Values per steradian at angles in radians: θ in [0, π/2], Δφ in [0, π] (0: light and viewer on one side).

    Raises RefletError where angles do not ascend or leave their ranges, or values are negative or not finite.
    """

    theta_i: Float[np.ndarray, "ni"]
    theta_o: Float[np.ndarray, "no"]
    delta_phi: Float[np.ndarray, "np"]
    values: Float[np.ndarray, "..."]  # (ni, no, np, channels): 1 channel, or 3 of linear Rec. 709

    def __post_init__(self) -> None:
        for name, angles, most in (
            ("theta_i", self.theta_i, 0.5 * np.pi),
            ("theta_o", self.theta_o, 0.5 * np.pi),
            ("delta_phi", self.delta_phi, np.pi),
        ):
            outside = angles.min(initial=0.0) < 0.0 or angles.max(initial=0.0) > most + 1e-6
            if len(angles) < 2 or outside or (np.diff(angles) <= 0.0).any():
                raise RefletError(
                    f"A BRDF table's {name} needs at least two ascending angles in [0, {most:.4f}] radians; repair it."
                )
        expected = (len(self.theta_i), len(self.theta_o), len(self.delta_phi))
        if self.values.shape[:3] != expected or self.values.ndim != 4 or self.values.shape[3] not in (1, 3):
            raise RefletError(
                f"A BRDF table's values need the shape {(*expected, '1 or 3')}, not {self.values.shape}; repair it."
            )
        if not np.isfinite(self.values).all() or self.values.min() < 0.0:
            raise RefletError("A BRDF table's values must be finite and not negative; repair them.")

    def evaluate(self, cos_theta_i: Cosine, cos_theta_o: Cosine, cos_delta_phi: Cosine) -> Values:
        """Trilinear in the angles."""
        grid = (self.theta_i, self.theta_o, self.delta_phi)
        angles = np.broadcast_arrays(
            *(np.arccos(np.clip(c, -1.0, 1.0)) for c in (cos_theta_i, cos_theta_o, cos_delta_phi))
        )
        inside = [np.clip(angle, axis[0], axis[-1]) for angle, axis in zip(angles, grid, strict=True)]
        return np.asarray(self._interpolator(np.stack(inside, -1)))

    @cached_property
    def _interpolator(self) -> RegularGridInterpolator:
        return RegularGridInterpolator((self.theta_i, self.theta_o, self.delta_phi), self.values)


def tabulate(brdf: Brdf, theta_count: int = 46, phi_count: int = 91) -> MeasuredBrdf:
    """A table of any BRDF, at evenly spaced angles (2° apart); the last θ is 89.9°, where formulas still hold."""
    theta = np.append(np.linspace(0.0, 0.5 * np.pi, theta_count)[:-1], np.deg2rad(89.9))
    phi = np.linspace(0.0, np.pi, phi_count)
    cosine = np.cos(theta)
    values = brdf.evaluate(cosine[:, None, None], cosine[None, :, None], np.cos(phi)[None, None, :])
    return MeasuredBrdf(theta, theta, phi, values)
