"""Prefiltered maps and what they look like on spheres, one for each BRDF of `reflet prefilter`.

Run it with the picture to write, and if you like with an environment of your own::

    python examples/prefilter_levels.py levels.png [studio.hdr]

Each column has a filtered map, as a lat-long picture, and a sphere that looks it up, the diffuse one by its normals,
the others in the mirrored direction. Reflectances and Fresnel's law are left out: in a white environment all would be
white.

What correct looks like: from left to right GGX goes from a mirror to something as soft as the diffuse sphere. The
label on the front wall reads mirrored in the spheres and as it should in the maps. Phong's lobes of exponent 10 and 100
have no haze around the sun, as GGX's has. Sheen's lobe is a ring: a sun becomes one. Nowhere are there rings around
lamps, blocks, seams or single bright pixels.
"""

import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.latlong import LatLong
from reflet.envmap.resampling.resample import radiance_at, resample
from reflet.files.env_image_file import read_env_image
from reflet.files.pictures.png import write_png
from reflet.pipelines.prefilter import lobe
from reflet.reflectance.prefilter.prefilter import Prefilter
from reflet.report.measures import picture_srgb
from reflet.report.plate import plate
from reflet.scene.builtin.labelled_court import labelled_court

BRDFS = (
    (None, "ggx:0.1", "ggx:0.25", "ggx:0.5", "ggx:1"),
    ("diffuse", "phong:100", "phong:10", "sheen:0.3", "sheen:0.7"),
)
PER_PIXEL = 3  # samples along an edge


def filtered(environment: Prefilter, brdf: str | None, rows: int) -> EnvImage:
    """A lat-long map; the environment itself for no BRDF, a mirror's."""
    kernel = lobe(brdf).kernel if brdf else None
    if kernel is None:
        return resample(environment.image, LatLong(), rows)
    return environment.map(kernel, LatLong(), rows)


def sphere(image: EnvImage, by_normal: bool, pixels: int, exposure: float) -> np.ndarray:
    """A sphere seen from far away along -z, that is from +z, on white."""
    at = (np.arange(PER_PIXEL * pixels) + 0.5) * (2.0 / (PER_PIXEL * pixels)) - 1.0
    x, y = np.meshgrid(1.03 * at, -1.03 * at)
    square = x * x + y * y
    z = np.sqrt(np.maximum(1.0 - square, 0.0))
    normal = np.stack([x, y, z], -1)
    mirrored = 2.0 * z[..., None] * normal - np.array([0.0, 0.0, 1.0])
    seen = picture_srgb(radiance_at(image, normal if by_normal else mirrored), exposure).astype(np.float64)
    seen[square >= 1.0] = 255.0
    return np.rint(seen.reshape(pixels, PER_PIXEL, pixels, PER_PIXEL, 3).mean((1, 3))).astype(np.uint8)


def main(
    out: Path,
    source: Path | None = None,
    rows: int = 96,
    exposure: float = 0.8,
    brdfs: Sequence[Sequence[str | None]] = BRDFS,
) -> None:
    """Writes the plate; maps have ``rows`` rows, and spheres are twice as wide."""
    image = read_env_image(source) if source else labelled_court(4 * rows)
    environment = Prefilter(EnvImage(image.parameterization, np.ascontiguousarray(image.texels[..., :3], np.float32)))
    plates = []
    for some in brdfs:
        maps = [filtered(environment, brdf, 2 * rows) for brdf in some]
        flat = [picture_srgb(resample(each, LatLong(), rows).texels[0], exposure) for each in maps]
        balls = [sphere(each, b == "diffuse", 2 * rows, exposure) for b, each in zip(some, maps, strict=True)]
        plates.append(plate([flat, balls], columns=[brdf or "mirror" for brdf in some]))
    write_png(out, np.concatenate(plates))
    print(f"{out} is written.")


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]) if len(sys.argv) > 2 else None)
