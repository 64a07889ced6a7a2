"""``reflet verify``."""

from pathlib import Path

import click

from reflet.cli.options import pem_argument
from reflet.cli.progress import progress_bar


@click.command(short_help="Check that the graphics system does what inference believed.")
@pem_argument
@click.option("--json", "json_path", type=click.Path(path_type=Path), metavar="FILE", help="Write the result here.")
def verify(pem: Path, json_path: Path | None) -> int:
    """Measures the rendering matrix of PEM's first view with coloured test renderings on the adapter present, and
    compares it with the analytic one that the maps were inferred with; and where mirrored rays are traced at playback,
    what they meet with what the ray tracer meets. Ends with status 1 where they disagree.

    \b
    Example:
      reflet verify teapot --json verify.json
    """
    import json
    from dataclasses import asdict

    from reflet.files.atomic import atomic_write, check_writable
    from reflet.pem.container import open_pem
    from reflet.pipelines.verify import verify as verify_pem

    with progress_bar() as progress:
        progress("read", 0, 1)
        opened = open_pem(pem)
        progress("read", 1, 1)
        if json_path:
            check_writable(json_path)
        verification = verify_pem(opened, progress=progress)
    click.echo(str(verification))  # first: a file that cannot be written after all does not take it along
    if json_path:
        atomic_write(json_path, (json.dumps(asdict(verification), indent=1) + "\n").encode())
    return 0 if verification.agrees else 1
