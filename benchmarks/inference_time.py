"""Seconds to infer all layers of one viewpoint, in one run with the trace it follows.

`python benchmarks/inference_time.py [SCENE] [--image-size N] [--em-size N] [--spp N] [--repeat N]`; without a scene the
built-in teapot room. Everything runs once to compile and is then repeated; medians are printed as JSON: wall seconds,
and processor seconds, which other work on the machine hardly changes.
"""

import argparse
import json
import statistics
import time
from dataclasses import replace

from reflet.envmap.mip_chain import MipChain
from reflet.infer.fit_geometry import em_origin, fit
from reflet.infer.infer_layer import infer_layer
from reflet.pipelines.baking.base_maps import LOD_BIASES
from reflet.pipelines.load import load_scene
from reflet.scene.surfaces.hull import hull_triangles
from reflet.scene.surfaces.surface import gbuffer_from_visibility
from reflet.scene.views.framing import frame_orbit
from reflet.trace.layers import Shells
from reflet.trace.tracer import Tracer


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scene", nargs="?", default="teapot-room")
    parser.add_argument("--image-size", type=int, default=512)
    parser.add_argument("--em-size", type=int, default=256)
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--repeat", type=int, default=3)
    asked = parser.parse_args()

    scene = load_scene(asked.scene)
    tracer = Tracer(scene)
    on_hull = hull_triangles(scene)
    item = scene.objects[0]
    probe = tracer.probe(0, Shells(em_origin(scene, item.parts)), size=asked.em_size, spp=4)
    box = fit("box", scene, item.parts, probe)
    ellipsoids = {part: fit("ellipsoid", scene, (part,)) for part in item.parts}
    chain, small = MipChain(asked.em_size), MipChain(asked.em_size // 2)
    orbit = replace(frame_orbit(scene), image_size=asked.image_size)

    runs: dict[str, list[tuple[float, float]]] = {"trace": [], "gbuffer": [], "distant": [], "local": []}
    for _ in range(asked.repeat + 1):
        mark = time.perf_counter(), time.process_time()

        def lap(stage: str) -> None:
            nonlocal mark
            now = time.perf_counter(), time.process_time()
            runs[stage].append((now[0] - mark[0], now[1] - mark[1]))
            mark = now

        view = tracer.view(orbit.camera(), spp=asked.spp)
        lap("trace")
        gbuffer = gbuffer_from_visibility(scene, view.visibility)
        lap("gbuffer")
        infer_layer("distant", gbuffer, view.layers, item.parts, box, chain, LOD_BIASES["none"], prior=probe.texels)
        lap("distant")
        for part, ellipsoid in ellipsoids.items():
            infer_layer("local", gbuffer, view.layers, (part,), ellipsoid, small, LOD_BIASES["none"], on_hull=on_hull)
        lap("local")
    medians = {
        stage: {
            "wall_s": round(statistics.median(wall for wall, _ in laps[1:]), 3),
            "processor_s": round(statistics.median(used for _, used in laps[1:]), 3),
        }
        for stage, laps in runs.items()
    }
    print(json.dumps({"scene": asked.scene, "sub_samples": len(gbuffer.triangle), "parts": len(item.parts), **medians}))


if __name__ == "__main__":
    main()
