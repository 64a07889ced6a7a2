"""Names and versions of everything in a PEM's folder; FORMAT.md describes them."""

import re
from typing import Literal, get_args

EXTENSION = "REFLET_parameterized_environment_map"
VERSION = 3

SCENE = "scene.gltf"  # written last: a folder without it is an unfinished bake
SCENE_BUFFER = "scene.bin"
SURFACE_BUFFER = "surface.bin"  # irradiance and hull flags
BVH_BUFFER = "bvh.bin"  # the tree that mirrored rays are traced by
ENVIRONMENT_BUFFER = "environment.bin"  # as it is
CODED_ENVIRONMENT = "environment.avif"
PARAMETERS = "bake.json"
STATE = "work"  # intermediate results of an unfinished bake
SAMPLE = "sample.json"  # beside the maps of a sample, written after them: its statistics

Codec = Literal["av1", "none"]  # of maps and environment
CODECS: tuple[Codec, ...] = get_args(Codec)
SUFFIXES: dict[Codec, str] = {"av1": ".avif", "none": ".ktx2"}  # of map files


def sample_folder(sample: int) -> str:
    """Folder of one sample's maps."""
    return f"maps/{sample:04d}"


def map_file(sample: int, layer: int, name: str, codec: Codec) -> str:
    """File of one layer at one sample; the layer's number keeps names apart that differ only in what URLs forbid."""
    return f"{sample_folder(sample)}/{layer}-{slug(name)}{SUFFIXES[codec]}"


def base_file(layer: int, name: str, codec: Codec) -> str:
    """File of one distant layer's base map."""
    return f"maps/base/{layer}-{slug(name)}{SUFFIXES[codec]}"


def slug(name: str) -> str:
    """A name with nothing in it that a URL or a file system could mind."""
    return re.sub(r"[^A-Za-z0-9._-]+", "-", name).strip("-.") or "unnamed"
