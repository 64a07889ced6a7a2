"""The README's picture of the viewer: .venv/bin/python tools/viewer_picture.py PEM docs/viewer.png

Opens the PEM in headless Chromium, which draws by software: minutes, not seconds.
"""

import subprocess
import sys
from pathlib import Path

from reflet.view.server import viewer_server

WEB = Path(__file__).parents[1] / "web"

if __name__ == "__main__":
    pem, out = sys.argv[1:]
    with viewer_server(pem) as address:
        subprocess.run(["node", WEB / "test/screenshot.mjs", address, Path(out).absolute()], check=True)
