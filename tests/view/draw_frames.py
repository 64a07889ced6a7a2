"""Draws frames of a PEM on another graphics driver than this process has: run with VK_DRIVER_FILES set.

``draw_frames.py PEM REQUESTS.json OUT.npz``; a request has width, height, viewpoint and arguments of `Renderer.frame`.
"""

import json
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from reflet.envmap.geometry import InfiniteSphere
from reflet.pem.container import open_pem
from reflet.render.device import shared_device
from reflet.render.renderer import Renderer

if __name__ == "__main__":
    pem = open_pem(sys.argv[1])
    layers = tuple(
        replace(layer, geometry=InfiniteSphere()) if layer.kind == "distant" else layer for layer in pem.layers
    )
    renderers = {False: Renderer(pem), True: Renderer(replace(pem, layers=layers))}
    frames = {}
    for name, request in json.loads(Path(sys.argv[2]).read_text()).items():
        point = request["viewpoint"]
        camera = replace(pem.space.orbit.camera(point), width=request["width"], height=request["height"])
        renderer = renderers[request.get("infinite", False)]
        frames[name] = renderer.frame(camera, point=point, **request["arguments"])
    np.savez(sys.argv[3], adapter=shared_device().adapter.info["device"], **frames)
