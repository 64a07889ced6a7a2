"""What ``make demo`` shows: the built-in scene baked small, beside ray tracing and older methods, put on a page.

Run it with the folder to write to::

    python examples/demo.py out

It calls the command line, so each step can be repeated by hand, larger.
"""

import shutil
import sys
from pathlib import Path

from reflet.cli.main import main as reflet


def run(*arguments: str | Path) -> None:
    """One command, echoed first; ends here if it fails."""
    words = [str(argument) for argument in arguments]
    print("reflet " + " ".join(words), flush=True)
    try:
        reflet(words)
    except SystemExit as done:
        if done.code:
            raise


def main(out: Path) -> None:
    """Bakes, compares and draws into ``out``."""
    pem, figure, page = out / "teapot", out / "comparison.png", out / "teapot.html"
    shutil.rmtree(pem, ignore_errors=True)
    run("bake", "teapot-room", "--image-size", "256", "--em-size", "128", "--spp", "32", "--out", pem)
    run("compare", pem, "--spp", "64", "--samples", "16", "--figure", figure, "--page", page,
        "--json", out / "comparison.json")  # fmt: skip
    print(f"\nThe figure is {figure}, the page {page}.\nOpen the viewer with: .venv/bin/reflet view {pem}")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
