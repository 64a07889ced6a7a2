"""A mirror in a moving world: what surrounds it is drawn into an env map anew for every frame.

Run it with the folder to write to::

    python examples/moving_environment.py out/moving

Coloured solids circle a chromed teapot under an evening sky. Each frame first captures them into a map from the
teapot's middle, on the device, then draws the picture, in which the teapot mirrors that map. ``moving.webp`` plays two
seconds of it; ``strip.png`` shows four moments (left to right) by three ways to a map: six views into a cube, two
views into a dual paraboloid, and the cube warped into a sphere map that is made for the camera's own view.

What correct looks like: the solids' reflections run around the pot with them, each on the side that faces it; the
three rows agree but for detail, though the sphere map is blurred towards the pot's outline, where it shows what lies
behind the pot: that is its singularity.
"""

import sys
from pathlib import Path

import numpy as np
from PIL import Image

from reflet.envmap.parameterizations.gazing_ball import GazingBall
from reflet.envmap.parameterizations.latlong import LatLong
from reflet.files.atomic import atomic_path
from reflet.files.pictures.png import write_png
from reflet.render.capture.moving_scene import MovingSceneRenderer
from reflet.report.measures import picture_srgb
from reflet.scene.builtin.newell import PARTS
from reflet.scene.builtin.solids import Solid, box, cone
from reflet.scene.builtin.teapot import teapot_mesh
from reflet.scene.material import CLAMPS, MIRROR, EnvironmentLight, Material, Texture
from reflet.scene.meshes.corners import weld
from reflet.scene.meshes.primitives import sphere_mesh, torus_mesh
from reflet.scene.meshes.tessellate import tessellated
from reflet.scene.scene import Part, ReflectiveObject, Scene
from reflet.scene.sky_light import SkyLight
from reflet.scene.views.camera import Camera

TOWARDS_SUN = np.array([-0.6, 0.5, 0.6]) / np.sqrt(0.97)
LIGHT = SkyLight((0.35, 0.42, 0.6), (0.12, 0.1, 0.09), (1.1, 0.85, 0.55), tuple(TOWARDS_SUN))
SECONDS, RATE = 2, 20
ORBIT = 0.60  # metres from the teapot's middle
SOLIDS = 5


def matte(red: float, green: float, blue: float) -> Material:
    """A diffuse surface."""
    return Material(base_color=(red, green, blue), metallic=0.0)


def evening_sky() -> EnvironmentLight:
    """From orange at the horizon to blue, with a sun; dark earth below."""
    direction, _ = LatLong().texel_directions(128)
    height = direction[0, ..., 1:2]
    haze = np.exp(-6.0 * np.abs(height))
    sky = np.array([0.15, 0.28, 0.65]) + haze * np.array([0.9, 0.35, -0.1])
    earth = np.array([0.10, 0.08, 0.06]) + haze * np.array([0.25, 0.14, 0.06])
    sun = 14.0 * np.exp(-600.0 * (1.0 - direction[0] @ TOWARDS_SUN))[..., None] * np.array([1.0, 0.8, 0.5])
    return EnvironmentLight((np.where(height > 0.0, sky, earth) + sun).astype(np.float32))


def table() -> Part:
    """A chequered board; cut small, as triangles that are drawn onto a paraboloid must be."""
    squares = np.indices((12, 12)).sum(0) % 2
    pixels = np.where(squares[..., None] == 1, [[[225, 215, 195, 255]]], [[[70, 95, 120, 255]]]).astype(np.uint8)
    board = box((0.0, -0.02, 0.0), (2.4, 0.04, 2.4), 0)
    mesh = tessellated(weld(board.corners, board.normals, board.uv), 0.1)
    texture = Texture(np.repeat(np.repeat(pixels, 32, 0), 32, 1), wraps=CLAMPS)
    return Part("table", mesh, Material("table", metallic=0.0, base_color_texture_srgb=texture))


def scene() -> Scene:
    """The table, what circles above it, and the teapot of four parts."""

    def cut(solid: Solid, edge: float = 0.05) -> np.ndarray:
        return tessellated(weld(solid.corners, solid.normals, solid.uv), edge)

    solids = [
        Part("red ball", sphere_mesh(0.12, around=64), matte(0.85, 0.08, 0.06)),
        Part("green cube", cut(box((0.0, 0.0, 0.0), (0.18, 0.18, 0.18), 0)), matte(0.1, 0.6, 0.15)),
        Part("yellow cone", cut(cone((0.0, -0.12, 0.0), 0.12, 0.26, 0)), matte(0.9, 0.7, 0.08)),
        Part("blue ring", torus_mesh(0.10, 0.04, around=48, sides=24), matte(0.1, 0.2, 0.85)),
        Part(
            "lamp", sphere_mesh(0.05, around=48), Material(base_color=(0, 0, 0), metallic=0.0, emission=(6.0, 5.0, 4.0))
        ),
    ]
    teapot = [Part(name, teapot_mesh(name, subdivisions=12), MIRROR, reflective=True) for name in PARTS]
    parts = (table(), *solids, *teapot)
    pot = tuple(range(1 + SOLIDS, len(parts)))
    return Scene(parts, (ReflectiveObject("teapot", pot),), evening_sky())


def places(parts: int, seconds: float) -> np.ndarray:
    """Rigid transforms of all parts: the solids circle once in two seconds, turn about themselves, bob up and down."""
    out = np.tile(np.eye(4), (parts, 1, 1))
    for k in range(SOLIDS):
        angle = 2.0 * np.pi * (seconds / SECONDS + k / SOLIDS)
        c, s = np.cos(2.0 * angle), np.sin(2.0 * angle)
        out[1 + k, :3, :3] = [[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]]
        out[1 + k, :3, 3] = ORBIT * np.cos(angle), 0.17 + 0.04 * np.sin(2.0 * angle + k), -ORBIT * np.sin(angle)
    return out


def main(out: Path, width: int = 400, frames: int = SECONDS * RATE, map_rows: int = 256) -> None:
    """Writes ``strip.png`` and ``moving.webp``."""
    world = scene()
    camera = Camera((0.5, 1.05, 1.25), (0.0, 0.1, 0.0), fov_deg=34.0, width=width, height=width * 3 // 4)
    ways = {
        "cube": MovingSceneRenderer(world, map_rows, "cube", light=LIGHT),
        "dual paraboloid": MovingSceneRenderer(world, 2 * map_rows, "dual_paraboloid", light=LIGHT),
        "sphere map": MovingSceneRenderer(world, 2 * map_rows, "warp", GazingBall(), LIGHT),
    }

    def picture(renderer: MovingSceneRenderer, seconds: float) -> np.ndarray:
        return picture_srgb(renderer.frame(places(len(world.parts), seconds), camera)[..., :3])

    moments = [SECONDS * k / 4 for k in range(4)]
    rows = [np.concatenate([picture(each, t) for t in moments], 1) for each in ways.values()]
    out.mkdir(parents=True, exist_ok=True)
    write_png(out / "strip.png", np.concatenate(rows))
    film = [Image.fromarray(picture(ways["cube"], SECONDS * k / frames)) for k in range(frames)]
    with atomic_path(out / "moving.webp") as path:
        film[0].save(path, "WEBP", save_all=True, append_images=film[1:], duration=1000 // RATE, loop=0, quality=80)
    print(f"Look at strip.png in {out}, and open moving.webp in a browser.")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
