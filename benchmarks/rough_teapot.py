"""The benchmark scene's teapot, rough.

    python benchmarks/rough_teapot.py teapot-bench.glb FOLDER [--roughness 0.15 0.3 0.5 textured] [--samples quick]

Bakes the scene (from ../shared/data/bench) by default options into a folder of FOLDER for each perceptual roughness,
of all that reflects; "textured" lies between 0.1 and 0.7, in waves over the surface. Prints the display PSNR of what
plays beside ray tracing, and bytes. Goes on with bakes that are there.
"""

import argparse
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from reflet.pem.container import open_pem
from reflet.pipelines.bake import bake
from reflet.pipelines.compare import compare
from reflet.pipelines.load import load_scene
from reflet.report.comparison import PLACES
from reflet.scene.material import Texture
from reflet.scene.scene import Part
from reflet.scene.views.parameter_space import Orbit, orbit_space

TEXTURED, LEAST, MOST = "textured", 0.1, 0.7
WAVES = ((3, 2, 0.3, 1.0), (5, -4, 1.2, 0.7), (2, 7, 2.0, 0.6), (9, 3, 0.5, 0.4))  # along u, along v, phase, height


def waves(size: int = 256) -> Texture:
    """Roughness in green, as glTF has it."""
    v, u = np.mgrid[:size, :size] * (2.0 * np.pi / size)
    height = sum(h * np.sin(a * u + b * v + phase) for a, b, phase, h in WAVES)
    height = (height - height.min()) / np.ptp(height)
    pixels = np.full((size, size, 4), 255, np.uint8)
    pixels[..., 1] = np.round(255.0 * (LEAST + (MOST - LEAST) * height))
    return Texture(pixels)


def roughened(part: Part, roughness: str) -> Part:
    if not part.reflective:
        return part
    if roughness != TEXTURED:
        return replace(part, material=replace(part.material, perceptual_roughness=float(roughness)))
    x, y, z = part.mesh.positions.T
    around = np.stack([0.5 + np.arctan2(z, x) / (2.0 * np.pi), 4.0 * y], -1).astype(np.float32)
    material = replace(part.material, perceptual_roughness=1.0, metallic_roughness_texture=waves())
    return replace(part, mesh=replace(part.mesh, uv=around), material=material)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene")
    parser.add_argument("folder", type=Path)
    parser.add_argument("--roughness", nargs="+", default=["0.15", "0.3", "0.5", TEXTURED])
    parser.add_argument("--samples", default="quick")
    parser.add_argument("--spp", type=int, default=256, help="of the reference")
    parser.add_argument("--image-size", type=int, default=256)
    parser.add_argument("--em-size", type=int, default=128)
    asked = parser.parse_args()
    samples = int(asked.samples) if asked.samples.isdigit() else asked.samples
    orbit = Orbit((0.01, 0.15, 0.0), 60.0, 22.0, 1.25, image_size=asked.image_size)
    smooth = load_scene(asked.scene)
    print(f"{'':12}" + "".join(f"{words:>17}" for words in PLACES.values()), flush=True)
    for roughness in asked.roughness:
        scene = replace(smooth, parts=tuple(roughened(part, roughness) for part in smooth.parts))
        folder, begun = asked.folder / roughness, time.perf_counter()
        resume = folder.exists()
        bake(scene, folder, orbit_space(orbit, 0, 2.0), em_size=asked.em_size, resume=resume)
        seconds = "" if resume else f"{time.perf_counter() - begun:.0f} s, "
        size = sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())
        comparison = compare(open_pem(folder), samples=samples, reference_spp=asked.spp, rivals=False)
        values = (comparison.result(place, "traced").psnr_display for place in PLACES)
        print(f"{roughness:12}" + "".join(f"{value:17.2f}" for value in values) + f"   {seconds}{size / 1e6:.1f} MB",
              flush=True)  # fmt: skip


if __name__ == "__main__":
    main()
