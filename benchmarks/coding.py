"""What coding a PEM's maps and environment costs and saves: bytes, time, display PSNR against ray tracing by quality.

    python benchmarks/coding.py PEM [PEM …] [--image-size 512] [--spp 256] [--qualities Q …]

PEM: a folder baked with --codec none. Pictures of the object at one viewpoint of its orbit and at three of the dome
that `reflet compare` looks from, at 16 samples a pixel and adaptively. The last column compares whole pictures, with
the environment behind, with those of the maps as they were.
"""

import argparse
import tempfile
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from reflet import open_pem
from reflet.envmap.env_map import EnvMap
from reflet.pem.coding.coded_map import (
    read_coded_environment,
    read_coded_map,
    write_coded_environment,
    write_coded_map,
)
from reflet.pem.pem import ParameterizedEnvironmentMap
from reflet.pipelines.compare import dome_points, straight
from reflet.render.playback.renderer import Renderer
from reflet.report.measures import squared_error
from reflet.trace.compose import object_radiance
from reflet.trace.tracer import Tracer
from reflet.trace.variant import use_variant

SAMPLES = (16, "adaptive")


def main() -> None:
    """Prints a table for each PEM."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("pems", type=Path, nargs="+")
    parser.add_argument("--image-size", type=int, default=512)
    parser.add_argument("--spp", type=int, default=256)
    parser.add_argument("--qualities", type=int, nargs="+", default=(60, 75, 85, 92, 100))
    arguments = parser.parse_args()
    use_variant("llvm_ad_rgb")
    for folder in arguments.pems:
        print(f"\n{folder}")
        measure(open_pem(folder), arguments.image_size, arguments.spp, arguments.qualities)


def measure(pem: ParameterizedEnvironmentMap, image_size: int, spp: int, qualities: Sequence[int]) -> None:
    """One row for each quality."""
    orbit = replace(pem.space.orbit, image_size=image_size)
    dome = dome_points([orbit.azimuth_deg])
    places = [(orbit.azimuth_deg, orbit.elevation_deg), *(dome[k] for k in (1, 5, 9))]
    cameras = [orbit.camera({"azimuth_deg": azimuth, "elevation_deg": elevation}) for azimuth, elevation in places]
    tracer = Tracer(pem.scene, irradiance=pem.irradiance, through=pem.traced_parts)
    references = []
    for number, camera in enumerate(cameras):
        layers = tracer.view(camera, spp=spp, sample_count=1, seed=900_000 + number, surroundings=True).layers
        references.append(object_radiance(layers))

    def show(shown: ParameterizedEnvironmentMap) -> dict:
        renderer = Renderer(shown)
        return {
            samples: (
                [straight(renderer.frame(camera, what="object", samples=samples)) for camera in cameras],
                [renderer.frame(camera, samples=samples)[..., :3] for camera in cameras],
            )
            for samples in SAMPLES
        }

    def against_traced(pictures: list) -> list[float]:
        return [
            squared_error(radiance, picture, coverage > 0.5).psnr
            for picture, (radiance, coverage) in zip(pictures, references, strict=True)
        ]

    plain = show(pem)
    truth = {samples: against_traced(objects) for samples, (objects, _) in plain.items()}
    print("uncoded, dB:", {samples: np.round(values, 2).tolist() for samples, values in truth.items()})
    print("quality | kB of maps, environment | s to write, read | dB lost, 16 | dB lost, adaptive | whole picture, dB")
    for quality in qualities:
        coded, kilobytes, seconds = through(pem, quality)
        drawn = show(coded)
        lost = [np.round(np.subtract(truth[s], against_traced(drawn[s][0])), 3).tolist() for s in SAMPLES]
        everywhere = np.ones((image_size, image_size), bool)
        same = [squared_error(a, b, everywhere).psnr for a, b in zip(plain[16][1], drawn[16][1], strict=True)]
        print(quality, "|", kilobytes, "|", seconds, "|", *lost, "|", np.round(same, 1).tolist(), flush=True)


def through(pem: ParameterizedEnvironmentMap, quality: int) -> tuple[ParameterizedEnvironmentMap, str, str]:
    """The PEM with its base and environment coded and decoded; kilobytes and seconds."""
    sizes, written, read = [], 0.0, 0.0
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "coded.avif"
        maps = []
        for env_map in pem.base:
            start = time.perf_counter()
            write_coded_map(path, env_map.chain, env_map.texels, quality)
            written += time.perf_counter() - start
            sizes.append(path.stat().st_size)
            start = time.perf_counter()
            texels = read_coded_map(path, env_map.chain, env_map.texels.shape[1])
            read += time.perf_counter() - start
            maps.append(EnvMap(env_map.chain, texels, env_map.geometry))
            assert abs(texels[:, :3].max() / env_map.texels[:, :3].max() - 1.0) < 0.02
        scene = pem.scene
        if scene.environment is not None:
            rows, columns, _ = scene.environment.radiance.shape
            start = time.perf_counter()
            write_coded_environment(path, scene.environment.radiance, quality)
            written += time.perf_counter() - start
            sizes.append(path.stat().st_size)
            environment = replace(scene.environment, radiance=read_coded_environment(path, rows, columns))
            scene = replace(scene, environment=environment)
    kilobytes = ", ".join(f"{size / 1e3:.1f}" for size in sizes)
    return replace(pem, base=tuple(maps), scene=scene), kilobytes, f"{written:.2f}, {read:.2f}"


if __name__ == "__main__":
    main()
