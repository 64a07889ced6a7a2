"""The environment map: geometry × parameterization × texels."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from reflet.envmap.env_image import EnvImage
from reflet.envmap.geometry import Geometry
from reflet.envmap.mip_chain import MipChain
from reflet.errors import RefletError


@dataclass(frozen=True)
class EnvMap:
    """One map with all its mip levels, and the geometry that lookups meet.

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
        """View of one mip level as (faces, rows, columns, channels)."""
        return self.chain.level(self.texels, mip_level)

    @property
    def images(self) -> tuple[EnvImage, ...]:
        """All mip levels, finest first, without the geometry."""
        kind = self.chain.parameterization
        return tuple(EnvImage(kind, self.level(number)) for number in range(self.chain.level_count))


def env_map_of(levels: Sequence[EnvImage], geometry: Geometry) -> EnvMap:
    """The map of all these mip levels, finest first, as of `mip_images`. Raises RefletError where they are not all."""
    chain = MipChain(levels[0].size, levels[0].parameterization)
    came = [level.texels.shape[:3] for level in levels]
    if came != [chain.level_shape(number) for number in range(chain.level_count)]:
        raise RefletError(
            f"An env map has all mip levels of {chain.size} rows down to 1; levels of "
            f"{', '.join(str(level.size) for level in levels)} rows came. mip_images makes them from the first."
        )
    channels = levels[0].texels.shape[-1]
    return EnvMap(chain, np.concatenate([level.texels.reshape(-1, channels) for level in levels]), geometry)
