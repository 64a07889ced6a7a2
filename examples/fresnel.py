"""What an index of refraction does to a reflection: Figure 8 of Environment Maps and Their Applications (2000).

Run it with the folder to write to, and if you like with an environment of your own::

    python examples/fresnel.py out/fresnel [studio.hdr]

``fresnel.png`` shows a teapot and a torus of index 1.5 (glass), 5 and 200 (all but a perfect mirror), by three ways to
combine what they mirror, L_m, with what they diffuse, L_d. ``schlick.png`` shows how far Schlick's formula, which most
renderers use, is from the exact one.

What correct looks like: with index 1.5 only grazing angles mirror, and the objects' middles are dark in the first row
and painted in the others; with 200 the first row is a mirror. In the second row light is simply added, so that
everything with a high index is too bright; in the third, index 200 hides the paint.
"""

import sys
from pathlib import Path

from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.resampling.resample import resample
from reflet.files.env_image_file import read_env_image
from reflet.files.pictures.png import write_png
from reflet.pipelines.shade import frame_mesh, load_mesh
from reflet.reflectance.brdfs.fresnel_error import schlick_errors
from reflet.reflectance.materials.material import Coated, Dielectric, DielectricOverDiffuse, SurfaceMaterial
from reflet.reflectance.materials.material_maps import EnvironmentMaps
from reflet.reflectance.materials.metals import METALS
from reflet.render.materials.material_renderer import MaterialRenderer
from reflet.report.measures import picture_srgb
from reflet.report.plate import plate
from reflet.report.schlick_figure import write_schlick_figure
from reflet.scene.builtin.labelled_court import labelled_court

INDICES = (1.5, 5.0, 200.0)
PAINT = (0.32, 0.05, 0.025)
COMBINATIONS = ("F·Lm", "F·Lm + Ld", "F·Lm + (1 − F)·Ld")
PLOTTED = (1.33, 1.5, 2.4, 5.0)


def material(row: int, index: float) -> SurfaceMaterial:
    """The combination of this row."""
    return (Dielectric(index), DielectricOverDiffuse(index, PAINT), Coated(index, PAINT))[row]


def main(out: Path, source: Path | None = None, picture: int = 190, samples: int = 16, map_rows: int = 512) -> None:
    """Writes both figures; each of the 18 pictures has ``picture``² pixels."""
    environment = resample(read_env_image(source), CUBE, map_rows) if source else labelled_court(map_rows)
    maps = EnvironmentMaps(environment)
    cells: list[list] = [[] for _ in COMBINATIONS]
    for name, elevation in (("teapot", 22.0), ("torus", 40.0)):
        mesh = load_mesh(name)
        renderer = MaterialRenderer(mesh, maps)
        camera = frame_mesh(mesh, elevation_deg=elevation, image_size=picture).camera()
        for row, drawn in enumerate(cells):
            drawn += [
                picture_srgb(renderer.picture(material(row, index), camera, samples=samples)[..., :3])
                for index in INDICES
            ]
    out.mkdir(parents=True, exist_ok=True)
    titles = [f"n = {index:g}" for index in INDICES] * 2
    write_png(out / "fresnel.png", plate(cells, titles, COMBINATIONS))

    copper, aluminium = (complex(METALS[name].n[0], METALS[name].k[0]) for name in ("Cu", "Al"))
    errors = schlick_errors([*PLOTTED, copper, aluminium])
    write_schlick_figure(out / "schlick.png", errors)
    for each in errors:
        index = f"{each.n:.2f}" + (f" - {each.k:.2f}i" if each.k else "")
        print(f"index {index:>14s}: Schlick off by {each.largest:.3f} at most, {each.hemispherical:+.4f} in the mean")
    print(f"Look at fresnel.png and schlick.png in {out}.")


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]) if len(sys.argv) > 2 else None)
