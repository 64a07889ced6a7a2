"""Texture statements of a .mtl file: their options, and the pictures that they name."""

import re
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

import numpy as np
from jaxtyping import UInt8

from reflet.files.pictures.png import read_picture, shown_alike
from reflet.scene.material import CLAMPS, REPEATS, Texture, Wrap
from reflet.scene.readers.resources import find_resource

_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?")
_NUMBERS = {"-s": 3, "-o": 3, "-t": 3, "-mm": 2, "-bm": 1, "-boost": 1, "-texres": 1}  # at most so many
_WORDS = {"-clamp", "-blendu", "-blendv", "-cc", "-imfchan", "-type", "-colorspace"}


@dataclass(frozen=True)
class TextureStatement:
    """A picture's name and how it is laid on: uv·scale + offset, v upwards. ``channel`` is r, g, b, m, l, z or empty;
    ``odd`` names options that change the picture and are not honoured."""

    name: str
    scale: tuple[float, float] = (1.0, 1.0)
    offset: tuple[float, float] = (0.0, 0.0)
    wraps: tuple[Wrap, Wrap] = REPEATS
    bump: float = 1.0
    channel: str = ""
    odd: tuple[str, ...] = ()


def parse_texture(text: str) -> TextureStatement:
    """Options and name of a statement, without its keyword. The name may hold blanks; options may stand behind it."""
    options: dict[str, list[str]] = {}
    rest = _take_options(text.strip(), options)
    behind = re.search(r"\s(" + "|".join([*_NUMBERS, *_WORDS]) + r")\s", rest)
    if behind and not _take_options(rest[behind.start() :].strip(), options):
        rest = rest[: behind.start()]
    scale, offset = _pair(options.get("-s", []), 1.0), _pair(options.get("-o", []), 0.0)
    base_gain = [float(value) for value in options.get("-mm", [])] or [0.0, 1.0]
    odd = tuple(name for name, applies in (
        ("-mm", base_gain != [0.0, 1.0][: len(base_gain)]),
        ("-t", any(float(value) for value in options.get("-t", []))),
        ("-type", options.get("-type", [""])[0].lower() in ("sphere", "cube_top")),
    ) if applies)  # fmt: skip
    return TextureStatement(
        name=rest.strip(),
        scale=scale,
        offset=offset,
        wraps=CLAMPS if options.get("-clamp", [""])[0].lower() == "on" else REPEATS,
        bump=float(options.get("-bm", ["1"])[0]),
        channel=options.get("-imfchan", [""])[0].lower(),
        odd=odd,
    )


def _take_options(text: str, options: dict[str, list[str]]) -> str:
    """Moves the options that a text begins with into ``options``; what is left is a name."""
    while True:
        words = text.split(None, 1)
        option = words[0].lower() if len(words) == 2 else ""
        if option not in _NUMBERS and option not in _WORDS:
            return text
        text, values = words[1], []
        for _ in range(_NUMBERS.get(option, 1)):
            word = (text.split(None, 1) or [""])[0]
            if option in _NUMBERS and not _NUMBER.fullmatch(word):
                break
            values.append(word)
            text = text[len(word) :].strip()
        if values:
            options[option] = values


def _pair(values: list[str], default: float) -> tuple[float, float]:
    u, v = (*(float(value) for value in values[:2]), *(default, default)[len(values) :])
    return u, v


class Pictures:
    """Pictures that the materials of one folder name, each read once."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._read = lru_cache(maxsize=None)(_texture)

    def pixels(self, statement: TextureStatement) -> UInt8[np.ndarray, "height width 4"]:
        """RGBA pixels. Raises RefletError, in one sentence, where the picture is missing or cannot be read."""
        return self.texture(statement).pixels

    def texture(self, statement: TextureStatement) -> Texture:
        """The picture as it is. Raises RefletError as `pixels` does."""
        return replace(self._read(find_resource(self.folder, statement.name)), wraps=statement.wraps)


def _texture(path: Path) -> Texture:
    pixels, data = read_picture(path), path.read_bytes()
    return Texture(pixels, encoded=data if shown_alike(data) else None)


def channel_of(pixels: UInt8[np.ndarray, "height width 4"], channel: str) -> UInt8[np.ndarray, "height width"]:
    """One number a pixel: r, g, b, m (alpha), or the luminance."""
    if channel in ("r", "g", "b", "m"):
        return pixels[..., "rgbm".index(channel)]
    # weights of Rec. 709; of grey pictures they keep every value
    return np.rint(pixels[..., :3] @ np.array([0.2126, 0.7152, 0.0722])).astype(np.uint8)


def is_grey(pixels: UInt8[np.ndarray, "height width 4"]) -> bool:
    """Whether red, green and blue are equal everywhere."""
    return bool((pixels[..., :1] == pixels[..., 1:3]).all())


def is_normal_map(pixels: UInt8[np.ndarray, "height width 4"]) -> bool:
    """Whether nearly all texels are unit vectors away from the surface: no picture of heights is like that."""
    few = pixels[:: max(1, len(pixels) // 64), :: max(1, pixels.shape[1] // 64), :3]
    vectors = few / 127.5 - 1.0
    unit = (np.abs(np.linalg.norm(vectors, axis=-1) - 1.0) < 0.1) & (vectors[..., 2] > 0.0)
    return not is_grey(pixels) and bool(unit.mean() > 0.9)
