"""Where the texels of a map lie in a picture.

All faces and mip levels of an env map lie side by side. A level's faces stand in a grid: those of a cube in two rows of
three (px nx py, ny pz nz), others in one row. Level 0 is at the top left; the others stand to its right, one below the
other, finest first, aligned left. The picture is as high as level 0, and half as wide again, rounded down. What no
level covers is anything: here the mean of what levels cover, which spreads no error over an edge.
"""

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from jaxtyping import UInt8

from reflet.envmap.mip_chain import MipChain

Texels = UInt8[np.ndarray, "planes texels"]
Pictures = UInt8[np.ndarray, "planes rows columns"]


class Layout(ABC):
    """An order of texels, and their places in a picture."""

    @property
    @abstractmethod
    def shape(self) -> tuple[int, int]:
        """Rows and columns of the picture."""

    @abstractmethod
    def lay_out(self, texels: Texels) -> Pictures:
        """A picture of each plane of values."""

    @abstractmethod
    def gather(self, pictures: Pictures) -> Texels:
        """The texels of all planes in their order."""


@dataclass(frozen=True)
class Raster(Layout):
    """A plain picture, row by row."""

    rows: int
    columns: int

    @property
    def shape(self) -> tuple[int, int]:
        return self.rows, self.columns

    def lay_out(self, texels: Texels) -> Pictures:
        return texels.reshape(-1, self.rows, self.columns)

    def gather(self, pictures: Pictures) -> Texels:
        return pictures.reshape(len(pictures), -1)


@dataclass(frozen=True)
class Atlas(Layout):
    """A map with all its mip levels, in the order of `MipChain`."""

    chain: MipChain

    @property
    def grid(self) -> tuple[int, int]:
        """Rows and columns of faces."""
        faces = self.chain.parameterization.face_count
        return (2, 3) if faces == 6 else (1, faces)

    @property
    def shape(self) -> tuple[int, int]:
        (down, across), (_, rows, columns) = self.grid, self.chain.level_shape(0)
        return down * rows, across * columns + across * columns // 2

    def lay_out(self, texels: Texels) -> Pictures:
        pictures = np.empty((len(texels), *self.shape), np.uint8)
        pictures[:] = np.rint(texels.mean(1))[:, None, None]
        for level, (picture, (rows, columns)) in enumerate(self._places(pictures)):
            values = texels[:, self.chain.offsets[level] : self.chain.offsets[level + 1]]
            faces = values.reshape(-1, *self.grid, rows, columns)
            picture[:] = faces.transpose(0, 1, 3, 2, 4).reshape(picture.shape)
        return pictures

    def gather(self, pictures: Pictures) -> Texels:
        down, across = self.grid
        levels = [
            picture.reshape(-1, down, rows, across, columns).transpose(0, 1, 3, 2, 4).reshape(len(pictures), -1)
            for picture, (rows, columns) in self._places(pictures)
        ]
        return np.concatenate(levels, axis=1)

    def _places(self, pictures: Pictures) -> Iterator[tuple[Pictures, tuple[int, int]]]:
        """Each level's rectangle of the pictures, a view; rows and columns of its faces."""
        down, across = self.grid
        top, left = 0, 0
        for level in range(self.chain.level_count):
            _, rows, columns = self.chain.level_shape(level)
            yield pictures[:, top : top + down * rows, left : left + across * columns], (rows, columns)
            top, left = (0, across * columns) if level == 0 else (top + down * rows, left)
