"""``reflet sampling``."""

from pathlib import Path

import click

from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS


@click.command(short_help="Say how evenly each parameterization samples the sphere.")
@click.option("--figure", type=click.Path(path_type=Path), metavar="FILE", help="Draw it here (.png).")
def sampling(figure: Path | None) -> None:
    """Prints how many texels a steradian and a radian each parameterization has, over a map that spreads them evenly.

    Cost is how many times the texels of an even map it takes to resolve as much in all directions along every axis.

    \b
    Examples:
      reflet sampling
      reflet sampling --figure sampling.png
    """
    from reflet.envmap.sampling import analyze
    from reflet.errors import RefletError
    from reflet.report.sampling_figure import sampling_table, write_sampling_figure

    if figure is not None and figure.suffix.lower() != ".png":
        raise RefletError(f"A figure is a .png, not {figure.name}.")
    rates = [analyze(each) for each in PARAMETERIZATIONS.values()]
    if figure is not None:
        write_sampling_figure(figure, rates)
    click.echo(sampling_table(rates))
