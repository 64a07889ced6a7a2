"""Radiance over all directions at one resolution: what image files hold, and one level of an env map."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from reflet.envmap.parameterizations.parameterization import Parameterization


@dataclass(frozen=True)
class EnvImage:
    """The texels of one level, as (faces, rows, columns, channels): linear radiance, 3 channels or 4 with alpha.

    Texels outside the disc of a round map hold the map's continuation where it has one.
    """

    parameterization: Parameterization
    texels: Float[np.ndarray, "faces rows columns channels"]

    def __post_init__(self) -> None:
        if self.texels.shape[:3] != self.parameterization.shape(self.size):
            raise ValueError(
                f"a {self.parameterization} map of {self.size} rows is "
                f"{self.parameterization.shape(self.size)}, not {self.texels.shape[:3]}"
            )

    @property
    def size(self) -> int:
        """Rows of a face."""
        return self.texels.shape[1]
