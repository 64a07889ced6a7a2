"""Kernels given as a table: the lobes of measured BRDFs.

Kautz and McCool approximate an isotropic BRDF by p(n·r, r·ω), radially symmetric about the mirrored direction r; its
prefiltered map has n·r as a third dimension [Heidrich00, eqs 18, 19]. One slice of it, at n·r = c, is the environment
filtered with the kernel k(θ) = c·p(c, cos θ): a table over θ. It is not normalized: its integral is the lobe's albedo.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from reflet.errors import RefletError
from reflet.reflectance.brdfs.kernel import Kernel


@dataclass(frozen=True)
class TabulatedKernel(Kernel):
    """Densities per steradian at ascending angles from 0 to at most π; linear in between, 0 beyond the last.

    Raises RefletError where the angles do not ascend from 0, or densities are negative or not finite.
    """

    theta: Float[np.ndarray, "angles"]
    densities: Float[np.ndarray, "angles"]

    def __post_init__(self) -> None:
        if len(self.theta) < 2 or self.theta[0] != 0.0 or (np.diff(self.theta) <= 0.0).any() or self.theta[-1] > np.pi:
            raise RefletError("A lobe's table needs angles that ascend from 0 to at most π radians; repair it.")
        if not np.isfinite(self.densities).all() or self.densities.min() < 0.0:
            raise RefletError("A lobe's densities must be finite and not negative; repair them.")

    def density(self, s: Float[np.ndarray, "*batch"]) -> Float[np.ndarray, "*batch"]:
        """θ = 2·asin(√s)."""
        return np.asarray(np.interp(2.0 * np.arcsin(np.sqrt(s)), self.theta, self.densities, right=0.0))
