"""How texels are stored in KTX and DDS files, and what they mean: linear radiance in float32."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float32, UInt8

from reflet.envmap.resampling.spread_light import HALF_MAX
from reflet.files.srgb import linear_from_srgb
from reflet.files.textures.packed_floats import decode_r11g11b10, decode_rgb9e5, encode_r11g11b10, encode_rgb9e5

FLOAT_MAX = float(np.finfo(np.float32).max)

Stored = UInt8[np.ndarray, "images bytes"]
Texels = Float32[np.ndarray, "images rows columns channels"]


@dataclass(frozen=True)
class TexelFormat:
    """One way of storing texels. ``encode`` is None where reflet only reads it."""

    name: str
    channels: int
    block_bytes: int  # of a texel, or of a block of ``block_side``² texels
    word_bytes: int  # of the numbers that a change of byte order turns around; 1 where there is none
    _decode: Callable[[np.ndarray, int, int], np.ndarray]
    _encode: Callable[[np.ndarray], np.ndarray] | None = None
    block_side: int = 1

    def image_bytes(self, rows: int, columns: int) -> int:
        """Size of a picture without padding."""
        return -(-rows // self.block_side) * self.row_bytes(columns)

    def row_bytes(self, columns: int) -> int:
        """Size of a row of blocks."""
        return -(-columns // self.block_side) * self.block_bytes

    @property
    def is_writable(self) -> bool:
        """Whether there is an encoder."""
        return self._encode is not None

    @property
    def most(self) -> float:
        """The greatest radiance of formats whose numbers end at 1, or infinity."""
        name = self.name.removesuffix("_srgb")
        return 1.0 if name.endswith(("8", "16")) or name in ("bc1", "bc2", "bc3", "bc7") else math.inf

    def decode(self, stored: Stored, rows: int, columns: int) -> Texels:
        """Texels of pictures of ``image_bytes(rows, columns)`` each."""
        texels = self._decode(np.ascontiguousarray(stored), rows, columns)
        return texels.reshape(len(stored), rows, columns, self.channels)

    def encode(self, texels: Texels) -> Stored:
        """The nearest that can be stored; what is beyond the format's range is clamped to it.

        Raises ValueError for formats that are only read; texels are numbers of ``channels`` channels.
        """
        if self._encode is None:
            raise ValueError(f"{self.name} is only read")
        stored = self._encode(np.ascontiguousarray(texels, dtype=np.float32))
        return stored.reshape(len(texels), -1).view(np.uint8)


def _floats(name: str, dtype: str, largest: float) -> tuple[TexelFormat, ...]:
    def decode(stored: np.ndarray, rows: int, columns: int) -> np.ndarray:
        return stored.view(dtype).astype(np.float32)

    def encode(texels: np.ndarray) -> np.ndarray:
        return np.clip(texels, -largest, largest).astype(dtype)

    width = np.dtype(dtype).itemsize
    return tuple(
        TexelFormat(f"{channels}{name}", len(channels), width * len(channels), width, decode, encode)
        for channels in ("r", "rgb", "rgba")
    )


def _packed(
    name: str, decode: Callable[[np.ndarray], np.ndarray], encode: Callable[[np.ndarray], np.ndarray]
) -> TexelFormat:
    return TexelFormat(
        name,
        3,
        4,
        4,
        lambda stored, rows, columns: decode(stored.view("<u4").ravel()),
        lambda texels: encode(texels.reshape(-1, 3)).astype("<u4", copy=False),
    )


def _linear_from_srgb() -> np.ndarray:
    linear = linear_from_srgb(np.arange(256) / 255.0).astype(np.float32)
    linear.setflags(write=False)
    return linear


LINEAR_FROM_SRGB = _linear_from_srgb()
"""Linear value of each 8-bit sRGB code, 255 being 1."""


def _from_bytes(values: np.ndarray, *, srgb: bool) -> np.ndarray:
    """Components of 8 bits as numbers from 0 to 1; alpha, the fourth, is never sRGB-encoded."""
    if not srgb:
        return values * np.float32(1.0 / 255.0)
    texels = LINEAR_FROM_SRGB[values]
    if values.shape[-1] == 4:
        texels[..., 3] = values[..., 3] * np.float32(1.0 / 255.0)
    return texels


def _eight_bit(name: str) -> tuple[TexelFormat, ...]:
    """With and without sRGB; ``name`` lists the channels in memory, x for one that means nothing."""
    order = [name.index(channel) for channel in ("r", "g", "b", "a") if channel in name]

    def decoder(srgb: bool) -> Callable[[np.ndarray, int, int], np.ndarray]:
        return lambda stored, rows, columns: _from_bytes(stored.reshape(-1, len(name))[:, order], srgb=srgb)

    return tuple(
        TexelFormat(f"{name}8{'_srgb' if srgb else ''}", len(order), len(name), 1, decoder(srgb))
        for srgb in (False, True)
    )


def _sixteen_bit(name: str) -> TexelFormat:
    """Components of 16 bits as numbers from 0 to 1, linear as graphics systems have them."""
    return TexelFormat(
        f"{name}16",
        len(name),
        2 * len(name),
        2,
        lambda stored, rows, columns: stored.view("<u2") * np.float32(1.0 / 65535.0),
    )


def _blocks(name: str, code: int, block_bytes: int) -> tuple[TexelFormat, ...]:
    """Blocks of 4×4 texels; ``code`` is the decoder library's."""
    is_float = abs(code) == 6
    channels = 3 if is_float else 4

    def decoder(srgb: bool) -> Callable[[np.ndarray, int, int], np.ndarray]:
        def decode(stored: np.ndarray, rows: int, columns: int) -> np.ndarray:
            import imagecodecs  # takes a while to import, and few maps need it

            whole = (-(-rows // 4) * 4, -(-columns // 4) * 4, channels)
            out = np.empty((len(stored), rows, columns, channels), np.float32)
            for image, data in zip(out, stored, strict=True):
                texels = np.asarray(imagecodecs.bcn_decode(data, code, shape=whole))[:rows, :columns]
                image[...] = texels if is_float else _from_bytes(texels, srgb=srgb)
            return out

        return decode

    return tuple(
        TexelFormat(f"{name}{'_srgb' if srgb else ''}", channels, block_bytes, 1, decoder(srgb), None, 4)
        for srgb in ((False,) if is_float else (False, True))
    )


_ALL = (
    *_floats("16f", "<f2", HALF_MAX),
    *_floats("32f", "<f4", FLOAT_MAX),
    _packed("rgb9e5", decode_rgb9e5, encode_rgb9e5),
    _packed("r11g11b10f", decode_r11g11b10, encode_r11g11b10),
    *(form for name in ("r", "rgb", "bgr", "rgba", "bgra", "bgrx", "rgbx") for form in _eight_bit(name)),
    *(_sixteen_bit(name) for name in ("r", "rgb", "rgba")),
    *_blocks("bc1", 1, 8),
    *_blocks("bc2", 2, 16),
    *_blocks("bc3", 3, 16),
    *_blocks("bc6h", 6, 16),
    *_blocks("bc6h_signed", -6, 16),
    *_blocks("bc7", 7, 16),
)

TEXEL_FORMATS: dict[str, TexelFormat] = {form.name: form for form in _ALL}
"""All formats by name: channels, bits and kind of number, in WebGPU's manner."""
