"""``reflet sketch``."""

from pathlib import Path

import click

from reflet.cli.options import PARAMETERIZATION
from reflet.envmap.parameterizations.parameterization import Parameterization


@click.command(short_help="Draw a non-photorealistic map.")
@click.argument("drawing", metavar="DRAWING")
@click.option("--size", type=click.IntRange(1, 8192), default=256, show_default=True, help="Rows of a face.")
@click.option("--parameterization", type=PARAMETERIZATION, default="dual_paraboloid", show_default=True)
@click.option("--seed", type=click.IntRange(0), default=1, show_default=True, help="Another hand.")
@click.option("-o", "--output", type=click.Path(path_type=Path), required=True, help="The file to write.")
def sketch(drawing: str, size: int, parameterization: Parameterization, seed: int, output: Path) -> None:
    """Writes DRAWING as an environment map with every mip level drawn, not filtered, so that lines keep their width.

    A .ktx2, .ktx or .dds holds all levels. Of a .png, .exr or .hdr, {level} in the name stands for the number of each;
    without it there is the finest level alone.

    \b
    Drawings, with the width of their lines in pixels:
      silhouette:2.5   contours as a line of constant width
      hatching:1.5     rows of strokes near contours
      window:1.5       the room around the viewer, with windows, mirrored
      gooch            cool-to-warm shading
    Several are joined by +, printed one over the other.

    \b
    Examples:
      reflet sketch gooch+silhouette -o illustration.ktx2
      reflet shade teapot illustration.ktx2 --material map:view-normal -o teapot.png
      reflet sketch hatching --parameterization cube --size 512 -o 'hatching_{level}.png'
    """
    from reflet.cli.progress import progress_bar
    from reflet.pipelines.sketch import sketch_levels, write_sketch

    with progress_bar() as progress:
        progress("draw", 0, 1)
        files = write_sketch(output, sketch_levels(drawing, parameterization, size, seed))
        progress("draw", 1, 1)
    for file in files:
        click.echo(f"{file} is written.")
