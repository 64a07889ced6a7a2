"""``reflet convert``."""

from pathlib import Path

import click

from reflet.cli.options import PARAMETERIZATION, from_option
from reflet.cli.progress import progress_bar


@click.command(short_help="Turn an environment map file into another kind.")
@click.argument("source", metavar="IN", type=click.Path(path_type=Path))
@click.argument("out", metavar="OUT", type=click.Path(path_type=Path))
@click.option("--to", type=PARAMETERIZATION, help="What to make of it; by default it stays what it is.")
@click.option("--size", type=int, help="Rows of a face; by default about as many texels as before.")
@click.option("--layout", metavar="LAYOUT", help="How the faces of a cube lie in a picture, such as horizontal-cross.")
@click.option("--mips/--no-mips", default=None, help="Store all mip levels; by default in .ktx2, .ktx and .dds.")
@from_option
def convert(
    source: Path,
    out: Path,
    to: str | None,
    size: int | None,
    layout: str | None,
    mips: bool | None,
    source_is: str | None,
) -> None:
    """Reads IN, resamples it with a filter that keeps its energy, and writes OUT.

    \b
    Examples:
      reflet convert studio.hdr studio.ktx2 --to cube
      reflet convert studio.hdr cross.exr --to cube --size 512 --layout horizontal-cross
      reflet convert probe.hdr studio.hdr --from angular --to latlong
      reflet convert faces.png small.dds --from cube --size 64
    """
    from reflet.convert import convert as convert_file
    from reflet.envmap.parameterizations import parameterization

    with progress_bar() as progress:
        image = convert_file(
            source,
            out,
            to=parameterization(to) if to else None,
            size=size,
            layout=layout,
            source_is=parameterization(source_is) if source_is else None,
            mips=mips,
            progress=progress,
        )
    click.echo(f"{out} is written: {image.parameterization}, {image.size} rows a face.")
