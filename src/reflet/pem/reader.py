"""Opens a PEM's folder. Its maps are read from disk each time they are asked for."""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from math import inf
from pathlib import Path
from typing import Any, overload

from reflet.envmap.env_map import EnvMap
from reflet.envmap.parameterizations.by_name import parameterization
from reflet.errors import RefletError
from reflet.pem import layout
from reflet.pem.arrays import read_array
from reflet.pem.environment_file import read_environment
from reflet.pem.geometry_json import geometry_from_json
from reflet.pem.gltf_scene import read_parts, read_scene_lights
from reflet.pem.irradiance_json import irradiance_from_json
from reflet.pem.map_files import read_map
from reflet.pem.pem import MOST_HITS, MOST_SHELLS, Layer, ParameterizedEnvironmentMap
from reflet.pem.surface_json import surface_from_json
from reflet.scene.bvh.nodes import checked_bvh
from reflet.scene.roughness import as_mirrors
from reflet.scene.scene import ReflectiveObject, Scene
from reflet.scene.surfaces.surface_layer import SurfaceLayer
from reflet.scene.views.parameter_space import Axis, Orbit, ParameterSpace


def open_pem(folder: str | Path) -> ParameterizedEnvironmentMap:
    """Open a PEM that `PemWriter` wrote: its folder, or the ``scene.gltf`` in it.

    Meshes and irradiance are read at once, maps when asked. Raises RefletError where the folder is missing, is no PEM
    or an unfinished one, is of another version, or where a file is missing or damaged.
    """
    folder = Path(folder)
    if folder.name == layout.SCENE:
        folder = folder.parent
    document = _read_document(folder)
    extension = document["extensions"][layout.EXTENSION]
    try:
        return _assemble(folder, document, extension)
    except (KeyError, IndexError, TypeError, ValueError) as error:
        raise RefletError(
            f"{folder / layout.SCENE} is damaged ({error!r}); copy it again, or bake again into a new folder."
        ) from None


def read_statistics(folder: Path) -> tuple[list[str], dict[str, Any]]:
    """The names of a PEM's objects, and what its bake says of itself. Raises RefletError as `open_pem` does."""
    extension = _read_document(folder)["extensions"][layout.EXTENSION]
    return [item["name"] for item in extension["objects"]], extension["statistics"]


def _read_document(folder: Path) -> dict[str, Any]:
    path = folder / layout.SCENE
    if not path.exists():
        if (folder / layout.PARAMETERS).exists():
            raise RefletError(f"{folder} holds an unfinished bake; go on with it by the same reflet bake and --resume.")
        if not folder.exists():
            raise RefletError(f"{folder} does not exist; give the folder that reflet bake wrote.")
        what = f"holds no {layout.SCENE}" if folder.is_dir() else "is a file"
        raise RefletError(
            f"{folder} is not the folder of a parameterized environment map: it {what}; reflet bake makes one."
        )
    try:
        document = json.loads(path.read_bytes())
    except (OSError, ValueError):
        raise RefletError(f"{path} is truncated or damaged; copy it again, or bake again into a new folder.") from None
    extensions = document.get("extensions", {}) if isinstance(document, dict) else {}
    if layout.EXTENSION not in extensions:
        raise RefletError(
            f"{path} is a plain glTF file, not a parameterized environment map; make one of it by reflet bake."
        )
    version = extensions[layout.EXTENSION].get("version")
    if version != layout.VERSION:
        raise RefletError(
            f"{path} is of format version {version}, and this reflet reads version {layout.VERSION}; "
            "use the release that wrote it, or bake again."
        )
    return document


