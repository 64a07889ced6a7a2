"""The order of all texels of a map and its mip levels in one flat vector: the vector x of inference."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Shaped

from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.parameterizations.parameterization import Parameterization
from reflet.errors import RefletError


@dataclass(frozen=True)
class MipChain:
    """A map whose faces have ``size`` rows, with every mip level down to one row.

    ``size`` is a power of two from 1 to 8192. Texels are ordered by mip level (finest first), face, row, column.
    """

    size: int
    parameterization: Parameterization = CUBE

    def __post_init__(self) -> None:
        if not 1 <= self.size <= 8192 or self.size & (self.size - 1):
            raise RefletError(f"A map size must be a power of two from 1 to 8192, not {self.size}.")

    @property
    def level_count(self) -> int:
        """Number of mip levels, log2(size) + 1."""
        return self.size.bit_length()

    @cached_property
    def level_sizes(self) -> tuple[int, ...]:
        """Rows of a face at each mip level."""
        return tuple(self.size >> level for level in range(self.level_count))

    @cached_property
    def offsets(self) -> tuple[int, ...]:
        """Index of the first texel of each mip level, and at the end the number of all texels."""
        return tuple(np.cumsum([0] + [int(np.prod(self.level_shape(k))) for k in range(self.level_count)]).tolist())

    @property
    def texel_count(self) -> int:
        """Number of texels in all levels: faces·aspect·(4·size² - 1)/3."""
        return self.offsets[-1]

    def level_shape(self, mip_level: int) -> tuple[int, int, int]:
        """(faces, rows, columns) of one mip level."""
        return self.parameterization.shape(self.size >> mip_level)

    def level(self, texels: Shaped[np.ndarray, "texels *channels"], mip_level: int) -> np.ndarray:
        """View of one mip level as (faces, rows, columns, *channels); writing to it writes to ``texels``."""
        flat = texels[self.offsets[mip_level] : self.offsets[mip_level + 1]]
        return flat.reshape(*self.level_shape(mip_level), *texels.shape[1:])
