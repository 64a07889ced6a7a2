"""Quads, boxes, spheres and cylinders with texture coordinates: what the built-in room is furnished with."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

Vec3 = tuple[float, float, float]


@dataclass(frozen=True)
class Solid:
    """Triangles by their corners (row 3·triangle + k), counter-clockwise from outside; ``uv`` in [0,1]² of ``tile``."""

    corners: Float[np.ndarray, "corners 3"]
    normals: Float[np.ndarray, "corners 3"]
    uv: Float[np.ndarray, "corners 2"]
    tile: Int[np.ndarray, "corners"]


def join(solids: list[Solid]) -> Solid:
    """All triangles of several solids."""
    fields = ("corners", "normals", "uv", "tile")
    return Solid(*(np.concatenate([getattr(solid, field) for solid in solids]) for field in fields))


def quad(corner: Vec3, right: Vec3, down: Vec3, tile: int) -> Solid:
    """A flat picture: ``corner`` is its top left, ``right`` and ``down`` its edges as its front's viewer sees them."""
    c, r, d = (np.asarray(x, np.float64) for x in (corner, right, down))
    uv = np.array([(0, 0), (0, 1), (1, 1), (0, 0), (1, 1), (1, 0)], np.float64)
    normal = np.cross(d, r)
    normals = np.broadcast_to(normal / np.linalg.norm(normal), (6, 3))
    return Solid(c + uv[:, :1] * r + uv[:, 1:] * d, normals, uv, np.full(6, tile))


def box(centre: Vec3, size: Vec3, sides: int, top: int | None = None, turn_deg: float = 0.0) -> Solid:
    """A box turned about the vertical, ``sides`` on its four sides and bottom, ``top`` (or ``sides``) on its top."""
    x, y, z = np.asarray(size, np.float64) / 2.0
    lid = sides if top is None else top
    faces = [
        quad((-x, y, z), (2 * x, 0, 0), (0, -2 * y, 0), sides),
        quad((x, y, -z), (-2 * x, 0, 0), (0, -2 * y, 0), sides),
        quad((x, y, z), (0, 0, -2 * z), (0, -2 * y, 0), sides),
        quad((-x, y, -z), (0, 0, 2 * z), (0, -2 * y, 0), sides),
        quad((-x, y, -z), (2 * x, 0, 0), (0, 0, 2 * z), lid),
        quad((-x, -y, z), (2 * x, 0, 0), (0, 0, -2 * z), sides),
    ]
    return placed(join(faces), centre, turn_deg)


def placed(solid: Solid, centre: Vec3, turn_deg: float) -> Solid:
    """A solid turned about the vertical through the origin (counter-clockwise from above), then moved."""
    cos, sin = np.cos(np.radians(turn_deg)), np.sin(np.radians(turn_deg))
    turned = np.array([[cos, 0.0, sin], [0.0, 1.0, 0.0], [-sin, 0.0, cos]])
    return Solid(solid.corners @ turned.T + centre, solid.normals @ turned.T, solid.uv, solid.tile)


def revolved(
    profile: Float[np.ndarray, "points 2"],
    normals: Float[np.ndarray, "points 2"],
    centre: Vec3,
    tile: int,
    around: int = 48,
) -> Solid:
    """A profile of (radius, height), running down the outside, turned about the vertical; ``normals`` likewise.

    The tile's u runs around, its v down the profile in equal steps. Cells that shrink to a point give one triangle.
    """
    angle = 2.0 * np.pi * np.arange(around + 1) / around
    cos, sin = np.cos(angle), -np.sin(angle)  # seen from outside u runs to the right

    def ring(pairs: np.ndarray) -> np.ndarray:
        across, up = pairs[:, :1], pairs[:, 1:]
        return np.stack([across * cos, np.repeat(up, len(cos), axis=1), across * sin], -1)

    points, shading = ring(profile), ring(normals)
    u, v = np.meshgrid(np.linspace(0, 1, around + 1), np.linspace(0, 1, len(profile)))
    i, j = (x.ravel() for x in np.meshgrid(np.arange(len(profile) - 1), np.arange(around), indexing="ij"))
    upper = np.stack([i, i + 1, i, j, j + 1, j + 1], -1)[profile[i, 0] > 0.0]
    lower = np.stack([i, i + 1, i + 1, j, j, j + 1], -1)[profile[i + 1, 0] > 0.0]
    cells = np.concatenate([upper, lower])
    rows, columns = cells[:, :3].ravel(), cells[:, 3:].ravel()
    at = points[rows, columns] + np.asarray(centre)
    return Solid(at, shading[rows, columns], np.stack([u, v], -1)[rows, columns], np.full(len(at), tile))


def sphere(centre: Vec3, radius: float, tile: int, around: int = 48) -> Solid:
    """A sphere, the tile wrapped around it like a map around a globe."""
    theta = np.linspace(0.0, np.pi, around // 2 + 1)
    unit = np.stack([np.sin(theta), np.cos(theta)], -1)
    unit[[0, -1], 0] = 0.0
    return revolved(unit * radius, unit, centre, tile, around)


def cylinder(centre: Vec3, radius: float, height: float, side: int, top: int, around: int = 64) -> Solid:
    """An upright cylinder, ``side`` wrapped around it, ``top`` laid on its upper end; open below."""
    profile = np.array([[radius, height / 2.0], [radius, -height / 2.0]])
    wall = revolved(profile, np.array([[1.0, 0.0], [1.0, 0.0]]), centre, side, around)
    angle = 2.0 * np.pi * np.arange(around) / around
    rim = np.stack([np.cos(angle), np.zeros(around), -np.sin(angle)], -1)
    fan = np.stack([np.zeros((around, 3)), rim, np.roll(rim, -1, axis=0)], axis=1).reshape(-1, 3)
    up = np.broadcast_to([0.0, 1.0, 0.0], fan.shape)
    end = fan * radius + np.asarray(centre) + (0.0, height / 2.0, 0.0)
    return join([wall, Solid(end, up, 0.5 + 0.5 * fan[:, [0, 2]], np.full(len(fan), top))])


def cone(centre: Vec3, radius: float, height: float, tile: int, around: int = 48) -> Solid:
    """An upright cone standing on its open base; ``centre`` is the base's."""
    steps = np.linspace(0.0, 1.0, 9)
    profile = np.stack([radius * steps, height * (1.0 - steps)], -1)
    slope = np.array([height, radius]) / np.hypot(height, radius)
    return revolved(profile, np.broadcast_to(slope, profile.shape), centre, tile, around)
