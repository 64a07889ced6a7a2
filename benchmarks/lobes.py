"""Layers of rough parts: their noise and bias, with and without looking for emitters, and their time beside a mirror's.

    python benchmarks/lobes.py SCENE [--roughness 0.15 0.3 0.5] [--image-size 256] [--spp 64] [--environment HDR] …

All reflective parts get each roughness in turn. Display PSNR on the pixels that the object covers by half and more, of
the object as it truly looks: *rays only* and *noise*, of one trace against the truth, as two seeds tell, without and
with looking for emitters; *bias*, of the mean of 8 seeds against 8 times as many samples, with both noise; *layers*,
with 8 times the samples, of what is put together from the layers against the truth. *time*: processor seconds of a
trace over those of the same with mirrors, medians of ``--repeat`` in turns.
"""

import argparse
import statistics
import time
from dataclasses import replace

import numpy as np

from reflet.pipelines.load import load_scene
from reflet.report.measures import display_psnr
from reflet.scene.scene import Scene
from reflet.scene.views.framing import frame_orbit
from reflet.trace.compose import object_radiance
from reflet.trace.layers import SegmentedLayers
from reflet.trace.light import emitters
from reflet.trace.tracer import Tracer

MANY = 8
HALF_IS_TRUE = 10.0 * np.log10(2.0)  # dB: two pictures differ by the noise of both


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scene")
    parser.add_argument("--roughness", type=float, nargs="+", default=[0.15, 0.3, 0.5])
    parser.add_argument("--environment")
    parser.add_argument("--reflect", nargs="*", default=[])
    parser.add_argument("--azimuth", type=float, default=60.0)
    parser.add_argument("--elevation", type=float, default=22.0)
    parser.add_argument("--image-size", type=int, default=256)
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--irradiance-spp", type=int, default=256)
    parser.add_argument("--repeat", type=int, default=5)
    asked = parser.parse_args()

    scene = load_scene(asked.scene, environment=asked.environment, reflect=asked.reflect)
    orbit = replace(frame_orbit(scene), image_size=asked.image_size)
    camera = orbit.camera({"azimuth_deg": asked.azimuth, "elevation_deg": asked.elevation})
    mirror = Tracer(with_roughness(scene, 0.0), irradiance_spp=asked.irradiance_spp)

    def tracer(roughness: float) -> Tracer:
        return Tracer(with_roughness(scene, roughness), irradiance=mirror.irradiance)

    def layers(of: Tracer, seed: int, spp: int = asked.spp) -> SegmentedLayers:
        return of.view(camera, spp=spp, seed=seed).layers

    mask = object_radiance(layers(mirror, 0))[1] > 0.5

    def psnr(one: np.ndarray, other: np.ndarray) -> float:
        return display_psnr(one, other, mask)

    print("roughness  rays only  noise   bias  layers   time")
    for roughness in asked.roughness:
        rough, blind = tracer(roughness), without_search(tracer(roughness))
        both, alone = (
            psnr(*(object_radiance(layers(of, seed))[0] for seed in (1, 2))) + HALF_IS_TRUE for of in (rough, blind)
        )
        true = layers(rough, 3, MANY * asked.spp)
        looks = object_radiance(true)[0]
        shown = true.fresnel * (true.local + (1.0 - true.alpha[:, None]) * true.distant)
        put_together = object_radiance(replace(true, combined=shown))[0]
        mean = np.mean([object_radiance(layers(rough, 100 + seed))[0] for seed in range(MANY)], 0)
        seconds: dict[Tracer, list[float]] = {mirror: [], rough: []}
        for _ in range(asked.repeat):
            for each, times in seconds.items():
                start = time.process_time()
                layers(each, 0)
                times.append(time.process_time() - start)
        ratio = statistics.median(seconds[rough]) / statistics.median(seconds[mirror])
        bias, split = psnr(looks, mean.astype(np.float32)), psnr(looks, put_together)
        print(f"{roughness:9.2f}  {alone:9.1f}  {both:5.1f}  {bias:5.1f}  {split:6.1f}  {ratio:5.2f}", flush=True)


def with_roughness(scene: Scene, roughness: float) -> Scene:
    """The scene with all that reflects of this roughness."""

    def of(part):  # type: ignore[no-untyped-def]
        looks = replace(part.material, perceptual_roughness=roughness, metallic_roughness_texture=None)
        return replace(part, material=looks) if part.reflective else part

    return replace(scene, parts=tuple(of(part) for part in scene.parts))


def without_search(tracer: Tracer) -> Tracer:
    """The tracer with rays alone, which find emitters by chance."""
    nothing = emitters.emitters_of(tracer._device)
    nothing.any = nothing.has_triangles = nothing.has_environment = False
    return tracer


if __name__ == "__main__":
    main()
