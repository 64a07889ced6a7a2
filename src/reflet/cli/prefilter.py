"""``reflet prefilter``."""

from pathlib import Path

import click

from reflet.cli.options import PARAMETERIZATION, map_file_options
from reflet.cli.progress import progress_bar
from reflet.envmap.parameterizations.parameterization import Parameterization

TABLE = "table:"


@click.command(short_help="Filter an environment for glossy and diffuse materials, and for engines.")
@click.argument("source", metavar="ENV", type=click.Path(path_type=Path))
@click.option("--brdf", metavar="NAME[:VALUE]", help="What to filter with, see above.")
@click.option("--engine", type=click.Choice(["gltf", "filament"]), help="Make all that an engine needs, in a folder.")
@click.option(
    "--sh", type=click.Path(path_type=Path), metavar="FILE.json", help="Write spherical harmonics of order 2."
)
@click.option(
    "--parameterization",
    "to",
    type=PARAMETERIZATION,
    help="Of the filtered map; by default a cube in .ktx2, .ktx and .dds, latlong in pictures, octahedral for tables.",
)
@click.option("--size", type=int, help="Rows of a face; by default what suits the BRDF, of cubes 256 at most.")
@click.option("--levels", type=int, help="Number of levels by roughness; by default those down to 16 rows.")
@map_file_options
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    help="The file to write; with --engine and table:FILE the folder.",
)
def prefilter(
    source: Path,
    brdf: str | None,
    engine: str | None,
    sh: Path | None,
    to: Parameterization | None,
    size: int | None,
    levels: int | None,
    layout: str | None,
    mips: bool | None,
    texel_format: str | None,
    zstd: bool,
    source_is: Parameterization | None,
    output: Path | None,
) -> None:
    """Filters ENV, an environment map of any kind, once and for all directions, so that a renderer looks glossy and
    diffuse reflections up instead of integrating them.

    \b
    BRDFs:
      diffuse           irradiance/pi, looked up by the normal
      phong:50          Phong's lobe of this exponent, looked up by the mirrored direction
      ggx               mip levels by roughness, from a mirror's to roughness 1
      ggx:0.5           one perceptual roughness alone
      sheen, sheen:0.5  cloth, likewise
      table:FILE        any isotropic BRDF, measured or computed (docs/brdf_table.md): a folder of lobe maps

    \b
    Examples:
      reflet prefilter studio.hdr --engine gltf -o studio         diffuse, GGX and sheen for the glTF Sample Viewer
      reflet prefilter studio.hdr --engine filament -o studio     what Filament's cmgen makes, with skybox and sh.txt
      reflet prefilter studio.hdr --brdf ggx -o studio.ktx2
      reflet prefilter studio.hdr --brdf ggx -o 'studio_{level}.exr' --parameterization octahedral
      reflet prefilter studio.hdr --brdf phong:50 -o shiny.hdr --size 256
      reflet prefilter studio.hdr --brdf diffuse -o diffuse.ktx2 --sh studio.json
      reflet prefilter studio.hdr --brdf table:paint.npz -o paint
    """

    if not (brdf or engine or sh):
        raise click.UsageError("Say what to make: --brdf NAME, --engine NAME or --sh FILE.json.")
    if brdf and engine:
        raise click.UsageError("--engine makes all maps of its own; leave --brdf out.")
    if bool(brdf or engine) != bool(output):
        raise click.UsageError("Say where to write it: -o NAME." if brdf or engine else "-o needs --brdf or --engine.")
    if engine and (to, levels, layout, mips, texel_format, zstd) != (None, None, None, None, None, False):
        raise click.UsageError(
            "--engine knows how its files are made; of the other options it takes --size and --from."
        )
    written: list[str] = []
    with progress_bar() as progress:
        if sh:
            from reflet.pipelines.prefilter import harmonics

            harmonics(source, sh, source_is=source_is, progress=progress)
            written.append(f"{sh} is written.")
        if engine and output:
            from reflet.pipelines.engine_maps import engine_maps

            rows = 256 if size is None else size
            files = engine_maps(source, output, engine, size=rows, source_is=source_is, progress=progress)
            written += [f"{path} is written." for path in files]
        elif brdf and brdf.startswith(TABLE) and output:
            from reflet.pipelines.brdf_maps import brdf_maps

            if brdf == TABLE:
                raise click.UsageError("Say which table: --brdf table:FILE.npz.")
            if (levels, layout, mips) != (None, None, None):
                raise click.UsageError("A table's maps have neither levels nor a layout; leave these options out.")
            files = brdf_maps(
                source,
                brdf.removeprefix(TABLE),
                output,
                to=to,
                size=size,
                source_is=source_is,
                texel_format=texel_format,
                zstd=zstd,
                progress=progress,
            )
            written += [f"{path} is written." for path in files]
        elif brdf and output:
            from reflet.pipelines.prefilter import prefilter as prefilter_file

            made = prefilter_file(
                source,
                output,
                brdf,
                to=to,
                size=size,
                level_count=levels,
                source_is=source_is,
                layout=layout,
                mips=mips,
                texel_format=texel_format,
                zstd=zstd,
                progress=progress,
            )
            of_levels = f", {len(made)} levels by roughness" if len(made) > 1 else ""
            kind, rows = made[0].parameterization, made[0].size
            written.append(f"{output} is written: {kind}, {rows} rows a face{of_levels}.")
    for line in written:  # beneath the bars
        click.echo(line)
