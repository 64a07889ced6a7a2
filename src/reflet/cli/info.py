"""``reflet info``."""

from pathlib import Path

import click

from reflet.cli.options import from_option, layer_option
from reflet.envmap.parameterizations.parameterization import Parameterization
from reflet.errors import RefletError


@click.command(short_help="Say what a PEM, an environment map or a BRDF table holds.")
@click.argument("path", metavar="PEM|FILE", type=click.Path(path_type=Path))
@from_option
@layer_option
def info(path: Path, source_is: Parameterization | None, layer: str | None) -> None:
    """Prints what is in a PEM's folder, or in the file of an environment map or a BRDF table.

    Of a PEM: viewpoints, layers with their geometries, sizes, how well inference went, what its maps are coded by, and
    the bytes of its files by kind. Of a file: kind, size,
    range of radiance, its integral over all directions, how much of it comes from the brightest 0.01 % of them, from
    where; and a small picture if the terminal has the colours. Azimuth 0 is +x, 90 is -z. Of a BRDF's table: its
    angles, how far it is from reciprocal, its albedo, and what prefiltered maps can show of it with one and more lobes.

    \b
    Examples:
      reflet info teapot
      reflet info studio.hdr
      reflet info probe.exr --from angular
      reflet info render.exr --layer ViewLayer.Combined
      reflet info satin.npz
    """
    no_cube = _why_no_cube(path) if path.is_dir() else None
    if no_cube is not None or path.suffix.lower() == ".gltf":
        from reflet.pem import layout
        from reflet.pem.container import open_pem
        from reflet.pem.folder_facts import folder_facts
        from reflet.report.table import pem_table

        if path.is_dir() and not any((path / name).exists() for name in (layout.SCENE, layout.PARAMETERS)):
            raise RefletError(f"{path} holds neither a PEM nor six files of a cube: {no_cube}")
        folder = path if path.is_dir() else path.parent
        click.echo(pem_table(open_pem(path), folder_facts(folder)))
    elif not path.suffix and not path.exists():
        raise RefletError(f"{path} does not exist; give a PEM's folder, or a file.")
    elif path.suffix.lower() == ".npz":
        _tell_of_brdf(path)
    else:
        _tell_of_map(path, source_is, layer)


def _why_no_cube(folder: Path) -> RefletError | None:
    from reflet.files.pictures.picture_file import READ
    from reflet.files.pictures.six_files import six_files

    try:
        six_files(folder, READ)
    except RefletError as error:
        return error
    return None


def _tell_of_map(path: Path, source_is: Parameterization | None, layer: str | None) -> None:
    from rich.console import Console

    from reflet.cli.progress import progress_bar
    from reflet.files.env_image_file import file_facts, read_levels
    from reflet.report.env_image_table import env_image_table
    from reflet.report.terminal_picture import terminal_picture

    console = Console()
    picture = None
    with progress_bar() as progress:
        progress("read", 0, 1)
        levels = read_levels(path, source_is, layer=layer)
        progress("read", 1, 1)
        progress("measure", 0, 1)
        if console.is_terminal and not console.no_color and console.color_system in ("truecolor", "256"):
            picture = terminal_picture(levels[0], min(console.width, 96))
        table = env_image_table(file_facts(path, layer), levels)
        progress("measure", 1, 1)
    if picture is not None:
        console.print(picture, end="")
    click.echo(table)


def _tell_of_brdf(path: Path) -> None:
    from reflet.files.measured_brdf_file import read_measured_brdf
    from reflet.reflectance.lobes.brdf_facts import brdf_facts
    from reflet.report.brdf_table import brdf_table

    table = read_measured_brdf(path)
    click.echo(brdf_table(table, brdf_facts(table)))
