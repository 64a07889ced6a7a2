"""KTX 2.0 maps in half float with every mip level stored: the files that hold a PEM's maps.

Only what the project writes is read back: uncompressed RGBA of half floats with a full mip chain. A cube is a cube
texture, whose faces lie in the order +X -X +Y -Y +Z -Z, row 0 at the top: the project's own
(`reflet.envmap.parameterizations.cube`), so that nothing is converted. Maps of one face are 2D textures, those of
several are 2D arrays with a layer a face; the key RefletParameterization names what they are, cubes where it is absent.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float, Float16

from reflet.envmap.mip_chain import MipChain
from reflet.envmap.parameterizations.by_name import parameterization
from reflet.envmap.parameterizations.cube import CUBE
from reflet.errors import RefletError
from reflet.files.textures.env_texture import metadata_of
from reflet.files.textures.ktx2_container import read_texture, write_texture
from reflet.files.textures.texel_formats import HALF_MAX, TEXEL_FORMATS
from reflet.files.textures.texture import Texture

_RGBA16F = TEXEL_FORMATS["rgba16f"]


@dataclass(frozen=True)
class Ktx2Map:
    """An opened file. ``levels`` are memory maps, finest first: nothing is read until asked."""

    chain: MipChain
    levels: tuple[Float16[np.ndarray, "_ _ _ 4"], ...]

    def texels(self) -> Float16[np.ndarray, "texels 4"]:
        """All levels as one flat vector in the order of `MipChain`, read from the file."""
        return np.concatenate([level.reshape(-1, 4) for level in self.levels])


def write_ktx2(path: Path, chain: MipChain, texels: Float[np.ndarray, "texels channels"]) -> None:
    """Write a map with all its mip levels, atomically; equal texels give equal bytes.

    ``texels`` have 3 channels (alpha becomes 1) or 4 (premultiplied by alpha, and marked so). Values are clamped to
    ±65504, the range of half floats, and rounded to nearest. Raises RefletError where a texel is not a number or the
    file cannot be written.
    """
    if np.isnan(texels).any():
        raise RefletError(f"The map {path} holds values that are not numbers; nothing was written.")
    half = np.ones((len(texels), 4), "<f2")
    half[:, : texels.shape[1]] = np.clip(texels, -HALF_MAX, HALF_MAX)
    levels = tuple(
        chain.level(half, k).reshape(chain.parameterization.face_count, -1).view(np.uint8)
        for k in range(chain.level_count)
    )
    _, rows, columns = chain.level_shape(0)
    texture = Texture(
        _RGBA16F,
        rows,
        columns,
        chain.parameterization == CUBE,
        levels,
        metadata_of(chain.parameterization),
        alpha_is_premultiplied=texels.shape[1] == 4,
    )
    write_texture(path, texture)


def read_ktx2(path: Path) -> Ktx2Map:
    """Open a map written by `write_ktx2`. Raises RefletError where the file is missing, foreign or truncated."""
    texture = read_texture(path)
    laid_out = parameterization(texture.metadata.get("RefletParameterization", b"cube").decode("utf-8", "replace"))
    if texture.texel_format != _RGBA16F or texture.supercompression is not None:
        raise RefletError(
            f"{path} is not a map of plain half-float RGBA texels, the one KTX 2.0 form of a PEM's maps; copy it "
            "again, or bake again."
        )
    rows, columns = texture.rows, texture.columns
    if texture.is_cube != (laid_out == CUBE) or (texture.image_count, rows, columns) != laid_out.shape(rows):
        raise RefletError(f"{path} is not a {laid_out} map: it has {texture.image_count} pictures of {columns}×{rows}.")
    if rows & (rows - 1) or len(texture.levels) != rows.bit_length():
        raise RefletError(
            f"{path} should hold all mip levels of a {laid_out} map whose size is a power of two, "
            f"not {len(texture.levels)} of {columns}×{rows}."
        )
    chain = MipChain(rows, laid_out)
    levels = tuple(level.view("<f2").reshape(*chain.level_shape(k), 4) for k, level in enumerate(texture.levels))
    return Ktx2Map(chain, levels)
