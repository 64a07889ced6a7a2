"""``reflet view``."""

from pathlib import Path

import click

from reflet.cli.options import pem_argument


@click.command(short_help="Look at a PEM in the browser.")
@pem_argument
@click.option("--port", type=click.IntRange(0, 65535), default=0, help="Port on this machine; 0 takes a free one.")
@click.option("--no-browser", is_flag=True, help="Print the address only.")
def view(pem: Path, port: int, no_browser: bool) -> None:
    """Serves PEM and the viewer to this machine alone, and opens the browser. Ctrl-C ends it.

    \b
    Examples:
      reflet view teapot
      reflet view teapot --port 8000 --no-browser
    """
    from reflet.view.server import serve

    serve(pem, port=port, open_browser=not no_browser)
