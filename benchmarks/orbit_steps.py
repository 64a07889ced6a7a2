"""Popping and swimming: an orbit in steps of a tenth of a degree, frame to frame, beside ray tracing.

    python benchmarks/orbit_steps.py SCENE FOLDER [--environment HDR] [--steps 40] [--samples 16] [--video]

Bakes the scene into FOLDER by default options, and the paper's way (a box, ellipsoids, three viewpoints 2° apart), and
goes on with bakes that are there. The camera then passes those viewpoints. What changes from each frame to the next is
compared with what changes in the ray-traced one, on the object's pixels of both: mean squares of the difference of
differences, as display PSNR. All frames of the reference have the same random numbers in a pixel; what a second set of
them makes of it is the noise. Beside them is the true light at just the samples of playback, 16 or 64 a pixel: calmer
than this no map can make a picture but by blurring it. --video also writes FOLDER/orbit.webp, an endless loop: ray
traced, traced, layered, and under each what is wrong with it, eight times as much.
"""

import argparse
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
from PIL import Image

from reflet.pem.container import open_pem
from reflet.pem.pem import ParameterizedEnvironmentMap
from reflet.pipelines.bake import bake
from reflet.pipelines.compare import straight
from reflet.pipelines.load import load_scene
from reflet.render.playback.renderer import Renderer
from reflet.report.measures import SquaredError, tone_map
from reflet.scene.scene import Scene
from reflet.scene.views.camera import Camera
from reflet.scene.views.framing import frame_orbit
from reflet.scene.views.parameter_space import Orbit, orbit_space
from reflet.trace.compose import object_radiance
from reflet.trace.tracer import Tracer

STEP_DEG, VIEWS, SPACING_DEG = 0.1, 3, 2.0
SHOWN_ERROR = 8.0


def baked(scene: Scene, folder: Path, orbit: Orbit, em_size: int) -> dict[str, ParameterizedEnvironmentMap]:
    ways = {
        "traced": (orbit_space(orbit, 0, SPACING_DEG), {}),
        "layered": (orbit_space(orbit, VIEWS, SPACING_DEG), {"distant": "box", "local": "ellipsoid"}),
    }
    pems = {}
    for name, (space, options) in ways.items():
        bake(scene, folder / name, space, em_size=em_size, resume=(folder / name).exists(), **options)
        pems[name] = open_pem(folder / name)
    return pems


def frames(pems: dict[str, ParameterizedEnvironmentMap], cameras: list[Camera], spp: int, samples: int | str
           ) -> Iterator[dict[str, np.ndarray]]:  # fmt: skip
    """Display values of each step by method, zero off the object."""
    traced = pems["traced"]
    tracer = Tracer(traced.scene, irradiance=traced.irradiance, through=traced.traced_parts)
    renderers = {name: Renderer(pem) for name, pem in pems.items()}
    for camera in cameras:
        radiance, coverage = object_radiance(tracer.view(camera, spp=spp, sample_count=1, seed=1).layers)
        again, _ = object_radiance(tracer.view(camera, spp=spp, sample_count=1, seed=2).layers)
        at_16, at_64 = (
            object_radiance(tracer.view(camera, spp=count, sample_count=1, seed=None).layers)[0] for count in (16, 64)
        )
        inside = (coverage > 0.5)[..., None]
        shown = {name: straight(each.frame(camera, what="object", samples=samples)) for name, each in renderers.items()}
        pictures = {"reference": radiance, "noise": again, "true at 16": at_16, "true at 64": at_64, **shown}
        yield {name: np.where(inside, tone_map(picture), 0.0) for name, picture in pictures.items()} | {"in": inside}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene")
    parser.add_argument("folder", type=Path)
    parser.add_argument("--environment")
    parser.add_argument("--steps", type=int, default=40)
    parser.add_argument("--samples", default="16")
    parser.add_argument("--spp", type=int, default=256)
    parser.add_argument("--image-size", type=int, default=512)
    parser.add_argument("--em-size", type=int, default=256)
    parser.add_argument("--video", action="store_true")
    asked = parser.parse_args()
    scene = load_scene(asked.scene, environment=asked.environment)
    orbit = replace(frame_orbit(scene), image_size=asked.image_size)
    pems = baked(scene, asked.folder, orbit, asked.em_size)
    first = pems["layered"].space.axes[0].values[0]
    cameras = [orbit.camera({"azimuth_deg": first + STEP_DEG * step}) for step in range(asked.steps + 1)]
    samples = int(asked.samples) if asked.samples.isdigit() else asked.samples

    wrong = dict.fromkeys(("traced", "layered", "true at 16", "true at 64", "noise"), SquaredError())
    worst = dict.fromkeys(wrong, 0.0)
    film, before = [], None
    for now in frames(pems, cameras, asked.spp, samples):
        if before is not None:
            both = (now["in"] & before["in"])[..., 0]
            change = now["reference"] - before["reference"]
            for name in wrong:
                error = (now[name] - before[name] - change)[both]
                wrong[name] += SquaredError(float((error**2).sum()), error.size)
                worst[name] = max(worst[name], float((error**2).mean()))
        before = now
        if asked.video:
            film.append(_strip(now))
    for name, error in wrong.items():
        psnr = error.psnr + (3.01 if name == "noise" else 0.0)  # of the difference of two that are noisy alike
        print(f"{name:10}{psnr:8.2f} dB frame to frame, worst step {-10.0 * np.log10(worst[name]):6.2f}", flush=True)
    if asked.video:
        there_and_back = [Image.fromarray(picture) for picture in (*film, *film[-2:0:-1])]
        there_and_back[0].save(
            asked.folder / "orbit.webp",
            save_all=True,
            append_images=there_and_back[1:],
            duration=50,
            loop=0,
            quality=90,
        )


def _strip(now: dict[str, np.ndarray]) -> np.ndarray:
    """The methods side by side, their errors below."""
    names = ("reference", "traced", "layered")
    above = np.concatenate([now[name] for name in names], 1)
    below = np.concatenate([SHOWN_ERROR * np.abs(now[name] - now["reference"]) for name in names], 1)
    return np.round(255.0 * np.clip(np.concatenate([above, below]), 0.0, 1.0)).astype(np.uint8)


if __name__ == "__main__":
    main()
