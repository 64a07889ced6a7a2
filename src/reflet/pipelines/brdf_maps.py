"""The 3-D prefiltered maps of a measured BRDF, as files: a folder of lobe maps and what is needed to look them up."""

import json
from contextlib import ExitStack
from pathlib import Path

import numpy as np
from jaxtyping import Float

from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.parameterizations.octahedral import Octahedral
from reflet.envmap.parameterizations.parameterization import Parameterization
from reflet.envmap.resampling.equal_sampling import equal_sampling_size
from reflet.envmap.sampling import valid_texels
from reflet.errors import RefletError
from reflet.files.atomic import atomic_path, check_writable
from reflet.files.env_image_file import write_env_image
from reflet.files.measured_brdf_file import read_measured_brdf
from reflet.files.textures.env_texture import texture_from_slices
from reflet.files.textures.ktx2_container import write_texture
from reflet.pipelines.prefilter import read_environment_image
from reflet.progress import ProgressCallback, silent
from reflet.reflectance.lobes.lobes import Lobes, fit_lobes
from reflet.reflectance.prefilter.brdf_map import brdf_map_3d

_CUBE_ROWS = 64  # by default as many texels as in such a cube
_RULE = (
    "radiance = diffuse_albedo(n.v) * diffuse(n) + sum over lobes of lobe(axis, n.v); tables and slices are linear in "
    "n.v between cos_theta_o, and the first's below; a lobe's axis lies in the plane of normal and viewer, "
    "side * acos(n.v) + offset(n.v) radians from the normal, positive on the mirrored side"
)


def brdf_maps(
    source: str | Path,
    table: str | Path,
    folder: str | Path,
    *,
    to: Parameterization | None = None,
    size: int | None = None,
    source_is: Parameterization | None = None,
    texel_format: str | None = None,
    zstd: bool = False,
    progress: ProgressCallback = silent,
) -> tuple[Path, ...]:
    """Writes the environment filtered by the lobes of the BRDF table in ``table`` (`read_measured_brdf`) to ``folder``.

    Files: diffuse.ktx2, irradiance/π; for each lobe a .ktx2 of its name, a 2D array with a layer for each view angle;
    and lobes.json, whose ``lookup`` says how they make a picture. All files or none; returns their names. ``to``, by
    default octahedral, has one face, for layers cannot be cubes; ``size`` is its rows. Raises RefletError for what
    cannot be read, filtered or written.
    """
    folder, to = Path(folder), to or Octahedral()
    if to.face_count > 1:
        raise RefletError(
            f"The slices of a BRDF's map are layers of an array, which hold one face, not a {to}'s {to.face_count}; "
            "choose octahedral, latlong or another of one face."
        )
    if size is None:
        size = equal_sampling_size(to, valid_texels(CUBE) * _CUBE_ROWS**2, power_of_two=True)
    if not 1 <= size <= 1024:
        raise RefletError(f"A BRDF's maps have 1 to 1024 rows, not {size}.")
    brdf = read_measured_brdf(table)
    check_writable(folder / "lobes.json")
    image = read_environment_image(source, source_is, progress)
    progress("fit", 0, 1)
    lobes = fit_lobes(brdf)
    progress("fit", 1, 1)
    maps = brdf_map_3d(image, lobes, to, size, lambda done, total: progress("filter", done, total))
    paths = [folder / "diffuse.ktx2", *(folder / f"{lobe.name}.ktx2" for lobe in lobes.lobes), folder / "lobes.json"]
    with ExitStack() as all_or_none:
        diffuse, *of_lobes, text = (all_or_none.enter_context(atomic_path(path)) for path in paths)
        write_env_image(diffuse, [maps.diffuse], texel_format=texel_format, zstd=zstd)
        for path, slices in zip(of_lobes, maps.slices, strict=True):
            write_texture(path, texture_from_slices(slices, texel_format or "half", zstd=zstd))
        text.write_text(json.dumps(_document(source, table, lobes, to, size), indent=1) + "\n")
    return tuple(paths)


def _document(
    source: str | Path, table: str | Path, lobes: Lobes, to: Parameterization, size: int
) -> dict[str, object]:
    mirrored = np.arccos(lobes.cos_theta_o)
    return {
        "environment": Path(source).name,
        "brdf": Path(table).name,
        "parameterization": to.name,
        "rows": size,
        "lookup": _RULE,
        "cos_theta_o": _numbers(lobes.cos_theta_o),
        "diffuse_albedo": [_numbers(row) for row in lobes.diffuse],
        "lobes": [
            {
                "file": f"{lobe.name}.ktx2",
                "side": lobe.side,
                "offset": _numbers(lobe.axis_angle - lobe.side * mirrored),
                "albedo": [_numbers(row) for row in lobe.albedo],
            }
            for lobe in lobes.lobes
        ],
        "fit_error": _numbers(lobes.error),
    }


def _numbers(values: Float[np.ndarray, "n"]) -> list[float]:
    return [float(f"{value:.7g}") for value in values]
