"""One environment in all seven parameterizations, as a page of pictures.

Run it with the folder to write to, and if you like with an environment of your own::

    python examples/parameterizations.py out/parameterizations [studio.hdr]

Each map is shown flat, and as the mirror image in a sphere and a torus seen from two sides, in the manner of Figures 6
to 8 of View-independent Environment Maps (1998). The gazing ball was made for a viewer at +z: from there it is as good
as any, from aside its singularity shows. All maps have about the same number of texels over the sphere, so the table on
the page says what each makes of them.
"""

import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS
from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.resampling.equal_sampling import equal_sampling_size
from reflet.envmap.resampling.mip_reduction import mip_images
from reflet.envmap.resampling.resample import resample
from reflet.envmap.sampling import analyze
from reflet.files.atomic import atomic_write
from reflet.files.env_image_file import read_env_image
from reflet.files.pictures.png import write_png
from reflet.render.materials.env_map_renderer import render_mirror
from reflet.report.flat_sheet import flat_sheet
from reflet.report.measures import display_psnr, picture_srgb
from reflet.report.parameterizations_page import Showcase, View, parameterizations_page
from reflet.scene.builtin.labelled_court import labelled_court
from reflet.scene.meshes.primitives import sphere_mesh, torus_mesh
from reflet.scene.views.camera import Camera

WATCH = {
    "cube": "Six perspective pictures. Texels are five times as dense in the corners as amid a face. Follow beam and "
    "coping over the edges: they must not bend, break or blur.",
    "latlong": "Rows of the map are circles of latitude. Look at the poles, the board +Y overhead and the floor's -Y: "
    "texels crowd there, along one axis only, and are wasted.",
    "dual_paraboloid": "Two mirrors, one for +z, one for -z; the dimmed ring beyond each disc goes on into the other "
    "half. The border runs through the walls +X and -X and over board and floor; no line may show there.",
    "gazing_ball": "What a viewer at +z sees in a small mirror ball. From the front it is as good as any; from aside "
    "look for the wall -Z: that one direction is the map's whole rim, and all around it is smeared along the radius.",
    "angular": "The light probe: the distance from the middle is the angle from -z. Its rim is the direction +z, which "
    "the front of the sphere mirrors: look for stretched texels in the label +Z.",
    "octahedral": "The sphere as an octahedron, folded out into a square: +Y in the middle, -Y in all four corners. "
    "Lines bend at the folds in the map, and must be straight again in the mirror.",
    "equal_area_octahedral": "The same square, every texel of the same solid angle. Compare it with the octahedral one "
    "at the walls' corners.",
}
TEXELS = 6 * 128**2
FINER = 16  # times the texels has the map that all are compared with


def main(out: Path, source: Path | None = None, picture: int = 384, texels: int = TEXELS, samples: int = 16) -> None:
    """Writes ``index.html`` and its pictures, ``picture``² pixels each, into ``out``; maps have ``texels`` texels."""
    fine = equal_sampling_size(CUBE, FINER * texels, power_of_two=True)
    finest = resample(read_env_image(source), CUBE, fine) if source else labelled_court(fine)
    meshes = {"sphere": sphere_mesh(), "torus": torus_mesh()}
    sides = {"front": (0.0, 1.9, 3.4), "aside": (3.4, 1.9, -0.6)}
    angles = [
        (f"{shape}, {side}", f"{shape}-{side}", meshes[shape], at) for shape in meshes for side, at in sides.items()
    ]
    cameras = [Camera(at, (0.0, 0.0, 0.0), fov_deg=36.0, width=picture, height=picture) for *_, at in angles]

    def look(levels: Sequence[EnvImage]) -> list[np.ndarray]:
        return [
            render_mirror(mesh, levels, camera, samples=samples)
            for (_, _, mesh, _), camera in zip(angles, cameras, strict=True)
        ]

    references = look(mip_images(finest))
    for (_, file, _, _), reference in zip(angles, references, strict=True):
        write_png(out / f"reference-{file}.png", picture_srgb(reference[..., :3]))
    showcases = []
    for name, to in PARAMETERIZATIONS.items():
        image = resample(finest, to, equal_sampling_size(to, texels))
        write_png(out / f"{name}.png", sheet_picture(image))
        views = []
        for (title, file, _, _), reference, drawn in zip(angles, references, look([image]), strict=True):
            write_png(out / f"{name}-{file}.png", picture_srgb(drawn[..., :3]))
            psnr = display_psnr(reference[..., :3], drawn[..., :3], reference[..., 3] > 0.5)
            views.append(View(title, f"{name}-{file}.png", psnr))
        faces, rows, columns = to.shape(image.size)
        size = f"{columns}×{rows}" + (f"×{faces}" if faces > 1 else "")
        showcases.append(Showcase(name, size, analyze(to), WATCH[name], f"{name}.png", tuple(views)))
        print(f"{name} {size}: " + ", ".join(f"{view.title} {view.psnr_display:.1f} dB" for view in views), flush=True)
    shown = [View(title, f"reference-{file}.png", float("inf")) for title, file, _, _ in angles]
    words = f"The environment {source.name}" if source else "A court with labelled walls, drawn by formula"
    atomic_write(out / "index.html", parameterizations_page(showcases, shown, texels, words).encode())
    print(f"Open {out / 'index.html'}")


def sheet_picture(image: EnvImage) -> np.ndarray:
    """The map laid flat, sRGB with alpha: what lies beyond a disc is pale, what is no part of the map left out."""
    sheet, shown = flat_sheet(image)
    alpha = np.where(shown, 255, 0 if image.parameterization == CUBE else 90).astype(np.uint8)
    return np.dstack([picture_srgb(sheet[..., :3]), alpha])


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]) if len(sys.argv) > 2 else None)
