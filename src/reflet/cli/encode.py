"""``reflet encode``."""

from pathlib import Path

import click

from reflet.cli.options import codec_option, pem_argument
from reflet.pem.layout import Codec


@click.command(short_help="Write a PEM again, its maps coded or not.")
@pem_argument
@codec_option
@click.option("-o", "--out", type=click.Path(path_type=Path), required=True, help="Folder to write the PEM to.")
def encode(pem: Path, codec: Codec, out: Path) -> None:
    """Writes the PEM of one folder into another, maps and environment coded as asked.

    By av1 they take about a thirtieth; by none they are half floats in KTX2, for engines, and floats: of a PEM that is
    coded, what was decoded. Each time that maps are coded they lose a little.

    \b
    Examples:
      reflet encode teapot -o small
      reflet encode teapot --codec none -o plain
    """
    from reflet.pem.container import open_pem, save_pem
    from reflet.pem.folder_facts import folder_facts

    save_pem(out, open_pem(pem), codec=codec)
    click.echo(f"{out} takes {sum(folder_facts(out).sizes.values()) / 1e6:.2f} MB.")
