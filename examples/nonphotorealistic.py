"""Drawings as environment maps: Figure 15 of Environment Maps and Their Applications (2000).

Run it with the folder to write to, and if you like with a mesh of your own::

    python examples/nonphotorealistic.py out/drawings [model.glb]

``drawings.png`` shows a sketched room, cool-to-warm shading, silhouettes, hatching, and the last three over one
another: as a ball, which is the map as its viewer sees it, and on a teapot and a torus. ``levels.png`` shows why mip
levels of such maps are drawn and not filtered: a ball at four distances with the one and the other.

What correct looks like: lines are of one width everywhere, on the spout as on the belly; strokes are denser towards
contours and do not break at any seam. In the second figure the line of the upper row stays as it is while the ball
shrinks; in the lower row it shrinks with it.
"""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from reflet.envmap.parameterizations.dual_paraboloid import DualParaboloid
from reflet.envmap.resampling.mip_reduction import mip_images
from reflet.files.pictures.picture_file import as_srgb
from reflet.files.pictures.png import write_png
from reflet.npr.drawing import drawn_levels
from reflet.npr.silhouette import Silhouette
from reflet.pipelines.shade import frame_mesh, load_mesh
from reflet.pipelines.sketch import on_paper, sketch, sketch_levels
from reflet.report.plate import plate
from reflet.scene.views.camera import Camera

DRAWINGS = {
    "window": "window",
    "gooch": "gooch",
    "silhouette": "silhouette",
    "hatching": "hatching+silhouette:1.5",
    "all of the last three": "gooch+hatching+silhouette:1.5",
}
ELEVATIONS = {"sphere": 0.0, "teapot": 22.0, "torus": 32.0}
CLOSER = {"teapot": 0.94}  # than shows the mesh's bounding sphere
DISTANCES = (3.6, 7.0, 14.0, 28.0)  # metres from a ball of radius 1
AS_WIDE = 11.0  # pixels on the finest level alone, so that filtered it is as wide on the nearest ball


def main(out: Path, model: Path | None = None, picture: int = 280, samples: int = 16, map_rows: int = 256) -> None:
    """Writes both figures, of pictures of ``picture``² pixels."""
    maps = [sketch_levels(drawing, size=map_rows) for drawing in DRAWINGS.values()]
    rows = []
    for name in ("sphere", "teapot", str(model) if model else "torus"):
        mesh = load_mesh(name)
        orbit = frame_mesh(mesh, elevation_deg=ELEVATIONS.get(name), image_size=picture)
        camera = replace(orbit, distance=CLOSER.get(name, 1.0) * orbit.distance).camera()
        pictures = [as_srgb(on_paper(sketch(mesh, levels, camera, samples=samples))) for levels in maps]
        empty = picture // 9 if name in ("teapot", "torus") else 0  # rows above and below these two
        rows.append([each[empty : picture - empty] for each in pictures])
    out.mkdir(parents=True, exist_ok=True)
    write_png(out / "drawings.png", plate(rows, columns=tuple(DRAWINGS)))

    ball = load_mesh("sphere")
    drawn = drawn_levels(Silhouette(), DualParaboloid(), map_rows)
    wide = drawn_levels(Silhouette(AS_WIDE), DualParaboloid(), map_rows)
    ways = {"levels drawn": drawn, "levels filtered from the finest": mip_images(wide[0])}
    rows = []
    for way, levels in ways.items():
        views, widths = [], []
        for distance in DISTANCES:
            camera = frame_mesh(ball, distance=distance, image_size=picture).camera()
            view = on_paper(sketch(ball, levels, camera, samples=samples))
            views.append(as_srgb(view))
            widths.append(f"{line_width(view, camera, distance):.2f} px")
        rows.append(views)
        print(f"{way}: a line of {', '.join(widths)} at {', '.join(f'{each:g} m' for each in DISTANCES)}")
    write_png(out / "levels.png", plate(rows, [f"{distance:g} m away" for distance in DISTANCES], tuple(ways)))
    print(f"Look at drawings.png and levels.png in {out}.")


def line_width(view: np.ndarray, camera: Camera, distance: float) -> float:
    """Width in pixels that the ink around a ball of radius 1 would have, were all of it black and at the contour."""
    radius = 0.5 * camera.height / (np.tan(np.radians(0.5 * camera.fov_deg)) * np.sqrt(distance**2 - 1.0))
    return float(radius - np.sqrt(radius**2 - (1.0 - view[..., 0]).sum() / np.pi))


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]) if len(sys.argv) > 2 else None)