def _assemble(folder: Path, document: dict[str, Any], extension: dict[str, Any]) -> ParameterizedEnvironmentMap:
    environment = None
    if "environment" in extension:
        environment = read_environment(folder, extension["environment"])
    scene = Scene(
        parts=read_parts(folder, document, set(extension["reflective"])),
        objects=tuple(ReflectiveObject(item["name"], tuple(item["parts"])) for item in extension["objects"]),
        environment=environment,
        lights=read_scene_lights(folder, document),
    )
    if "ggxTable" not in extension:
        scene = as_mirrors(scene)
    elif read_array(folder, extension["ggxTable"]).shape[2:] != (4,):  # viewers need it; ours have their own
        raise ValueError("its ggxTable is none")
    space = extension["parameterSpace"]
    orbit = space["orbit"]
    layers = tuple(
        Layer(
            item["name"],
            item["kind"],
            tuple(item["parts"]),
            geometry_from_json(item["geometry"], folder),
            item["size"],
            parameterization(item["parameterization"]),
            item["begin"],
            item.get("end", inf),
        )
        for item in extension["layers"]
    )
    _check_shells(layers)
    if not extension["samples"] and not extension["base"]:
        raise ValueError("it has neither samples nor a base")
    return ParameterizedEnvironmentMap(
        scene=scene,
        irradiance=irradiance_from_json(extension["irradiance"], folder),
        space=ParameterSpace(
            axes=tuple(Axis(axis["name"], tuple(axis["values"]), axis.get("period")) for axis in space["axes"]),
            orbit=Orbit(
                target=tuple(orbit["target"]),
                azimuth_deg=orbit["azimuthDeg"],
                elevation_deg=orbit["elevationDeg"],
                distance=orbit["distance"],
                fov_deg=orbit["fovDeg"],
                image_size=orbit["imageSize"],
            ),
        ),
        layers=layers,
        maps=_MapsOnDisk(folder, layers, tuple(tuple(sample["maps"]) for sample in extension["samples"])),
        on_hull=read_array(folder, extension["onHull"]).astype(bool),
        lod_bias=extension["lodBias"],
        sample_count=extension["sampleCount"],
        statistics=extension["statistics"],
        base=tuple(
            read_map(folder / uri, layer)
            for layer, uri in zip(_distant(layers) if extension["base"] else (), extension["base"], strict=True)
        ),
        fade_deg=extension["fadeDeg"],
        surface=_read_surface(folder, extension.get("surface"), scene),
        **_read_traced(folder, extension.get("traced"), scene),
    )


def _read_surface(folder: Path, description: dict[str, Any] | None, scene: Scene) -> SurfaceLayer | None:
    return None if description is None else surface_from_json(description, folder, int(scene.triangle_offsets[-1]))


def _read_traced(folder: Path, description: dict[str, Any] | None, scene: Scene) -> dict[str, Any]:
    """How often rays may hit and the tree for it; nothing where they are not traced."""
    if description is None:
        return {}
    most_hits = description["mostHits"]
    if type(most_hits) is not int or not 1 <= most_hits <= MOST_HITS:
        raise ValueError(f"rays may have 1 to {MOST_HITS} hits, not {most_hits!r}")
    names = {"order": "order", "leaf_counts": "leafCounts", "directions": "directions"}
    arrays = {name: read_array(folder, description[key]) for name, key in names.items()}
    return {"most_hits": most_hits, "bvh": checked_bvh(scene, **arrays, companions=description.get("companions", []))}


def _check_shells(layers: Sequence[Layer]) -> None:
    """Raises ValueError where an object's distant layers do not divide its surroundings."""
    for parts in {layer.parts for layer in _distant(layers)}:
        reach = [(layer.begin, layer.end) for layer in _distant(layers) if layer.parts == parts]
        ends = [end for _, end in reach]
        if [begin for begin, _ in reach] != [0.0, *ends[:-1]] or ends[-1] != inf or len(reach) > MOST_SHELLS:
            raise ValueError(f"shells of parts {parts} reach {reach}")


def _distant(layers: Sequence[Layer]) -> list[Layer]:
    return [layer for layer in layers if layer.kind == "distant"]


@dataclass(frozen=True)
class _MapsOnDisk(Sequence[tuple[EnvMap, ...]]):
    """The maps of all samples, none of them in memory."""

    folder: Path
    layers: tuple[Layer, ...]
    files: tuple[tuple[str, ...], ...]

    def __len__(self) -> int:
        return len(self.files)

    @overload
    def __getitem__(self, index: int) -> tuple[EnvMap, ...]: ...
    @overload
    def __getitem__(self, index: slice) -> "_MapsOnDisk": ...
    def __getitem__(self, index: int | slice) -> "tuple[EnvMap, ...] | _MapsOnDisk":
        if isinstance(index, slice):
            return _MapsOnDisk(self.folder, self.layers, self.files[index])
        return tuple(
            read_map(self.folder / name, layer) for layer, name in zip(self.layers, self.files[index], strict=True)
        )
