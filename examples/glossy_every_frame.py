"""A glossy torus in moving worlds: Figure 14 of Environment Maps and Their Applications (2000).

Run it with the folder to write to::

    python examples/glossy_every_frame.py out/glossy

For every frame what surrounds the torus is drawn into a dual paraboloid, filtered with Phong's lobe by the notes' own
method (two filters of at most 7² texels on mip levels, blended by d²), and mirrored. ``glossy.png`` shows two worlds,
balls that circle in a court and in a sunset, with the exponents 50 and 500; ``glossy.webp`` plays two seconds of the
first.

What correct looks like: with 500 one sees what the balls are and reads the court's walls, with 50 there are spots of
their colours; the spots lie where the sharper reflections are, without seams, and run around with the balls.
"""

import sys
import time
from pathlib import Path

import numpy as np
from PIL import Image

from reflet.envmap.parameterizations.latlong import LatLong
from reflet.envmap.resampling.resample import resample
from reflet.files.atomic import atomic_path
from reflet.files.pictures.png import write_png
from reflet.render.capture.moving_scene import MovingSceneRenderer
from reflet.report.measures import picture_srgb
from reflet.report.plate import plate
from reflet.scene.builtin.labelled_court import SUN, labelled_court
from reflet.scene.material import EnvironmentLight, Material
from reflet.scene.meshes.primitives import sphere_mesh, torus_mesh
from reflet.scene.scene import Part, ReflectiveObject, Scene
from reflet.scene.sky_light import SkyLight
from reflet.scene.views.camera import Camera

EXPONENTS = (50.0, 500.0)
BALLS = ((0.75, 0.05, 0.04), (0.75, 0.55, 0.05), (0.05, 0.45, 0.10), (0.06, 0.12, 0.75))
SECONDS, RATE = 2, 15
LEAN = np.radians(40.0)
TO_SUNSET = np.array([0.35, 0.12, -0.93])


def sunset() -> EnvironmentLight:
    """A glowing band above dark ground, brightest towards the sun."""
    direction, _ = LatLong().texel_directions(128)
    height, towards = direction[0, ..., 1:2], (direction[0] @ TO_SUNSET)[..., None]
    band = np.exp(-8.0 * np.abs(height)) * (0.4 + 0.6 * np.maximum(towards, 0.0) ** 2)
    sky = np.array([0.05, 0.07, 0.22]) + band * np.array([1.6, 0.55, 0.15])
    ground = np.array([0.02, 0.02, 0.03]) + band * np.array([0.35, 0.15, 0.08])
    sun = 20.0 * np.maximum(towards, 0.0) ** 400 * np.array([1.0, 0.6, 0.25])
    return EnvironmentLight((np.where(height > 0.0, sky + sun, ground)).astype(np.float32))


def court() -> EnvironmentLight:
    """The labelled court; its sun, outshone by nothing, is dimmed to what a lamp would be."""
    texels = resample(labelled_court(256), LatLong(), 512).texels[0]
    return EnvironmentLight(np.minimum(texels, 25.0))


WORLDS = {
    "court": (court, SkyLight((0.35, 0.42, 0.6), (0.2, 0.18, 0.16), (1.5, 1.4, 1.2), tuple(SUN))),
    "sunset": (sunset, SkyLight((0.10, 0.10, 0.22), (0.04, 0.03, 0.03), (1.6, 0.7, 0.3), tuple(TO_SUNSET))),
}


def scene(environment: EnvironmentLight) -> Scene:
    """The torus, and four balls."""
    torus = Part("torus", torus_mesh(), Material(base_color=(0.9, 0.9, 0.9), metallic=1.0), reflective=True)
    balls = [
        Part(f"ball {k}", sphere_mesh(0.28, around=64), Material(base_color=color, metallic=0.0))
        for k, color in enumerate(BALLS)
    ]
    return Scene((torus, *balls), (ReflectiveObject("torus", (0,)),), environment)


def places(seconds: float) -> np.ndarray:
    """Where all parts are: the torus leans towards the viewer, the balls circle once in two seconds, up and down."""
    out = np.tile(np.eye(4), (1 + len(BALLS), 1, 1))
    c, s = np.cos(LEAN), np.sin(LEAN)
    out[0, :3, :3] = [[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]]
    for k in range(len(BALLS)):
        angle = 2.0 * np.pi * (seconds / SECONDS + k / len(BALLS))
        out[1 + k, :3, 3] = 1.5 * np.cos(angle), 0.1 + 0.55 * np.sin(angle), -1.5 * np.sin(angle)
    return out


def main(out: Path, picture: int = 320, frames: int = SECONDS * RATE, map_rows: int = 256) -> None:
    """Writes both; maps have ``map_rows`` rows a face."""
    camera = Camera((0.9, 1.1, 5.0), (0.0, 0.0, 0.0), fov_deg=32.0, width=picture, height=picture * 3 // 4)
    cells, film = [], []
    for name, (environment, light) in WORLDS.items():
        world = scene(environment())
        for exponent in EXPONENTS:
            renderer = MovingSceneRenderer(world, map_rows, "dual_paraboloid", light=light, phong_exponent=exponent)
            cells.append(picture_srgb(renderer.frame(places(0.12), camera, samples=16)[..., :3]))
            start = time.perf_counter()
            moments = [SECONDS * k / frames for k in range(frames)]
            shown = [picture_srgb(renderer.frame(places(t), camera)[..., :3]) for t in moments]
            rate = frames / (time.perf_counter() - start)
            print(f"{name}, N = {exponent:g}: {rate:.1f} frames a second, filtered anew for each")
            film += shown if name == "court" and exponent == EXPONENTS[0] else []
    out.mkdir(parents=True, exist_ok=True)
    titles = [f"{name}, N = {exponent:g}" for name in WORLDS for exponent in EXPONENTS]
    write_png(out / "glossy.png", plate([cells], titles))
    pictures = [Image.fromarray(each) for each in film]
    with atomic_path(out / "glossy.webp") as path:
        pictures[0].save(
            path, "WEBP", save_all=True, append_images=pictures[1:], duration=1000 // RATE, loop=0, quality=80
        )
    print(f"Look at glossy.png in {out}, and open glossy.webp in a browser.")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
