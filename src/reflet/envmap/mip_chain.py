"""The order of all texels of a cube map and its mip levels in one flat vector: the vector x of inference."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Shaped

from reflet.errors import RefletError


@dataclass(frozen=True)
class CubeMipChain:
    """A cube of ``size``² texels a face with every mip level down to 1².

    ``size`` is a power of two from 1 to 8192. Texels are ordered by mip level (finest first), face, row, column.
    """

    size: int

    def __post_init__(self) -> None:
        if not 1 <= self.size <= 8192 or self.size & (self.size - 1):
            raise RefletError(f"A map size must be a power of two from 1 to 8192, not {self.size}.")

    @property
    def level_count(self) -> int:
        """Number of mip levels, log2(size) + 1."""
        return self.size.bit_length()

    @cached_property
    def level_sizes(self) -> tuple[int, ...]:
        """Texels along a face's edge at each mip level."""
        return tuple(self.size >> level for level in range(self.level_count))

    @cached_property
    def offsets(self) -> tuple[int, ...]:
        """Index of the first texel of each mip level, and at the end the number of all texels."""
        return tuple(np.cumsum([0] + [6 * size * size for size in self.level_sizes]).tolist())

    @property
    def texel_count(self) -> int:
        """Number of texels in all levels, 6·(4·size² - 1)/3."""
        return self.offsets[-1]

    def level(self, texels: Shaped[np.ndarray, "texels *channels"], mip_level: int) -> np.ndarray:
        """View of one mip level as (6, size, size, *channels); writing to it writes to ``texels``."""
        size = self.level_sizes[mip_level]
        return texels[self.offsets[mip_level] : self.offsets[mip_level + 1]].reshape(6, size, size, *texels.shape[1:])
