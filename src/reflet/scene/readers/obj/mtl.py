"""Materials of Wavefront .mtl files."""

import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

import numpy as np
from jaxtyping import UInt8

from reflet.errors import RefletError, RefletWarning
from reflet.scene.material import Material, Texture, Vec3
from reflet.scene.readers.obj.mtl_lines import MtlLine, read_mtl_lines
from reflet.scene.readers.obj.mtl_textures import (
    Pictures,
    TextureStatement,
    channel_of,
    is_normal_map,
    parse_texture,
    roughness_and_metal,
)
from reflet.scene.readers.obj.plain_text import bare_name, listed, quoted

_WHITE, _BLACK = (1.0, 1.0, 1.0), (0.0, 0.0, 0.0)
_HONOURED = {"kd", "ke", "pm", "pr", "ns", "illum", "d", "tr", "map_kd", "map_ke", "norm", "bump", "map_bump",
             "map_pr", "map_pm", "map_orm", "map_rma"}  # fmt: skip
# these change nothing in the picture of a mirror, or of a diffuse surface
_HARMLESS = {"ka", "ks", "km", "ni", "tf", "sharpness", "map_ka", "map_ks", "map_ns", "map_aat", "map_ao"}
_AMOUNTS = ("pc", "pcr", "ps", "aniso", "anisor")  # these do nothing where they are 0
_CONSEQUENCES = (
    dict.fromkeys(("map_d", "map_tr"), "transparent texels are shown opaque")
    | dict.fromkeys(("disp", "map_disp", "decal"), "displacement and decals are left out")
    | dict.fromkeys(("refl", "map_refl"), "reflection maps are left out")
    | dict.fromkeys((*_AMOUNTS, "map_pc", "map_pcr", "map_ps"), "coats, sheen and anisotropy are left out")
)
_Factor = TypeVar("_Factor", float, Vec3)


@dataclass(frozen=True)
class PlacedMaterial:
    """A material and where its textures lie: uv·scale + offset, v running upwards."""

    material: Material
    scale: tuple[float, float] = (1.0, 1.0)
    offset: tuple[float, float] = (0.0, 0.0)


