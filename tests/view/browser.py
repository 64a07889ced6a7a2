"""Running the built viewer in headless Chromium, and the renderer on Chromium's own rasterizer, for the tests here."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from reflet.errors import RefletError
from reflet.view.static_files import viewer_folder

ROOT = Path(__file__).parents[2]
CHROMIUM = os.environ.get("CHROMIUM", "/usr/bin/chromium")
# Chromium's own software rasterizer, for the Python side too: the same machine code draws both.
SWIFTSHADER = Path("/usr/lib/chromium/vk_swiftshader_icd.json")


def need_built_viewer():
    """Skips where Chromium, Node.js or the built viewer is missing; fails where the viewer is out of date."""
    if not shutil.which(CHROMIUM) or not shutil.which("node"):
        pytest.skip("needs Chromium and Node.js")
    try:
        built = (viewer_folder() / "index.html").stat().st_mtime
    except RefletError:
        pytest.skip("the viewer is not built; run: make web")
    sources = [
        ROOT / "web/index.html",
        *ROOT.glob("web/public/*"),
        *ROOT.glob("web/src/**/*"),
        *ROOT.glob("src/reflet/shaders/*.wgsl"),
    ]
    assert built > max(path.stat().st_mtime for path in sources), "the viewer is older than its sources; run: make web"


def drive(script, *arguments):
    """Runs a script of web/test."""
    command = ["node", ROOT / "web/test" / script, *arguments]
    done = subprocess.run(command, capture_output=True, text=True, timeout=900, check=False)
    assert done.returncode == 0, done.stderr


def draw(script, folder, requests, out):
    """Runs a script of this folder on Chromium's rasterizer; the frames it wrote."""
    if not SWIFTSHADER.exists():
        pytest.skip("this Chromium brings no SwiftShader that Vulkan programs can load")
    command = [sys.executable, ROOT / "tests/view" / script, folder, requests, out]
    environment = {**os.environ, "VK_DRIVER_FILES": str(SWIFTSHADER)}
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=900, check=False)
    assert done.returncode == 0, done.stderr
    frames = np.load(out)
    assert "SwiftShader" in str(frames["adapter"])
    return frames
