"""Writes a PEM's folder, one sample at a time, so that a bake stopped at any moment can go on."""

import json
import re
import shutil
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from math import inf
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Bool, Shaped

from reflet.envmap.env_map import EnvMap
from reflet.errors import RefletError
from reflet.files.atomic import atomic_path, atomic_write
from reflet.pem import layout
from reflet.pem.arrays import BufferWriter
from reflet.pem.compact import compacted
from reflet.pem.environment_file import write_environment
from reflet.pem.geometry_json import geometry_to_json
from reflet.pem.gltf_scene import write_scene
from reflet.pem.irradiance_json import irradiance_to_json
from reflet.pem.map_files import codec_named, read_map, write_map
from reflet.pem.pem import MOST_HITS, Layer, ParameterizedEnvironmentMap
from reflet.pem.surface_json import surface_to_json
from reflet.reflectance.materials.material import dfg_table
from reflet.scene.bvh.build import build_bvh
from reflet.scene.bvh.bvh import Bvh
from reflet.scene.roughness import is_rough
from reflet.scene.scene import Scene
from reflet.scene.surface_mean import coat_mean
from reflet.scene.surfaces.irradiance import IrradianceMap
from reflet.scene.surfaces.surface_layer import SurfaceLayer
from reflet.scene.views.parameter_space import ParameterSpace


