"""Pictures of the viewer: .venv/bin/python tools/viewer_picture.py SCENE docs/viewer.png [SETTINGS]

Opens a scene's folder, a PEM's or the one named scene that ``reflet view --export`` wrote, in headless Chromium, which
draws by software: seconds a frame. SETTINGS (JSON) are those of docs/viewer.md, "For scripts".
"""

import subprocess
import sys
from pathlib import Path

from reflet.view.server import viewer_server

WEB = Path(__file__).parents[1] / "web"

if __name__ == "__main__":
    scene, out, *settings = sys.argv[1:]
    with viewer_server(scene) as address:
        subprocess.run(["node", WEB / "test/screenshot.mjs", address, Path(out).absolute(), *settings], check=True)
