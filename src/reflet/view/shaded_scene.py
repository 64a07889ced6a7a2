"""A mesh of some material in an environment as files for the web viewer: glTF with an extension that names the maps.

The folder holds ``scene.gltf`` and its buffer, the environment as a cube in half float with all mip levels, the diffuse
map, and ``shading.bin``: the table of the split sum and the lobes that the viewer filters the environment with, on its
own device. Other glTF viewers show the mesh.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from reflet.envmap.env_image import EnvImage
from reflet.envmap.mip_chain import MipChain
from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.resampling.mip_reduction import mip_images
from reflet.envmap.resampling.resample import resample
from reflet.envmap.resampling.spread_light import HALF_MAX, held, spread_light
from reflet.errors import RefletError
from reflet.files.atomic import atomic_write
from reflet.files.textures.ktx2 import write_ktx2
from reflet.pem.arrays import BufferWriter
from reflet.pem.gltf_scene import write_scene
from reflet.pem.layout import SCENE, slug
from reflet.reflectance.lobes.lobe_taps import lobe_taps
from reflet.reflectance.materials.map_material import Lookup
from reflet.reflectance.materials.material import (
    Coated,
    Conductor,
    Dielectric,
    DielectricOverDiffuse,
    GlossyGgx,
    GlossyPhong,
    Mirror,
    SurfaceMaterial,
    dfg_table,
)
from reflet.reflectance.materials.material_maps import EnvironmentMaps
from reflet.reflectance.materials.metals import METALS
from reflet.reflectance.prefilter.brdf_map import BrdfMap3d
from reflet.render.filters.probe_filter import ggx_kernels
from reflet.scene.material import Material
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.scene import Part, ReflectiveObject, Scene
from reflet.scene.views.parameter_space import Orbit
from reflet.view.brdf_map_files import listed_taps, write_brdf_map
from reflet.view.static_files import SHADED_EXTENSION

VERSION = 2
_BUFFER = "shading.bin"
_LARGEST = 512  # rows of the cube: 17 MB with all levels
_SMALLEST = 64  # a lamp of 1° is found in texels of 1.4°, of 16 points each
_LARGEST_GGX = 256
_PHONG_SIZE = 128


@dataclass(frozen=True)
class NamedMap:
    """A map that the viewer shows as it is: its mip levels, finest first, down to one row, and how it is looked up."""

    levels: tuple[EnvImage, ...]
    lookup: Lookup = Lookup.VIEW_NORMAL


def write_shaded_scene(
    folder: str | Path,
    mesh: Mesh,
    environment: EnvImage | None,
    orbit: Orbit,
    materials: Sequence[SurfaceMaterial | str],
    *,
    maps: Mapping[str, NamedMap] | None = None,
    tables: Mapping[str, BrdfMap3d] | None = None,
    largest: int = _LARGEST,
) -> None:
    """Write what the viewer shows into ``folder``; ``scene.gltf`` comes last.

    ``materials`` are what the viewer offers first of their kind, each a material or the name of one of ``maps`` or of
    ``tables``: BRDFs by the maps of their lobes, filtered from this environment. It opens with the first. The
    environment, by default a plain white one, becomes a cube of about its own texels, of 64 to ``largest`` rows.
    Light that is too bright for half floats is spread (`spread_light`).

    Raises RefletError for radiance that is negative or not finite, and for materials that have no form in the viewer.
    """
    folder = Path(folder)
    maps, tables = maps or {}, tables or {}
    shown = environment or EnvImage(CUBE, np.ones((6, 1, 1, 3), np.float32))
    (shown,) = held([shown], HALF_MAX, "the viewer")
    cube = resample(EnvImage(shown.parameterization, shown.texels[..., :3]), CUBE, _cube_size(shown, largest))
    buffer = BufferWriter(_BUFFER)
    size = max(min(cube.size, _LARGEST_GGX), 32)
    lobes = [buffer.add(listed_taps(lobe_taps(kernel))) for kernel in ggx_kernels(size)[:-1]]  # the last is diffuse
    extension: dict[str, Any] = {
        "version": VERSION,
        "orbit": {
            "target": list(orbit.target),
            "azimuthDeg": orbit.azimuth_deg,
            "elevationDeg": orbit.elevation_deg,
            "distance": orbit.distance,
            "fovDeg": orbit.fov_deg,
        },
        "environment": _write_map(folder, "environment", mip_images(cube)),
        "diffuse": _write_map(folder, "diffuse", mip_images(EnvironmentMaps(shown).diffuse)),
        "dfg": buffer.add(dfg_table()),
        "ggx": {"size": size, "lobes": lobes},
        "phongSize": _PHONG_SIZE,
        "metals": _metals(materials),
        "maps": [
            {
                "name": name,
                "lookup": item.lookup.name.lower(),
                **_write_map(folder, f"map-{slug(name)}", held(item.levels, HALF_MAX, "the viewer")),
            }
            for name, item in maps.items()
        ],
        "tables": [
            {"name": name, **write_brdf_map(folder, f"maps/table-{number}.ktx2", item, buffer)}
            for number, (name, item) in enumerate(tables.items())
        ],
        "materials": [
            {"kind": "table", "table": material}
            if isinstance(material, str) and material in tables
            else material_to_json(material)
            for material in materials
        ],
    }
    buffer.write(folder)
    part = Part("mesh", mesh, Material("mesh"), True)
    document = write_scene(folder, Scene((part,), (ReflectiveObject("mesh", (0,)),)))
    document["extensionsUsed"] = [*document.get("extensionsUsed", []), SHADED_EXTENSION]
    document["extensions"] = {SHADED_EXTENSION: extension}
    atomic_write(folder / SCENE, (json.dumps(document, indent=1, ensure_ascii=False) + "\n").encode())


def material_to_json(material: SurfaceMaterial | str) -> dict[str, Any]:
    """A material as the viewer has it (`web/src/scene/material.ts`); a name is that of a map."""
    match material:
        case str():
            return {"kind": "map", "map": material}
        case Mirror(reflectance):
            return {"kind": "mirror", "reflectance": list(reflectance)}
        case Dielectric(index):
            return {"kind": "dielectric", "index": index}
        case DielectricOverDiffuse(index, albedo):
            return {"kind": "dielectric_over_diffuse", "index": index, "albedo": list(albedo)}
        case Coated(index, albedo):
            return {"kind": "coated", "index": index, "albedo": list(albedo)}
        case Conductor(n, k):
            return {"kind": "conductor", "n": list(n), "k": list(k)}
        case GlossyPhong(exponent, specular, diffuse):
            return {"kind": "phong", "exponent": exponent, "specular": list(specular), "diffuse": list(diffuse)}
        case GlossyGgx(color, metallic, roughness):
            return {"kind": "ggx", "baseColor": list(color), "metallic": metallic, "roughness": roughness}
    raise RefletError(f"The web viewer cannot show a {type(material).__name__} yet; reflet shade draws it.")


def _cube_size(image: EnvImage, largest: int) -> int:
    """Rows of a cube with about as many texels to a right angle, a power of two."""
    directions = np.prod(image.parameterization.shape(image.size)) / 6.0
    return int(min(largest, max(2 ** round(0.5 * np.log2(directions)), _SMALLEST)))


def _metals(materials: Sequence[SurfaceMaterial | str]) -> list[dict[str, Any]]:
    metals = dict(METALS)
    for material in materials:
        if isinstance(material, Conductor) and material not in metals.values():
            metals["as given"] = material
    return [{"name": name, "n": list(metal.n), "k": list(metal.k)} for name, metal in metals.items()]


def _write_map(folder: Path, name: str, levels: Sequence[EnvImage]) -> dict[str, Any]:
    levels = [spread_light(level, HALF_MAX).image for level in levels]  # resampled suns may come out a little brighter
    finest = levels[0]
    uri = f"maps/{name}.ktx2"
    texels = np.concatenate([level.texels[..., :3].reshape(-1, 3) for level in levels])
    write_ktx2(folder / uri, MipChain(finest.size, finest.parameterization), texels)
    return {"uri": uri, "parameterization": finest.parameterization.name, "size": finest.size}
