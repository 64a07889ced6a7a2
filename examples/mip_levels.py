"""Mip levels by solid angle beside plain means of 2×2 texels, as a figure and as numbers.

Run it with the picture to write, and if you like with an environment of your own::

    python examples/mip_levels.py out/mip_levels.png [studio.hdr]

A texture's usual mip levels are means of 2×2 texels. In an environment map texels differ in solid angle, and some lie
outside the map: plain means make what lies at a cube's corners or a lat-long map's poles weigh too much, and let the
black beyond the disc of a round map in. Each sphere mirrors one coarse level alone.
"""

import sys
from pathlib import Path

import numpy as np

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.by_name import parameterization
from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.resampling.equal_sampling import equal_sampling_size
from reflet.envmap.resampling.mip_reduction import mip_images
from reflet.envmap.resampling.padding import outside_disc
from reflet.envmap.resampling.resample import resample
from reflet.files.env_image_file import read_env_image
from reflet.render.materials.env_map_renderer import render_mirror
from reflet.report.mip_figure import MipComparison, write_mip_figure
from reflet.scene.builtin.labelled_court import labelled_court
from reflet.scene.meshes.primitives import sphere_mesh
from reflet.scene.views.camera import Camera

SHOWN = {
    "cube": "cube", "latlong": "lat-long", "dual_paraboloid": "dual paraboloid", "angular": "angular",
    "octahedral": "octahedral",
}  # fmt: skip
ROWS = 16  # about, of the cube's level that the spheres mirror


def plain_levels(image: EnvImage) -> tuple[EnvImage, ...]:
    """Means of 2×2 texels, those outside the disc of a round map black."""
    texels = np.where(outside_disc(image.parameterization, image.size)[..., None], 0.0, image.texels)
    levels = [texels]
    while levels[-1].shape[1] > 1:
        faces, rows, columns, channels = levels[-1].shape
        levels.append(levels[-1].reshape(faces, rows // 2, 2, columns // 2, 2, channels).mean((2, 4)))
    return tuple(EnvImage(image.parameterization, level.astype(np.float32)) for level in levels)


def light(image: EnvImage) -> float:
    """∫ L dω, summed over the colours."""
    return float(np.einsum("frc,frck->", image.parameterization.texel_solid_angle(image.size), image.texels))


def compared(finest: EnvImage, name: str, rows: int, picture: int) -> MipComparison:
    """Levels of about the texels of a cube of ``rows``, mirrored in a sphere seen from aside."""
    to = parameterization(name)
    size, coarse = (equal_sampling_size(to, 6 * n**2, power_of_two=True) for n in (8 * rows, rows))
    image = resample(finest, to, size)
    ours, plain = mip_images(image), plain_levels(image)
    level = (size // coarse).bit_length() - 1
    camera = Camera((3.3, 1.6, 1.2), (0.0, 0.0, 0.0), fov_deg=32.0, width=picture, height=picture)
    mesh = sphere_mesh(around=256)
    shown = [
        render_mirror(mesh, [each], camera)[..., :3].astype(np.float64)
        for each in (plain[level], ours[level], resample(finest, to, coarse))
    ]
    errors = [np.array([light(each) for each in levels]) / light(image) - 1.0 for levels in (plain, ours)]
    return MipComparison(
        f"{SHOWN[name]}, level {level}: {ours[level].size} rows", (shown[0], shown[1], shown[2]), *errors
    )


def main(out: Path, source: Path | None = None, rows: int = ROWS, picture: int = 320) -> None:
    """Writes the figure; spheres mirror levels of about the texels of a cube of ``rows``."""
    finest = (
        resample(read_env_image(source), CUBE, equal_sampling_size(CUBE, 6 * (8 * rows) ** 2, power_of_two=True))
        if source
        else labelled_court(8 * rows)
    )
    comparisons = [compared(finest, name, rows, picture) for name in SHOWN]
    write_mip_figure(out, comparisons)
    for each in comparisons:
        plain, ours = np.abs(each.plain_error).max(), np.abs(each.our_error).max()
        print(f"{each.title}: of all light, plain means gain or lose up to {plain:.1%}, ours {ours:.4%}")
    print(f"Open {out}")


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]) if len(sys.argv) > 2 else None)
