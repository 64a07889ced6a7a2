"""``reflet render``."""

from pathlib import Path

import click

from reflet.cli.options import asked_samples, pem_argument, samples_option
from reflet.cli.progress import progress_bar


@click.command(short_help="Draw one view of a PEM into a picture.")
@pem_argument
@click.option("--azimuth", type=float, help="Degrees; by default that of the first viewpoint, or of the orbit.")
@click.option("--elevation", type=click.FloatRange(-90, 90), help="Degrees; by default that of the baked orbit.")
@click.option("--distance", type=float, help="Metres from the target; by default that of the baked orbit.")
@click.option("--nearest", is_flag=True, help="Show the maps of the nearest viewpoint instead of a blend.")
@click.option("--by-origin", is_flag=True, help="Colour mirrored light by where it comes from.")
@samples_option("adaptive")
@click.option("--size", type=click.IntRange(1), help="Pixels along an edge; by default as baked.")
@click.option("-o", "--output", type=click.Path(path_type=Path), required=True, help="The .png or .exr to write.")
def render(
    pem: Path,
    azimuth: float | None,
    elevation: float | None,
    distance: float | None,
    nearest: bool,
    by_origin: bool,
    samples: str,
    size: int | None,
    output: Path,
) -> None:
    """Draws PEM as the viewer does at rest, without a window: on a viewpoint, between two, or anywhere off the orbit.

    A .png holds the tone-mapped picture, an .exr linear radiance. With --by-origin what is mirrored is orange where it
    comes from the object's own mesh, blue from the last shell of the surroundings, green and yellow from nearer ones.

    \b
    Examples:
      reflet render teapot -o first.png
      reflet render teapot --azimuth 61 --elevation 32 -o above.png
      reflet render teapot --by-origin -o origins.png
      reflet render teapot --azimuth 61 --nearest --samples 4 --size 1024 -o moving.exr
    """
    from dataclasses import replace

    from reflet.errors import RefletError
    from reflet.files.atomic import check_writable
    from reflet.files.pictures.exr import write_exr
    from reflet.files.pictures.png import write_png
    from reflet.pem.container import open_pem
    from reflet.render.playback.renderer import Renderer
    from reflet.report.measures import picture_srgb

    if output.suffix.lower() not in (".png", ".exr"):
        raise RefletError(f"A picture is a .png or an .exr, not {output.name}.")
    with progress_bar() as progress:
        progress("read", 0, 1)
        opened = open_pem(pem)
        progress("read", 1, 1)
    check_writable(output)
    orbit = opened.space.orbit if size is None else replace(opened.space.orbit, image_size=size)
    point = next(iter(opened.space.points()), {})
    given = {"azimuth_deg": azimuth, "elevation_deg": elevation, "distance": distance}
    point.update({axis: value for axis, value in given.items() if value is not None})
    with progress_bar() as progress:
        progress("draw", 0, 2)
        renderer = Renderer(opened)
        progress("draw", 1, 2)
        frame = renderer.frame(
            orbit.camera(point), samples=asked_samples(samples), blend=not nearest, by_origin=by_origin
        )
        progress("draw", 2, 2)
    picture = frame[..., :3]
    if output.suffix.lower() == ".png":
        write_png(output, picture_srgb(picture))
    else:
        write_exr(output, picture)
    click.echo(f"{output} is written.")
