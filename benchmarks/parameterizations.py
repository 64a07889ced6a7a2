"""The bench scene baked in every parameterization, at about equal numbers of texels, and measured.

    .venv/bin/python benchmarks/parameterizations.py SCENE.glb FOLDER [--em-size N] [--image-size N] [--spp N]

SCENE.glb is the benchmark scene (docs/measurements.md says how it is seen). ``--em-size`` is the cube's edge; the
others have the power of two of rows that brings their texels nearest to the cube's. Each is baked into FOLDER/<name>
(kept, if it is there) and compared with ray tracing at 256 samples a pixel, as `reflet compare` does; pictures
(reference, layered, distant alone) go to FOLDER/<name>-<place>.png. Prints a row for each: rows, and texels over the
sphere in thousands; display PSNR of the layered PEM and of its distant layer alone at each place; seconds of inference
a viewpoint.
"""

import argparse
import json
from pathlib import Path

import numpy as np

from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS
from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.resampling.equal_sampling import equal_sampling_size
from reflet.envmap.sampling import valid_texels
from reflet.files.pictures.png import write_png
from reflet.pem.container import open_pem
from reflet.pem.pem import ParameterizedEnvironmentMap
from reflet.pipelines.bake import bake
from reflet.pipelines.baking.timings import TIMINGS
from reflet.pipelines.compare import REFERENCE_SEED, object_radiance, object_under_distant, straight
from reflet.pipelines.load import load_scene
from reflet.render.playback.renderer import Renderer
from reflet.report.measures import SquaredError, picture_srgb, squared_error
from reflet.scene.views.camera import Camera
from reflet.scene.views.framing import frame_orbit
from reflet.scene.views.parameter_space import Orbit, orbit_space
from reflet.trace.layers import SegmentedLayers
from reflet.trace.tracer import Tracer

REFERENCE_SPP = 256
PLACES = {
    "at a sample": ((60.0, 22.0), (62.0, 22.0), (64.0, 22.0)),
    "between": ((61.0, 22.0), (63.0, 22.0)),
    "10° above": ((60.0, 32.0), (62.0, 32.0), (64.0, 32.0)),
}


def cameras(orbit: Orbit) -> dict[str, list[Camera]]:
    """Viewpoints by place."""
    return {
        place: [orbit.camera({"azimuth_deg": azimuth, "elevation_deg": elevation}) for azimuth, elevation in points]
        for place, points in PLACES.items()
    }


def measured(
    pem: ParameterizedEnvironmentMap, references: dict[str, list[SegmentedLayers]], pictures: str
) -> dict[str, tuple[float, float]]:
    """Display PSNR by place, of all layers and of the distant one under the traced local one."""
    renderer, out = Renderer(pem), {}
    for place, views in references.items():
        layered, distant = SquaredError(), SquaredError()
        for number, layers in enumerate(views):
            truth, coverage = object_radiance(layers)
            shown = straight(renderer.frame(layers.camera, what="object"))
            under = object_under_distant(layers, straight(renderer.layer_image(layers.camera, "distant")))
            layered += squared_error(truth, shown, coverage > 0.5)
            distant += squared_error(truth, under, coverage > 0.5)
            if number == 0:
                covered = coverage[..., None] > 0.5
                row = [picture_srgb(np.where(covered, image, 0.0)) for image in (truth, shown, under)]
                write_png(Path(f"{pictures}-{place.split()[0]}.png"), np.concatenate(row, 1))
        out[place] = layered.psnr, distant.psnr
    return out


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
    references: dict[str, list[SegmentedLayers]] = {}
    print(f"{'':22}{'rows':>6}{'texels':>8}{''.join(f'{place:>20}' for place in PLACES)}{'seconds':>9}")
    for name in asked.only:
        kind = PARAMETERIZATIONS[name]
        size = equal_sampling_size(kind, asked.em_size**2 * valid_texels(CUBE), power_of_two=True)
        folder = asked.folder / name
        if not (folder / "scene.gltf").exists():
            space = orbit_space(orbit, 3, 2.0)
            options = {"parameterization": name, "em_size": size, "spp": asked.spp, "local": "ellipsoid"}
            bake(scene, folder, space, resume=folder.exists(), **options)
        pem = open_pem(folder)
        if not references:
            tracer = Tracer(pem.scene, irradiance=pem.irradiance)
            for place, views in cameras(orbit).items():
                references[place] = [
                    tracer.view(
                        view, spp=REFERENCE_SPP, sample_count=1, seed=REFERENCE_SEED + number, surroundings=True
                    ).layers
                    for number, view in enumerate(views)
                ]
        found = measured(pem, references, str(folder)).values()
        timings = [json.loads(line) for line in (folder / TIMINGS).read_text().splitlines()]
        seconds = float(np.median([entry["infer_seconds"] for entry in timings]))
        columns = "".join(f"{layered:10.2f}{distant:10.2f}" for layered, distant in found)
        print(f"{name:22}{size:6}{valid_texels(kind) * size**2 / 1000:8.0f}{columns}{seconds:9.1f}", flush=True)


if __name__ == "__main__":
    main()
