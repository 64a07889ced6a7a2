"""Meshes of environment-mapped materials for the web viewer: mesh, environment and materials by name, a folder."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.parameterizations.octahedral import Octahedral
from reflet.envmap.parameterizations.parameterization import Parameterization
from reflet.envmap.resampling.mip_reduction import mip_images
from reflet.envmap.resampling.resample import resample
from reflet.envmap.resampling.spread_light import HALF_MAX, held
from reflet.errors import RefletError
from reflet.files.env_image_file import read_light
from reflet.pipelines.shade import frame_mesh, load_mesh, surface_material
from reflet.pipelines.sketch import map_material, shows_map
from reflet.progress import ProgressCallback, silent
from reflet.reflectance.materials.material import Coated, Rgb, SurfaceMaterial
from reflet.reflectance.materials.measured_material import Measured
from reflet.reflectance.prefilter.brdf_map import BrdfMap3d, brdf_map_3d, rows_for
from reflet.scene.meshes.mesh import Mesh
from reflet.view.shaded_scene import NamedMap, write_shaded_scene

_TABLE_ROWS = 128  # at most, of a measured BRDF's maps
_WHITE = EnvImage(CUBE, np.ones((6, 1, 1, 3), np.float32))  # the light where the environment's file is a drawing
RED_PAINT = Coated(1.5, (0.5, 0.02, 0.02))  # what the viewer opens with where nothing is chosen: it shows both lookups


def write_materials_view(
    folder: str | Path,
    mesh: str | Path | Mesh,
    environment: str | Path | None,
    materials: Sequence[str] = (),
    *,
    source_is: Parameterization | None = None,
    albedo: Rgb | None = None,
    specular: Rgb | None = None,
    metallic: float = 0.0,
    azimuth_deg: float | None = None,
    elevation_deg: float | None = None,
    distance: float | None = None,
    progress: ProgressCallback = silent,
) -> None:
    """Write what the web viewer shows of a mesh in an environment into ``folder``.

    ``mesh`` is what `reflet.pipelines.shade.load_mesh` takes, or one itself; ``materials`` are names as of `reflet
    shade`, the first of them what the viewer opens with. Drawings need no environment; ``map:LOOKUP`` shows the
    environment's file itself. ``source_is`` is that file's parameterization where it does not tell. ``progress`` hears
    of what is read and written, and of the maps that BRDF tables take, some tenths of a second each. Raises RefletError
    for what is unknown, and where lit materials have no environment.
    """
    progress("read", 0, 3)
    shown: list[SurfaceMaterial | str] = []
    maps: dict[str, NamedMap] = {}
    measured: dict[str, Measured] = {}
    for name in materials:
        if shows_map(name):
            of_file = name.startswith("map:")
            levels, lookup = map_material(name, environment if of_file else None, source_is)
            maps[name] = NamedMap(_whole(levels), lookup)
            shown.append(name)
        elif name == "gltf":
            raise RefletError("The web viewer gives all of a mesh one material, not gltf; reflet shade draws those.")
        elif environment is None:
            raise RefletError(
                f"The material {name} is lit by an environment, and none came; name a file after the mesh."
            )
        else:
            material = surface_material(name, albedo, specular, metallic)
            if isinstance(material, Measured):
                file = Path(name.partition(":")[2]).name
                if file in measured:
                    raise RefletError(
                        f"The viewer tells BRDF tables by their files' names; two are {file}: rename one."
                    )
                measured[file] = material
                shown.append(file)
            else:
                shown.append(material)
    progress("read", 1, 3)
    shape = mesh if isinstance(mesh, Mesh) else load_mesh(mesh)
    progress("read", 2, 3)
    lit = environment is not None and not any(name.startswith("map:") for name in materials)
    image = None
    if lit and environment is not None:
        (image,) = held([read_light(environment, source_is)], HALF_MAX, "the viewer")
    progress("read", 3, 3)
    tables = {name: _filtered(image or _WHITE, material, name, progress) for name, material in measured.items()}
    progress("write", 0, 1)
    write_shaded_scene(
        folder,
        shape,
        image,
        frame_mesh(shape, azimuth_deg=azimuth_deg, elevation_deg=elevation_deg, distance=distance),
        shown or [RED_PAINT],
        maps=maps,
        tables=tables,
    )
    progress("write", 1, 1)


def _filtered(image: EnvImage, material: Measured, name: str, progress: ProgressCallback) -> BrdfMap3d:
    """The maps of a table's lobes, as large as `reflet.reflectance.materials.material_maps` makes them."""
    to = Octahedral()
    return brdf_map_3d(
        EnvImage(image.parameterization, image.texels[..., :3]),
        material.lobes,
        to,
        rows_for(material.lobes, to, _TABLE_ROWS),
        lambda done, total: progress(f"filter {name}", done, total),
    )


def _whole(levels: Sequence[EnvImage]) -> tuple[EnvImage, ...]:
    """The levels, where all are there down to one row; else filtered from the finest."""
    finest = levels[0]
    size = 1 << (finest.size.bit_length() - 1)
    if finest.size == size and len(levels) == size.bit_length():
        return tuple(levels)
    return mip_images(finest if finest.size == size else resample(finest, finest.parameterization, size))
