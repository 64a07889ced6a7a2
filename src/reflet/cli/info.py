"""``reflet info``."""

from pathlib import Path

import click

from reflet.cli.options import from_option


@click.command(short_help="Say what a PEM or an environment map file holds.")
@click.argument("path", metavar="PEM|FILE", type=click.Path(path_type=Path))
@from_option
def info(path: Path, source_is: str | None) -> None:
    """Prints what is in a PEM's folder, or in the file of an environment map.

    Of a PEM: viewpoints, layers with their geometries, sizes, and how well inference went. Of a file: kind, size,
    range of radiance, its integral over all directions, how much of it comes from the brightest 0.01 % of them, from
    where; and a small picture if the terminal has the colours.

    \b
    Examples:
      reflet info teapot
      reflet info studio.hdr
      reflet info probe.exr --from angular
    """
    from rich.console import Console

    if path.is_dir():
        from reflet.pem.container import open_pem
        from reflet.report.table import pem_table

        click.echo(pem_table(open_pem(path)))
        return
    from reflet.envmap.parameterizations import parameterization
    from reflet.files.env_image_file import read_levels
    from reflet.report.env_image_table import env_image_table
    from reflet.report.terminal_picture import terminal_picture

    levels = read_levels(path, parameterization(source_is) if source_is else None)
    console = Console()
    if console.is_terminal and console.color_system in ("truecolor", "256"):
        console.print(terminal_picture(levels[0], min(console.width, 96)), end="")
    click.echo(env_image_table(levels))