class PemWriter:
    """An unfinished PEM in a folder.

    Call `write_sample` in any order, then `finish`. Every file appears whole or not at all, ``scene.gltf`` last. Equal
    input gives equal bytes. Holds no map in memory.
    """

    def __init__(
        self, folder: str | Path, parameters: Mapping[str, Any], *, codec: str = "av1", resume: bool = False
    ) -> None:
        """Begin a bake in a new or empty folder, or go on with the one that is there.

        ``parameters`` (anything that JSON can say) are all that the maps depend on; they are kept in ``bake.json``,
        and so is ``codec``, by which everything is made small; "none" writes plain numbers. Raises
        RefletError where the codec is unknown, where the folder holds a bake and ``resume`` is false, where that bake's
        parameters differ, where the folder holds something else, or cannot be written.
        """
        self.folder, self.codec = Path(folder), codec_named(codec)
        path = self.folder / layout.PARAMETERS
        wanted = {"version": layout.VERSION, "codec": codec, **parameters}
        if path.exists():
            if not resume:
                raise RefletError(
                    f"{self.folder} already holds a bake; go on with it by --resume, or choose another folder."
                )
            try:
                begun = _read_json(path)
            except RefletError:
                raise RefletError(f"{path} is damaged; bake again into a new folder.") from None
            _check_parameters(self.folder, begun, json.loads(_json(wanted)))
            self._clear_leftovers()
            return
        if self.folder.is_dir() and any(not item.name.startswith(".") for item in self.folder.iterdir()):
            raise RefletError(f"{self.folder} holds files that are not a bake's; choose a new or empty folder.")
        self._clear_leftovers()
        atomic_write(path, _json(wanted))

    def _clear_leftovers(self) -> None:
        """Drop what a killed bake was about to rename or to drop itself."""
        for leftover in self.folder.rglob(".*.tmp*"):
            leftover.unlink()
        if self.finished:
            shutil.rmtree(self.folder / layout.STATE, ignore_errors=True)

    @property
    def finished(self) -> bool:
        """Whether ``scene.gltf`` is there: nothing is left to do."""
        return (self.folder / layout.SCENE).exists()

    def has(self, sample: int) -> bool:
        """Whether all maps of a sample are written."""
        return (self.folder / layout.sample_folder(sample) / layout.SAMPLE).exists()

    def write_sample(
        self,
        sample: int,
        layers: Sequence[Layer],
        env_maps: Sequence[EnvMap],
        statistics: Mapping[str, Any] | None = None,
    ) -> None:
        """Write the maps of one sample, in the order of ``layers``, and what inference says of them."""
        for number, (layer, env_map) in enumerate(zip(layers, env_maps, strict=True)):
            write_map(self._map_path(sample, number, layer), env_map)
        atomic_write(self.folder / layout.sample_folder(sample) / layout.SAMPLE, _json(statistics or {}))

    def read_sample(self, sample: int, layers: Sequence[Layer]) -> tuple[EnvMap, ...]:
        """The maps that `write_sample` wrote, as they will be shown."""
        return tuple(read_map(self._map_path(sample, number, layer), layer) for number, layer in enumerate(layers))

    def _map_path(self, sample: int, number: int, layer: Layer) -> Path:
        return self.folder / layout.map_file(sample, number, layer.name, self.codec)

    def save_state(self, name: str, **arrays: Shaped[np.ndarray, "..."]) -> None:
        """Keep intermediate arrays until the bake is finished, under a name of the caller's."""
        with atomic_path(self.folder / layout.STATE / f"{name}.npz") as path, path.open("wb") as file:
            np.savez(file, **arrays)  # type: ignore[arg-type]

    def load_state(self, name: str) -> dict[str, Shaped[np.ndarray, "..."]] | None:
        """The arrays that `save_state` kept, or None."""
        path = self.folder / layout.STATE / f"{name}.npz"
        if not path.exists():
            return None
        with np.load(path) as file:
            return dict(file)

    def has_state(self, name: str) -> bool:
        """Whether `load_state` would find something."""
        return (self.folder / layout.STATE / f"{name}.npz").exists()

    def drop_state(self, names: Iterable[str]) -> None:
        """Forget arrays that are needed no more, where there are any."""
        for name in names:
            (self.folder / layout.STATE / f"{name}.npz").unlink(missing_ok=True)

    def discard(self) -> None:
        """Leave the folder as empty as it was."""
        for item in self.folder.iterdir():
            if item.is_dir() and not item.name.startswith("."):
                shutil.rmtree(item, ignore_errors=True)
            elif not item.name.startswith("."):
                item.unlink()

    def finish(
        self,
        *,
        scene: Scene,
        irradiance: IrradianceMap,
        space: ParameterSpace,
        layers: Sequence[Layer],
        on_hull: Bool[np.ndarray, "triangles"],
        lod_bias: float,
        sample_count: int,
        statistics: Mapping[str, Any] | None = None,
        base: Sequence[EnvMap] = (),
        fade_deg: float = 0.0,
        most_hits: int = 0,
        bvh: Bvh | None = None,
        surface: SurfaceLayer | None = None,
    ) -> None:
        """Write everything but the samples' maps, ``scene.gltf`` last, and drop the intermediate state.

        Where rays may have hits, the tree is built if it is not given. The samples' own statistics are gathered under
        ``statistics["samples"]``. Without a codec meshes and irradiance come back exactly, else as `compacted` makes
        them. Raises RefletError where maps of a sample are missing, or hits are too many.
        """
        if not 0 <= most_hits <= MOST_HITS:
            raise RefletError(
                f"Mirrored rays may have 0 to {MOST_HITS} hits, not {most_hits}; 5 show nearly all there is."
            )
        missing = [sample for sample in range(space.sample_count) if not self.has(sample)]
        if missing:
            raise RefletError(f"{self.folder} lacks the maps of sample {missing[0]}; go on with the bake by --resume.")
        distant = [(number, layer) for number, layer in enumerate(layers) if layer.kind == "distant"] if base else []
        base_files = [layout.base_file(number, layer.name, self.codec) for number, layer in distant]
        coded = self.codec != "none"
        with ThreadPoolExecutor() as pool:  # an encoder keeps one core busy, so does what makes meshes compact
            paths = [self.folder / file for file in base_files]
            written = pool.map(write_map, paths, base)
            if coded:
                compact = compacted(scene, irradiance, on_hull, bvh, traced=most_hits > 0, surface=surface)
                scene, irradiance, surface = compact.scene, compact.irradiance, compact.surface
                on_hull, bvh = compact.on_hull, compact.bvh
            list(written)  # raises what went wrong
        buffer = BufferWriter(layout.SURFACE_BUFFER)
        extension: dict[str, Any] = {
            "version": layout.VERSION,
            "objects": [{"name": item.name, "parts": list(item.parts)} for item in scene.objects],
            "reflective": [number for number, part in enumerate(scene.parts) if part.reflective],
            "parameterSpace": {
                "axes": [
                    {"name": axis.name, "values": list(axis.values)}
                    | ({} if axis.period is None else {"period": axis.period})
                    for axis in space.axes
                ],
                "orbit": {
                    "target": list(space.orbit.target),
                    "azimuthDeg": space.orbit.azimuth_deg,
                    "elevationDeg": space.orbit.elevation_deg,
                    "distance": space.orbit.distance,
                    "fovDeg": space.orbit.fov_deg,
                    "imageSize": space.orbit.image_size,
                },
            },
            "lodBias": lod_bias,
            "sampleCount": sample_count,
            "layers": [
                {
                    "name": layer.name,
                    "kind": layer.kind,
                    "parts": list(layer.parts),
                    "size": layer.size,
                    "parameterization": layer.parameterization.name,
                    "geometry": geometry_to_json(layer.geometry, buffer, coded=coded),
                    "begin": layer.begin,
                    **({"end": layer.end} if layer.end < inf else {}),
                }
                for layer in layers
            ],
            "samples": [
                {
                    "maps": [
                        layout.map_file(sample, number, layer.name, self.codec) for number, layer in enumerate(layers)
                    ]
                }
                for sample in range(space.sample_count)
            ],
            "base": base_files,
            "fadeDeg": fade_deg,
            "irradiance": irradiance_to_json(irradiance, buffer, coded=coded),
            "onHull": buffer.add(on_hull.astype(np.uint8), "deflate" if coded else None),
            "statistics": {
                **(statistics or {}),
                "samples": [
                    _read_json(self.folder / layout.sample_folder(sample) / layout.SAMPLE)
                    for sample in range(space.sample_count)
                ],
            },
        }
        if any(is_rough(part) for part in scene.parts):
            table = dfg_table().astype(np.float16).view(np.uint16)
            extension["ggxTable"] = buffer.add(table, "deflate" if coded else None)
        coats = [[number, *coat_mean(part)] for number, part in enumerate(scene.parts) if part.is_coated]
        if coats:
            extension["coats"] = coats
        if surface is not None:
            extension["surface"] = surface_to_json(surface, buffer, coded=coded)
        buffer.write(self.folder)
        if most_hits:
            bvh = bvh or build_bvh(scene, on_hull)
            tree = BufferWriter(layout.BVH_BUFFER)
            extension["traced"] = {
                "mostHits": most_hits,
                **({"companions": list(bvh.companions)} if bvh.companions else {}),
                "order": tree.add(bvh.order, "delta" if coded else None),
                "leafCounts": tree.add(bvh.leaf_counts, "deflate" if coded else None),
                "directions": tree.add(bvh.directions, "deflate" if coded else None),
            }
            tree.write(self.folder)
        if scene.environment is not None:
            extension["environment"] = write_environment(self.folder, scene.environment, self.codec)
        document = write_scene(self.folder, scene, coded=coded)
        document["extensionsUsed"] = [*document.get("extensionsUsed", []), layout.EXTENSION]
        document["extensions"] = {**document.get("extensions", {}), layout.EXTENSION: extension}
        atomic_write(self.folder / layout.SCENE, _json(document))
        shutil.rmtree(self.folder / layout.STATE, ignore_errors=True)


