"""The environment map: geometry × parameterization × texels."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from reflet.envmap.geometry import Geometry
from reflet.envmap.mip_chain import MipChain


@dataclass(frozen=True)
class EnvMap:
    """One cube map with all its mip levels, and the geometry that lookups meet.

    ``texels`` are linear radiance: 3 channels, or 4 for a local layer (radiance premultiplied by alpha, alpha in
    [0, 1]). The levels need not be filtered copies of each other.
    """

    chain: MipChain
    texels: Float[np.ndarray, "texels channels"]
    geometry: Geometry

    def __post_init__(self) -> None:
        if self.texels.shape[0] != self.chain.texel_count:
            raise ValueError(f"{self.chain.texel_count} texels expected, {self.texels.shape[0]} came")

    def level(self, mip_level: int) -> np.ndarray:
        """View of one mip level as (6, size, size, channels)."""
        return self.chain.level(self.texels, mip_level)
