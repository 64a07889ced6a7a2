"""What KTX and DDS files hold: pictures of one size with mip levels, as they are stored."""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float32, UInt8

from reflet.files.textures.texel_formats import TexelFormat


@dataclass(frozen=True)
class Texture:
    """The pictures are a cube's six faces in the order px nx py ny pz nz, or the layers of a 2D texture.

    ``levels`` hold each picture's bytes without padding, finest first; they may be views of a file on disk.
    ``metadata`` are the container's key-value pairs, values without the NUL at their end; formats that have none leave
    it empty. ``alpha_is_premultiplied`` is False where that is unknown. ``supercompression`` names what wraps the
    levels in the file ("zstd"), or is None. ``doubts`` are sentences about what cannot be meant as it stands in the
    file, and how it was taken.
    """

    texel_format: TexelFormat
    rows: int
    columns: int
    is_cube: bool
    levels: tuple[UInt8[np.ndarray, "images _"], ...]
    metadata: dict[str, bytes] = field(default_factory=dict)
    alpha_is_premultiplied: bool = False
    supercompression: str | None = None
    doubts: tuple[str, ...] = ()

    @property
    def image_count(self) -> int:
        """Faces or layers."""
        return len(self.levels[0])

    def level_shape(self, mip_level: int) -> tuple[int, int]:
        """(rows, columns) of one mip level."""
        return level_shape(self.rows, self.columns, mip_level)

    def decode(self, mip_level: int) -> Float32[np.ndarray, "images rows columns channels"]:
        """Linear radiance of one mip level, row 0 at the top.

        KTXorientation is honoured: "ru" in KTX 2.0, "S=r,T=u" in KTX 1, has row 0 at the bottom. Cubes have but one.
        """
        texels = self.texel_format.decode(self.levels[mip_level], *self.level_shape(mip_level))
        turned = b"" if self.is_cube else self.metadata.get("KTXorientation", b"")
        return texels[:, :: -1 if b"u" in turned else 1, :: -1 if b"l" in turned else 1]


def level_shape(rows: int, columns: int, mip_level: int) -> tuple[int, int]:
    """(rows, columns) of a mip level, halved and rounded down, but never below one."""
    return max(rows >> mip_level, 1), max(columns >> mip_level, 1)


def most_levels(rows: int, columns: int) -> int:
    """The number of mip levels down to one texel."""
    return max(rows, columns).bit_length()
