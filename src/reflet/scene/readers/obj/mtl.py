"""Materials of Wavefront .mtl files."""

import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from reflet.errors import RefletWarning
from reflet.scene.material import Material, Texture
from reflet.scene.readers.obj.mtl_lines import MtlLine, read_mtl_lines
from reflet.scene.readers.obj.mtl_reflection import coat_fields, surface_fields, with_transparency
from reflet.scene.readers.obj.mtl_textures import Pictures, is_normal_map
from reflet.scene.readers.obj.mtl_values import WHITE, MtlValues
from reflet.scene.readers.obj.plain_text import bare_name, listed, quoted

_BLACK = (0.0, 0.0, 0.0)
_HONOURED = {"kd", "ke", "ks", "ni", "tf", "pm", "pr", "ns", "illum", "d", "tr", "pc", "pcr", "map_kd", "map_ke",
             "map_ks", "norm", "bump", "map_bump", "map_pr", "map_pm", "map_orm", "map_rma", "map_pc", "map_pcr",
             "map_d", "map_tr"}  # fmt: skip
_HARMLESS = {"ka", "km", "sharpness", "map_ka", "map_aat", "map_ao"}  # these change nothing in the picture
_AMOUNTS = ("ps", "aniso", "anisor")  # these do nothing where they are 0
_CONSEQUENCES = {
    ("map_ns",): "map_Ns is left out, for tools disagree on what it holds; give the roughness by map_Pr",
    ("disp", "map_disp", "decal"): "displacement and decals are left out",
    ("refl", "map_refl"): "reflection maps are left out",
    ("ps", "map_ps"): "sheen is left out",
    ("aniso", "anisor", "map_aniso", "map_anisor"): "anisotropy is left out: highlights are round",
}


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
        self._lines = read_mtl_lines(path, _HONOURED | _HARMLESS | {word for words in _CONSEQUENCES for word in words})
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
        values = MtlValues(lines, self._pictures, lambda phrase: self._note(phrase, name))
        for words, consequence in _CONSEQUENCES.items():
            if any(word in lines and (word not in _AMOUNTS or values.number(word) != 0.0) for word in words):
                values.note(consequence)
        base, glow = values.texture("map_kd"), values.texture("map_ke")
        normal, normal_scale = _normal_map(values)
        material = Material(
            name=name,
            base_color=values.factor(values.color("kd", 1.0), WHITE, base is not None),
            emission=values.factor(values.color("ke", np.inf), _BLACK if glow is None else WHITE, glow is not None),
            base_color_texture_srgb=base,
            normal_texture=normal,
            normal_scale=normal_scale,
            emission_texture_srgb=glow,
            **surface_fields(values),
            **coat_fields(values),
        )
        material = with_transparency(material, values)
        placed = values.placed
        if len({(texture.scale, texture.offset) for texture in placed}) > 1:
            values.note("textures of a material are placed differently, and all are placed like its first")
        for option in sorted({option for texture in placed for option in texture.odd}):
            values.note(f"the textures' option {option} is left out")
        return PlacedMaterial(material, placed[0].scale, placed[0].offset) if placed else PlacedMaterial(material)


def _normal_map(values: MtlValues) -> tuple[Texture | None, float]:
    """The normal map and its scale. Many exporters call it map_Bump, which is for heights; its texels tell."""
    for word in ("norm", "map_bump", "bump"):
        found = values.picture(word)
        if found is not None and (word == "norm" or is_normal_map(found[0])):
            values.placed.append(found[1])
            return values.pictures.texture(found[1]), found[1].bump
        if found is not None:
            values.note("bump maps of heights are left out; give a normal map by norm")
    return None, 1.0
