"""What the lines of one material of a .mtl file hold: numbers, colours and pictures."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np
from jaxtyping import UInt8

from reflet.errors import RefletError
from reflet.scene.material import Texture, Vec3
from reflet.scene.readers.obj.mtl_lines import MtlLine
from reflet.scene.readers.obj.mtl_textures import Pictures, TextureStatement, channel_of, parse_texture

WHITE = (1.0, 1.0, 1.0)
_Factor = TypeVar("_Factor", float, Vec3)
Plane = UInt8[np.ndarray, "height width"]


@dataclass(frozen=True)
class MtlValues:
    """One material's ``lines`` by keyword. What is put right is told to ``note``; textures that were taken are in
    ``placed``, in their order."""

    lines: dict[str, MtlLine]
    pictures: Pictures
    note: Callable[[str], None]
    placed: list[TextureStatement] = field(default_factory=list)

    def has(self, *words: str) -> bool:
        """Whether there is a line of any of these keywords."""
        return any(word in self.lines for word in words)

    def number(self, word: str) -> float | None:
        """None where there is none."""
        return self.lines[word].numbers()[0] if word in self.lines else None

    def share(self, word: str) -> float | None:
        """A number from 0 to 1, None where there is none."""
        value = self.number(word)
        if value is None:
            return None
        if not 0.0 <= value <= 1.0:
            self.note(f"{word.capitalize()} beyond 0 to 1 is taken as the nearer of them")
        return min(max(value, 0.0), 1.0)

    def color(self, word: str, highest: float) -> Vec3 | None:
        """A linear colour from 0 to ``highest``, None where there is none."""
        if word not in self.lines:
            return None
        if self.lines[word].value.lower().startswith(("spectral", "xyz")):
            self.note("colours given as spectra or as XYZ are left out")
            return None
        values = self.lines[word].numbers()
        values = values * 3 if len(values) == 1 else [*values, values[-1]][:3]
        if min(values) < 0.0 or max(values) > highest:
            self.note(f"{word.capitalize()} below 0 or above {highest:g} is taken as the nearer of them")
        r, g, b = (min(max(value, 0.0), highest) for value in values)
        return r, g, b

    def factor(self, given: _Factor | None, default: _Factor, textured: bool) -> _Factor:
        """What multiplies a texture. Exporters that write a texture often write 0 beside it, which would hide it."""
        if given is None:
            return default
        if textured and not np.any(given):
            self.note("factors of 0 would hide their textures and are taken as 1")
            return WHITE if isinstance(default, tuple) else 1.0  # type: ignore[return-value]
        return given

    def picture(self, word: str) -> tuple[UInt8[np.ndarray, "height width 4"], TextureStatement] | None:
        """A line's picture and how it is laid on; None where there is none or it cannot be read."""
        if word not in self.lines:
            return None
        statement = parse_texture(self.lines[word].value)
        try:
            return self.pictures.pixels(statement), statement
        except RefletError as error:
            self.note(f"{str(error).rstrip('.')}; until then shown without it")
            return None

    def texture(self, word: str) -> Texture | None:
        """A line's picture as it is."""
        found = self.picture(word)
        if found is None:
            return None
        self.placed.append(found[1])
        return self.pictures.texture(found[1])

    def plane(self, channels: dict[str, str]) -> Plane | None:
        """One channel of the first picture there is, by its keyword: the one that the line names, else this one."""
        for word, channel in channels.items():
            found = self.picture(word)
            if found is not None:
                self.placed.append(found[1])
                return channel_of(found[0], found[1].channel or channel)
        return None
