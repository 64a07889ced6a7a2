"""Seconds per viewpoint: the segmented trace against a full path traced picture of the same view, in one run.

`python benchmarks/trace_time.py [SCENE.xml|.glb] [--azimuth DEG] [--image-size N] [--spp N] [--repeat N]`; without a
scene the built-in teapot room. Each is run once to compile, then repeated in turns; the medians are printed as JSON.
The path tracer is Mitsuba's own (depth 6) and, for an XML file, runs on the file's own BSDFs.
"""

import argparse
import json
import statistics
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np

from reflet.pipelines.load import load_scene
from reflet.scene.views.camera import Camera
from reflet.scene.views.framing import frame_orbit
from reflet.trace.mitsuba_files.mitsuba_xml import read_mitsuba_orbit
from reflet.trace.references.path_reference import PathReference
from reflet.trace.tracer import Tracer

DEPTH = 6


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scene", nargs="?", default="teapot-room")
    parser.add_argument("--azimuth", type=float, default=60.0)
    parser.add_argument("--image-size", type=int, default=512)
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--repeat", type=int, default=3)
    asked = parser.parse_args()

    scene = load_scene(asked.scene)
    is_xml = Path(asked.scene).suffix == ".xml"
    orbit = read_mitsuba_orbit(asked.scene, scene) if is_xml else frame_orbit(scene)
    start = time.perf_counter()
    tracer = Tracer(scene)
    irradiance_s = time.perf_counter() - start
    stock = mi.load_file(asked.scene) if is_xml else None
    reference = PathReference(scene)

    def camera(turn: int) -> Camera:
        point = {"azimuth_deg": asked.azimuth + 2.0 * turn}
        return replace(orbit, image_size=asked.image_size).camera(point)

    def path_traced(turn: int) -> np.ndarray:
        sensor, integrator = reference.sensor(camera(turn), asked.spp), {"type": "path", "max_depth": DEPTH}
        built = stock if stock is not None else reference.scene
        return np.asarray(mi.render(built, sensor=sensor, integrator=mi.load_dict(integrator), spp=asked.spp))

    seconds: dict[str, list[float]] = {"segmented": [], "path": []}
    covered = 0.0
    for turn in range(asked.repeat + 1):
        start = time.perf_counter()
        view = tracer.view(camera(turn), spp=asked.spp)
        middle = time.perf_counter()
        path_traced(turn)
        end = time.perf_counter()
        covered = float(view.layers.coverage.sum()) / asked.image_size**2
        if turn:
            seconds["segmented"].append(middle - start)
            seconds["path"].append(end - middle)
    segmented, path = (statistics.median(seconds[name]) for name in ("segmented", "path"))
    result: dict[str, Any] = {
        "scene": Path(asked.scene).name,
        "image_size": asked.image_size,
        "spp": asked.spp,
        "object_share": round(covered, 3),
        "irradiance_s": round(irradiance_s, 2),
        "segmented_s": round(segmented, 3),
        "path_s": round(path, 3),
        "ratio": round(segmented / path, 3),
    }
    print(json.dumps(result, indent=2))


if __name__ == "__main__":
    main()
