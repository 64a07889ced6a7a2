"""Draws frames of PEMs on another graphics driver than this process has: run with VK_DRIVER_FILES set.

``draw_frames.py FOLDER REQUESTS.json OUT.npz``; a request names a PEM in FOLDER, with or without the geometry of its
distant layers, and has width, height, viewpoint and arguments of `Renderer.frame`; samples [first, most] are
`Adaptive`.
"""

import json
import sys
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np

from reflet.envmap.geometry import InfiniteSphere
from reflet.pem.container import open_pem
from reflet.render.device.device import shared_device
from reflet.render.playback.renderer import Renderer
from reflet.scene.views.sample_pattern import Adaptive


@cache
def renderer(folder: Path, infinite: bool) -> Renderer:
    """A PEM's renderer, its distant layers infinitely far if asked."""
    pem = open_pem(folder)
    if infinite:
        far = [replace(layer, geometry=InfiniteSphere()) if layer.kind == "distant" else layer for layer in pem.layers]
        pem = replace(pem, layers=tuple(far))
    return Renderer(pem)


if __name__ == "__main__":
    frames = {}
    for name, request in json.loads(Path(sys.argv[2]).read_text()).items():
        drawing, point = renderer(Path(sys.argv[1]) / request["pem"], request["infinite"]), request["viewpoint"]
        camera = replace(drawing.pem.space.orbit.camera(point), width=request["width"], height=request["height"])
        samples = request["arguments"]["samples"]
        asked = Adaptive(*samples) if isinstance(samples, list) else samples
        frames[name] = drawing.frame(camera, point=point, **{**request["arguments"], "samples": asked})
    np.savez(sys.argv[3], adapter=shared_device().adapter.info["device"], **frames)
