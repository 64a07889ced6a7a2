"""What the files of a PEM's folder take."""

from dataclasses import dataclass
from pathlib import Path

from reflet.pem import layout

_KINDS = {
    layout.SCENE: "description",
    layout.SCENE_BUFFER: "meshes",
    layout.SURFACE_BUFFER: "diffuse light, reliefs",
    layout.BVH_BUFFER: "tree of the mirrors",
    layout.ENVIRONMENT_BUFFER: "environment",
    layout.CODED_ENVIRONMENT: "environment",
    layout.PARAMETERS: "description",
    "textures": "textures",
}


@dataclass(frozen=True)
class FolderFacts:
    """How the maps of a PEM are coded, if at all, and the bytes of its files, by kind, most first."""

    codec: str
    sizes: dict[str, int]


def folder_facts(folder: Path) -> FolderFacts:
    """The facts of a PEM's folder, which `open_pem` opens; files of others count as such."""
    sizes: dict[str, int] = {}
    codecs = set()
    for path in folder.rglob("*"):
        if not path.is_file():
            continue
        first, *inside = path.relative_to(folder).parts
        if first == "maps":
            kind = "maps for every viewpoint" if inside[0] == "base" else "maps of viewpoints"
            codecs |= {codec for codec, suffix in layout.SUFFIXES.items() if path.suffix == suffix}
        else:
            kind = _KINDS.get(first, "other")
        sizes[kind] = sizes.get(kind, 0) + path.stat().st_size
    return FolderFacts(" and ".join(sorted(codecs)), dict(sorted(sizes.items(), key=lambda item: -item[1])))
