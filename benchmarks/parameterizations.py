"""The bench scene baked in every parameterization, at about equal numbers of texels, and measured.

    .venv/bin/python benchmarks/parameterizations.py SCENE.glb FOLDER [--em-size N] [--image-size N] [--spp N]

SCENE.glb is the benchmark scene (docs/measurements.md says how it is seen). ``--em-size`` is the cube's edge; the others
have the power of two of rows that brings their texels nearest to the cube's. Each is baked into FOLDER/<name> (kept, if it
is there) and compared with ray tracing. Prints a row for each: rows and texels over the sphere in thousands, display PSNR
of the layered PEM and of its distant layer alone, seconds of inference a viewpoint.
"""

import argparse
import json
from pathlib import Path

import numpy as np

from reflet.bake import TIMINGS, bake
from reflet.compare import compare
from reflet.envmap.cube import CUBE
from reflet.envmap.parameterizations import PARAMETERIZATIONS
from reflet.envmap.sampling import valid_texels
from reflet.load import load_scene
from reflet.pem.container import open_pem
from reflet.scene.framing import frame_orbit
from reflet.scene.parameter_space import orbit_space

PLACES = ("sample", "between", "above-10")


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("scene", type=Path)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--em-size", type=int, default=128)
    parser.add_argument("--image-size", type=int, default=256)
    parser.add_argument("--spp", type=int, default=32)
    parser.add_argument("--only", nargs="*", default=list(PARAMETERIZATIONS))
    asked = parser.parse_args()
    scene = load_scene(asked.scene)
    orbit = frame_orbit(
        scene,
        azimuth_deg=60.0,
        elevation_deg=22.0,
        distance=1.25,
        target=(0.01, 0.15, 0.0),
        fov_deg=36.0,
        image_size=asked.image_size,
    )
    heading = "".join(f"{place:>20}" for place in PLACES)
    print(f"{'':22}{'rows':>6}{'texels':>8}{heading}{'seconds':>9}")
    for name in asked.only:
        density = valid_texels(PARAMETERIZATIONS[name])
        size = int(2 ** np.round(0.5 * np.log2(asked.em_size**2 * valid_texels(CUBE) / density)))
        folder = asked.folder / name
        if not (folder / "scene.gltf").exists():
            space = orbit_space(orbit, 3, 2.0)
            bake(scene, folder, space, parameterization=name, em_size=size, spp=asked.spp, resume=folder.exists())
        found = compare(open_pem(folder), rivals=False, images=folder / "images")
        values = (
            f"{found.result(place, 'layered').psnr_display:10.2f}{found.result(place, 'distant-only').psnr_display:10.2f}"
            for place in PLACES
        )
        timings = [json.loads(line) for line in (folder / TIMINGS).read_text().splitlines()]
        seconds = float(np.median([entry["infer_seconds"] for entry in timings]))
        print(f"{name:22}{size:6}{density * size**2 / 1000:8.0f}{''.join(values)}{seconds:9.1f}", flush=True)


if __name__ == "__main__":
    main()
