"""``reflet convert``."""

from pathlib import Path

import click

from reflet.cli.options import PARAMETERIZATION, layer_option, map_file_options, up_option
from reflet.cli.progress import progress_bar
from reflet.envmap.parameterizations.parameterization import Parameterization


@click.command(short_help="Turn an environment map file into another kind.")
@click.argument("source", metavar="IN", type=click.Path(path_type=Path))
@click.argument("out", metavar="OUT", type=click.Path(path_type=Path))
@click.option("--to", type=PARAMETERIZATION, help="What to make of it; by default it stays what it is.")
@click.option("--size", type=int, help="Rows of a face; by default about as many texels as before.")
@click.option(
    "--turn", type=float, default=0.0, help="Degrees to turn it about the vertical, counter-clockwise from above."
)
@up_option
@click.option("--scale", type=float, default=1.0, help="A number to multiply its radiance by.")
@click.option(
    "--repair", is_flag=True, help="Put right what is not a number, infinite or negative, and say where it was."
)
@layer_option
@map_file_options
def convert(
    source: Path,
    out: Path,
    to: Parameterization | None,
    size: int | None,
    turn: float,
    up: str,
    scale: float,
    repair: bool,
    layer: str | None,
    layout: str | None,
    mips: bool | None,
    texel_format: str | None,
    zstd: bool,
    source_is: Parameterization | None,
) -> None:
    """Reads IN, resamples it with a filter that keeps its energy, and writes OUT.

    Formats go by suffix: .hdr .exr .png .jpg .ktx2 .ktx .dds. Six files of a cube are a folder, any one
    of them, or a name with {face} in it, which stands for px nx py ny pz nz.

    \b
    Examples:
      reflet convert studio.hdr studio.ktx2 --to cube
      reflet convert studio.hdr studio.ktx2 --to octahedral --size 512 --texel-format rgb9e5 --zstd
      reflet convert studio.hdr cross.exr --to cube --size 512 --layout horizontal-cross
      reflet convert studio.hdr 'sky_{face}.png' --to cube
      reflet convert probe.hdr studio.exr --from angular --to latlong
      reflet convert render.exr studio.hdr --layer ViewLayer.Combined
      reflet convert broken.exr sound.exr --repair
      reflet convert physical.exr studio.hdr --scale 1e-3  to where white is about 1
      reflet convert studio.hdr turned.hdr --turn 90      what looked along +x then looks along -z
      reflet convert sky.dds upright.dds --up z           made where +z points up: +z becomes +y
    """
    from reflet.pipelines.convert import convert as convert_file

    with progress_bar() as progress:
        image = convert_file(
            source,
            out,
            to=to,
            size=size,
            source_is=source_is,
            turn_deg=turn,
            up=up,
            scale=scale,
            repair=repair,
            layer=layer,
            layout=layout,
            mips=mips,
            texel_format=texel_format,
            zstd=zstd,
            progress=progress,
        )
    click.echo(f"{out} is written: {image.parameterization}, {image.size} rows a face.")