def save_pem(folder: str | Path, pem: ParameterizedEnvironmentMap, *, codec: str = "av1") -> None:
    """Write a whole PEM into a new or empty folder, which is left empty if that fails; ``codec`` "none" keeps plain
    numbers."""
    writer = PemWriter(folder, {}, codec=codec)
    try:
        _write_whole(writer, pem)
    except BaseException:
        writer.discard()
        raise


def _write_whole(writer: PemWriter, pem: ParameterizedEnvironmentMap) -> None:
    own = pem.statistics.get("samples", [{}] * len(pem.maps))
    for sample, env_maps in enumerate(pem.maps):
        writer.write_sample(sample, pem.layers, env_maps, own[sample])
    writer.finish(
        scene=pem.scene,
        irradiance=pem.irradiance,
        space=pem.space,
        layers=pem.layers,
        on_hull=pem.on_hull,
        lod_bias=pem.lod_bias,
        sample_count=pem.sample_count,
        statistics={name: value for name, value in pem.statistics.items() if name != "samples"},
        base=pem.base,
        fade_deg=pem.fade_deg,
        most_hits=pem.most_hits,
        bvh=pem.bvh,
        surface=pem.surface,
    )


def _check_parameters(folder: Path, begun: dict[str, Any], wanted: dict[str, Any]) -> None:
    for name in sorted({*begun, *wanted}):
        if begun.get(name) != wanted.get(name):
            raise RefletError(
                f"{folder} was begun with {name} {_brief(begun.get(name))}, not {_brief(wanted.get(name))}; "
                "resume with the same parameters or choose another folder."
            )


def _brief(value: Any) -> str:
    text = "unset" if value is None else json.dumps(value, ensure_ascii=False)
    return text if len(text) <= 60 else text[:57] + "…"


def _json(value: Any) -> bytes:
    """Indented, but for lists and objects of numbers and words alone, which take a line each."""
    text = json.dumps(value, indent=1, ensure_ascii=False, allow_nan=False, default=_plain)
    # a string holds no line break: what is found are lists and objects
    return (re.sub(r"([\[{])\n\s*([^][{}]*?)\n\s*([\]}])", _on_one_line, text) + "\n").encode()


def _on_one_line(found: re.Match[str]) -> str:
    return found[1] + re.sub(r"\n\s*", " ", found[2]) + found[3]


def _plain(value: Any) -> Any:
    """What JSON does not know: NumPy's scalars and arrays."""
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    raise TypeError(f"{type(value).__name__} cannot be written as JSON")


def _read_json(path: Path) -> dict[str, Any]:
    try:
        return json.loads(path.read_bytes())
    except (OSError, ValueError):
        raise RefletError(f"{path} is missing or damaged; delete it and bake again with --resume.") from None
