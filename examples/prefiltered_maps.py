"""Maps filtered for diffuse and glossy surfaces: Figures 9 and 10 of Environment Maps and Their Applications (2000).

Run it with the folder to write to, and if you like with an environment of your own::

    python examples/prefiltered_maps.py out/prefiltered [studio.hdr]

``diffuse.png`` is Figure 9: the diffusely filtered map, as a dual paraboloid, a torus that shows it by its normals, and
the same torus with a mirror's reflection added. ``glossy.png`` is Figure 10: the environment filtered with Phong's lobe
of roughness 0.01 (exponent 100), and a sphere and a torus that show it in the mirrored direction.

What correct looks like: the diffuse map has no edges, and is brightest where the sun is; each wall tints the side of
the torus that faces it. In the glossy map one can still tell the walls and not read their names; the sun is a soft
round spot without rings or blocks, also where it lies on the discs' border.
"""

import sys
from pathlib import Path

import numpy as np

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.parameterizations.dual_paraboloid import DualParaboloid
from reflet.envmap.resampling.resample import resample
from reflet.files.env_image_file import read_env_image
from reflet.files.pictures.png import write_png
from reflet.pipelines.shade import frame_mesh, load_mesh
from reflet.reflectance.materials.material import Coated, GlossyPhong, SurfaceMaterial
from reflet.reflectance.materials.material_maps import EnvironmentMaps
from reflet.render.materials.material_renderer import MaterialRenderer
from reflet.report.flat_sheet import flat_sheet
from reflet.report.measures import EXPOSURE, picture_srgb
from reflet.report.plate import plate
from reflet.scene.builtin.labelled_court import labelled_court

DIM = 0.6  # exposure of Figure 9: in full sun white is white
ROUGHNESS = 0.01  # the notes' r: the exponent is 1/r
WHITE, BLACK = (1.0, 1.0, 1.0), (0.0, 0.0, 0.0)


def main(out: Path, source: Path | None = None, picture: int = 320, samples: int = 16, map_rows: int = 512) -> None:
    """Writes both figures, ``picture`` pixels high."""
    environment = resample(read_env_image(source), CUBE, map_rows) if source else labelled_court(map_rows)
    maps = EnvironmentMaps(environment, size=map_rows // 2, parameterization=DualParaboloid())
    glossy = GlossyPhong(1.0 / ROUGHNESS, WHITE)

    def drawn(name: str, material: SurfaceMaterial, exposure: float = EXPOSURE) -> np.ndarray:
        mesh = load_mesh(name)
        camera = frame_mesh(mesh, elevation_deg=35.0, image_size=picture).camera()
        radiance = MaterialRenderer(mesh, maps).picture(material, camera, samples=samples)
        return picture_srgb(radiance[..., :3], exposure)

    diffuse = [
        flat(maps.diffuse, picture, DIM),
        drawn("torus", GlossyPhong(1.0, BLACK, WHITE), DIM),
        drawn("torus", Coated(5.0), DIM),
    ]
    shiny = [flat(maps.phong(glossy.phong_exponent)[0], picture), drawn("sphere", glossy), drawn("torus", glossy)]
    out.mkdir(parents=True, exist_ok=True)
    write_png(out / "diffuse.png", plate([diffuse], ["filtered diffusely", "Ld", "F·Lm + (1 − F)·Ld, n = 5"]))
    titles = [f"filtered with Phong's lobe, N = {glossy.phong_exponent:g}", "on a sphere", "on a torus"]
    write_png(out / "glossy.png", plate([shiny], titles))
    print(f"Look at diffuse.png and glossy.png in {out}.")


def flat(image: EnvImage, rows: int, exposure: float = EXPOSURE) -> np.ndarray:
    """The map laid flat, of so many rows; what is no part of it is white."""
    sheet, shown = flat_sheet(resample(image, image.parameterization, rows))
    return np.where(shown[..., None], picture_srgb(sheet[..., :3], exposure), 255).astype(np.uint8)


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]) if len(sys.argv) > 2 else None)
