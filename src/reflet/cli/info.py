"""``reflet info``."""

from pathlib import Path

import click

from reflet.cli.options import pem_argument


@click.command(short_help="Say what a PEM holds and how its inference went.")
@pem_argument
def info(pem: Path) -> None:
    """Prints what PEM holds: viewpoints, layers with their geometries, sizes, and how well inference went.

    \b
    Example:
      reflet info teapot
    """
    from reflet.pem.container import open_pem
    from reflet.report.table import pem_table

    click.echo(pem_table(open_pem(pem)))
