"""Everything an engine needs of an environment, in a folder, as the engine's own tool would make it."""

from contextlib import ExitStack
from pathlib import Path

from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.parameterizations.parameterization import Parameterization
from reflet.envmap.resampling.spread_light import HALF_MAX, held
from reflet.errors import RefletError
from reflet.files.atomic import atomic_path
from reflet.files.env_image_file import write_env_image
from reflet.files.textures.filament import quarter_turned, write_filament_cube, write_harmonics_text
from reflet.files.textures.packed_floats import R11G11B10_MAX
from reflet.pipelines.prefilter import read_environment_image
from reflet.progress import ProgressCallback, silent
from reflet.reflectance.brdfs.lambert import DiffuseKernel
from reflet.reflectance.prefilter.ggx_levels import FILAMENT, ggx_levels
from reflet.reflectance.prefilter.irradiance_sh import irradiance_harmonics
from reflet.reflectance.prefilter.prefilter import Prefilter, Progress
from reflet.reflectance.prefilter.sheen_levels import sheen_levels

ENGINES = ("gltf", "filament")
_DIFFUSE_SIZE = 64


def engine_maps(
    source: str | Path,
    folder: str | Path,
    engine: str,
    *,
    size: int = 256,
    source_is: Parameterization | None = None,
    progress: ProgressCallback = silent,
) -> tuple[Path, ...]:
    """Writes the maps of ``engine``, one of `ENGINES`, in cubes of ``size`` rows, a power of two; returns the files.

    - gltf: lambertian/diffuse.ktx2, ggx/specular.ktx2 and charlie/sheen.ktx2, half floats, as the glTF Sample Viewer
      looks them up: level k of n = log2(size), the last of 2 rows, has roughness k/(n - 1).
    - filament: FOLDER_ibl.ktx (GGX down to 16 rows by Filament's roughness, with harmonics), FOLDER_skybox.ktx, sh.txt.

    All files or none. Raises RefletError for what cannot be read, filtered or written.
    """
    folder = Path(folder)
    if engine not in ENGINES:
        raise RefletError(f"An engine is one of {', '.join(ENGINES)}; {engine} is none.")
    if not 8 <= size <= 2048 or size & (size - 1):
        raise RefletError(f"The cubes of engines have a power of two from 8 to 2048 rows, not {size}.")
    make = _gltf if engine == "gltf" else _filament
    with ExitStack() as all_or_none:
        return make(source, folder, size, source_is, progress, all_or_none)


def _gltf(
    source: str | Path,
    folder: Path,
    size: int,
    source_is: Parameterization | None,
    progress: ProgressCallback,
    all_or_none: ExitStack,
) -> tuple[Path, ...]:
    paths = tuple(folder / name for name in ("lambertian/diffuse.ktx2", "ggx/specular.ktx2", "charlie/sheen.ktx2"))
    diffuse, specular, sheen = (all_or_none.enter_context(atomic_path(path)) for path in paths)
    image = read_environment_image(source, source_is, progress)
    count = size.bit_length() - 1  # log2(size): the viewer counts its levels by the width
    rows = min(size, _DIFFUSE_SIZE)
    write_env_image(diffuse, [Prefilter(image).map(DiffuseKernel(), CUBE, rows, _stage("diffuse", progress))])
    levels = ggx_levels(image, CUBE, size, count, progress=_stage("ggx", progress))
    write_env_image(specular, held(levels, HALF_MAX, "half floats"))
    write_env_image(sheen, sheen_levels(image, CUBE, size, count, progress=_stage("sheen", progress)))
    return paths


def _filament(
    source: str | Path,
    folder: Path,
    size: int,
    source_is: Parameterization | None,
    progress: ProgressCallback,
    all_or_none: ExitStack,
) -> tuple[Path, ...]:
    name = folder.resolve().name
    paths = (folder / f"{name}_ibl.ktx", folder / f"{name}_skybox.ktx", folder / "sh.txt")
    ibl, skybox, text = (all_or_none.enter_context(atomic_path(path)) for path in paths)
    image = quarter_turned(read_environment_image(source, source_is, progress))
    irradiance = irradiance_harmonics(image)
    levels = ggx_levels(image, CUBE, size, scale=FILAMENT, progress=_stage("ggx", progress))
    levels = held(levels, min(R11G11B10_MAX), "R11G11B10F")
    write_filament_cube(ibl, levels, irradiance)
    write_filament_cube(skybox, levels[:1])
    write_harmonics_text(text, irradiance)
    return paths


def _stage(name: str, progress: ProgressCallback) -> Progress:
    return lambda done, total: progress(name, done, total)