class MaterialFile:
    """The materials of one .mtl file. What is not honoured of those that were asked for is said by `warn`."""

    def __init__(self, path: Path) -> None:
        """Raises RefletError where the file cannot be read."""
        self.path = path
        self._lines = read_mtl_lines(path, _HONOURED | _HARMLESS | set(_CONSEQUENCES))
        self._bare = {bare_name(name): name for name in reversed(self._lines.materials)}
        self._pictures = Pictures(path.parent)
        self._materials: dict[str, PlacedMaterial] = {}
        self._notes: dict[str, list[str]] = {}

    def find(self, name: str) -> str | None:
        """The name here of the material that a usemtl line means: either may have a comment behind it."""
        if name in self._lines.materials:
            return name
        return self._bare.get(bare_name(name))

    def material(self, name: str) -> PlacedMaterial:
        """The material of a name that `find` gave. A .mtl's colours are taken as linear, as most exporters write them.

        Textures that cannot be read are left out, and their factors stay. Raises RefletError, naming the line, where a
        number cannot be read.
        """
        if name not in self._materials:
            self._materials[name] = self._build(name, self._lines.materials[name])
            if name in self._lines.doubled:
                self._note("of several materials of one name the last one counts", name)
        return self._materials[name]

    def warn(self) -> None:
        """Gives a RefletWarning for each thing that is not honoured, naming the materials."""
        stray = self._lines.stray
        if stray:
            first = f"the first is line {stray[0].number}, {quoted(stray[0].text)}"
            self._notes[f"{len(stray)} lines of unknown kind are left out"] = [first]
        for phrase, names in self._notes.items():
            warnings.warn(f"{self.path.name}: {phrase} ({listed(names)}).", RefletWarning, stacklevel=4)

    def _note(self, phrase: str, name: str) -> None:
        names = self._notes.setdefault(phrase, [])
        if name not in names:
            names.append(name)

    def _build(self, name: str, lines: dict[str, MtlLine]) -> PlacedMaterial:
        self._note_left_out(name, lines)
        placed: list[TextureStatement] = []
        base, glow = self._texture(name, lines, "map_kd", placed), self._texture(name, lines, "map_ke", placed)
        normal, normal_scale = self._normal_map(name, lines, placed)
        packed, has_roughness, has_metal = self._roughness_and_metal(name, lines, placed)
        roughness = self._number(name, lines, "pr")
        if roughness is None and "ns" in lines and not has_roughness:
            # the lobe of a Phong exponent N has alpha² = 2/(N + 2), and alpha is the square of what artists set
            roughness = (2.0 / (max(lines["ns"].numbers()[0], 0.0) + 2.0)) ** 0.25
        metallic = self._number(name, lines, "pm")
        material = Material(
            name=name,
            base_color=self._factor(name, self._color(name, lines, "kd", 1.0), _WHITE, base is not None),
            metallic=self._factor(name, metallic, float(has_metal), has_metal),
            perceptual_roughness=self._factor(name, roughness, 1.0, has_roughness),
            emission=self._factor(
                name, self._color(name, lines, "ke", np.inf), _BLACK if glow is None else _WHITE, glow is not None
            ),
            base_color_texture_srgb=base,
            metallic_roughness_texture=packed,
            normal_texture=normal,
            normal_scale=normal_scale,
            emission_texture_srgb=glow,
        )
        if len({(texture.scale, texture.offset) for texture in placed}) > 1:
            self._note("textures of a material are placed differently, and all are placed like its first", name)
        for option in sorted({option for texture in placed for option in texture.odd}):
            self._note(f"the textures' option {option} is left out", name)
        return PlacedMaterial(material, placed[0].scale, placed[0].offset) if placed else PlacedMaterial(material)

    # -- factors -------------------------------------------------------------------------------------------------------

    def _number(self, name: str, lines: dict[str, MtlLine], word: str) -> float | None:
        """A share from 0 to 1, None where there is none."""
        if word not in lines:
            return None
        value = lines[word].numbers()[0]
        if not 0.0 <= value <= 1.0:
            self._note(f"{word.capitalize()} beyond 0 to 1 is taken as the nearer of them", name)
        return min(max(value, 0.0), 1.0)

    def _color(self, name: str, lines: dict[str, MtlLine], word: str, highest: float) -> Vec3 | None:
        if word not in lines:
            return None
        if lines[word].value.lower().startswith(("spectral", "xyz")):
            self._note("colours given as spectra or as XYZ are left out", name)
            return None
        values = lines[word].numbers()
        values = values * 3 if len(values) == 1 else [*values, values[-1]][:3]
        if min(values) < 0.0 or max(values) > highest:
            self._note(f"{word.capitalize()} below 0 or above {highest:g} is taken as the nearer of them", name)
        r, g, b = (min(max(value, 0.0), highest) for value in values)
        return r, g, b

    def _factor(self, name: str, given: _Factor | None, default: _Factor, textured: bool) -> _Factor:
        """What multiplies a texture. Exporters that write a texture often write 0 beside it, which would hide it."""
        if given is None:
            return default
        if textured and not np.any(given):
            self._note("factors of 0 would hide their textures and are taken as 1", name)
            return _WHITE if isinstance(default, tuple) else 1.0  # type: ignore[return-value]
        return given

    def _note_left_out(self, name: str, lines: dict[str, MtlLine]) -> None:
        for word, consequence in _CONSEQUENCES.items():
            if word in lines and (word not in _AMOUNTS or lines[word].numbers()[0] != 0.0):
                self._note(consequence, name)
        opacity = self._number(name, lines, "d")
        if opacity is None and "tr" in lines:
            opacity = 1.0 - lines["tr"].numbers()[0]
        if opacity is not None and opacity < 1.0:
            self._note("transparent surfaces are shown opaque", name)
        metallic = "pm" in lines or "map_pm" in lines or "map_orm" in lines or "map_rma" in lines
        if "illum" in lines and not metallic and lines["illum"].numbers()[0] >= 3.0:
            self._note("illum 3 to 9 is left out; to have mirrors, give Pm 1 and Pr 0, or choose with --reflect", name)

    # -- textures ------------------------------------------------------------------------------------------------------

    def _picture(
        self, name: str, lines: dict[str, MtlLine], word: str
    ) -> tuple[UInt8[np.ndarray, "height width 4"], TextureStatement] | None:
        if word not in lines:
            return None
        statement = parse_texture(lines[word].value)
        try:
            return self._pictures.pixels(statement), statement
        except RefletError as error:
            self._note(f"{str(error).rstrip('.')}; until then shown without it", name)
            return None

    def _texture(
        self, name: str, lines: dict[str, MtlLine], word: str, placed: list[TextureStatement]
    ) -> Texture | None:
        found = self._picture(name, lines, word)
        if found is None:
            return None
        placed.append(found[1])
        return self._pictures.texture(found[1])

    def _normal_map(
        self, name: str, lines: dict[str, MtlLine], placed: list[TextureStatement]
    ) -> tuple[Texture | None, float]:
        """The normal map and its scale. Many exporters call it map_Bump, which is for heights; its texels tell."""
        for word in ("norm", "map_bump", "bump"):
            found = self._picture(name, lines, word)
            if found is not None and (word == "norm" or is_normal_map(found[0])):
                placed.append(found[1])
                return self._pictures.texture(found[1]), found[1].bump
            if found is not None:
                self._note("bump maps of heights are left out; give a normal map by norm", name)
        return None, 1.0

    def _roughness_and_metal(
        self, name: str, lines: dict[str, MtlLine], placed: list[TextureStatement]
    ) -> tuple[Texture | None, bool, bool]:
        """glTF's metallic-roughness texture, and whether it holds a roughness and whether it says what is metallic."""
        both = "map_pr" in lines and "map_pm" in lines
        one = both and parse_texture(lines["map_pr"].value).name == parse_texture(lines["map_pm"].value).name
        roughness = self._plane(name, lines, {"map_pr": "g" if one else "", "map_orm": "g", "map_rma": "r"}, placed)
        metallic = self._plane(name, lines, {"map_pm": "b" if one else "", "map_orm": "b", "map_rma": "g"}, placed)
        if roughness is None and metallic is None:
            return None, False, False
        texture = Texture(roughness_and_metal(roughness, metallic), placed[-1].wraps)
        return texture, roughness is not None, metallic is not None

    def _plane(
        self, name: str, lines: dict[str, MtlLine], channels: dict[str, str], placed: list[TextureStatement]
    ) -> UInt8[np.ndarray, "h w"] | None:
        """One channel of the first picture there is. A coloured one that is roughness and metal is packed as glTF's."""
        for word, channel in channels.items():
            found = self._picture(name, lines, word)
            if found is not None:
                placed.append(found[1])
                return channel_of(found[0], found[1].channel or channel)
        return None
