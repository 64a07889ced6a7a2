"""Small scenes to bake in tests: a mirror ball in surroundings of a few squares that shine."""

from pathlib import Path

import numpy as np

from reflet.scene.assemble import assemble
from reflet.scene.material import MIRROR, EnvironmentLight, Material
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.meshes.primitives import sphere_mesh
from reflet.scene.scene import Part, Scene
from reflet.scene.views.parameter_space import Axis, Orbit, ParameterSpace

Vec3 = tuple[float, float, float]


def square(name: str, corner: Vec3, along: Vec3, across: Vec3, radiance: Vec3, cells: int = 1) -> Part:
    """A parallelogram that shines to both sides, in ``cells``² fields whose brightness goes up and down."""
    c, a, b = (np.array(v, np.float64) for v in (corner, along, across))
    k = np.arange(cells) / cells
    places = c + (k[:, None, None] * a + k[None, :, None] * b).reshape(-1, 1, 3)
    corners = places + np.array([0 * a, a, a + b, b])[None] / cells
    bright = np.indices((cells, cells)).sum(0).ravel() % 2 == 0
    normal = np.cross(a, b) / np.linalg.norm(np.cross(a, b))
    four = 4 * np.arange(bright.sum())[:, None, None] + [[0, 1, 2], [0, 2, 3]]
    mesh = Mesh(
        corners[bright].reshape(-1, 3).astype(np.float32),
        np.tile(normal, (4 * bright.sum(), 1)).astype(np.float32),
        four.reshape(-1, 3).astype(np.uint32),
    )
    return Part(name, mesh, Material(name, (0, 0, 0), 0.0, emission=radiance, double_sided=True))


def ball(radius: float = 0.3, rings: int = 24) -> Part:
    return Part("ball", sphere_mesh(radius, (0.0, 0.0, 0.0), rings), MIRROR)


def sky(seed: int = 0) -> EnvironmentLight:
    """Smooth and without any symmetry."""
    v, u = np.meshgrid(np.linspace(0, np.pi, 16), np.linspace(-np.pi, np.pi, 32), indexing="ij")
    waves = [0.5 + 0.4 * np.sin(u + seed) * np.sin(v), 0.5 + 0.4 * np.cos(2 * v), 0.5 + 0.4 * np.cos(u) * np.sin(v)]
    return EnvironmentLight(np.stack(waves, -1).astype(np.float32))


def walls(half: float = 2.0, cells: int = 6) -> list[Part]:
    """The six sides of a room, tiled in light of their own colours before others of one colour."""
    h, parts = half, []
    for axis in range(3):
        for side in (-h, h):
            corner, along, across = np.full(3, -h), np.zeros(3), np.zeros(3)
            corner[axis] = side
            along[(axis + 1) % 3] = across[(axis + 2) % 3] = 2 * h
            shade = 0.2 + 0.15 * (2 * axis + (side > 0))
            tiles = tuple(map(tuple, (corner, along, across)))
            parts.append(square(f"tiles {axis} {side}", *tiles, (shade, 1.0 - shade, 0.8), cells))  # type: ignore[arg-type]
            corner[axis] *= 1.001
            tiles = tuple(map(tuple, (corner, along, across)))
            parts.append(square(f"wall {axis} {side}", *tiles, (0.15, 0.1, 0.1)))  # type: ignore[arg-type]
    return parts


def under_the_sky() -> Scene:
    """Nothing but the ball."""
    return assemble([ball()], environment=sky())


def in_a_room() -> Scene:
    return assemble([ball(), *walls()])


def beside_a_block() -> Scene:
    """In the room, and 0.3 m beside the ball a tiled screen."""
    screen = square("screen", (-0.6, -0.5, -0.6), (0.0, 0.0, 1.1), (0.0, 0.9, 0.0), (1.0, 0.9, 0.2), 5)
    return assemble([ball(), screen, *walls()])


def orbit(views: int = 1, spacing: float = 3.0, image_size: int = 32, elevation: float = 15.0) -> ParameterSpace:
    azimuths = tuple(20.0 + spacing * k for k in range(views))
    return ParameterSpace(
        (Axis("azimuth_deg", azimuths),), Orbit((0, 0, 0), 20.0, elevation, 1.1, image_size=image_size)
    )


def files(folder: Path) -> dict[Path, bytes]:
    """All that a bake wrote, but how long it took."""
    paths = [path for path in folder.rglob("*") if path.is_file() and path.suffix != ".jsonl"]
    return {path.relative_to(folder): path.read_bytes() for path in paths}
