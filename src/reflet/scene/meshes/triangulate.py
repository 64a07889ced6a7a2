"""Polygons cut into triangles: of any number of corners, convex or not, flat or not."""

from dataclasses import dataclass

import mapbox_earcut
import numpy as np
from jaxtyping import Bool, Float, Int, Integer

_BATCH = 400_000  # corners worked on at a time, which bounds the memory
_FANS = 8  # corners that a fan is tried from before ears are cut, which costs more


@dataclass(frozen=True)
class Triangulation:
    """``corners`` are three corners a triangle, ``face`` is its polygon, ascending; ``crossing`` counts polygons that
    no triangles fill exactly because their outline crosses itself."""

    corners: Int[np.ndarray, "triangles 3"]
    face: Int[np.ndarray, "triangles"]
    crossing: int


def triangulate(
    positions: Float[np.ndarray, "positions 3"],
    corners: Integer[np.ndarray, "corners"],
    starts: Int[np.ndarray, "faces_and_one"],
) -> Triangulation:
    """Triangles of polygons: face f has corners starts[f] to starts[f + 1] - 1, three or more, at positions[corners].

    A polygon is a fan from its first corner where that fills it exactly (convex ones), else from another one of its
    first eight, else its ears are cut in the plane of its mean normal. Keyhole outlines around holes are filled as they
    mean. Corners in the middle of straight edges may be left out; polygons without area stay fans.
    """
    length = np.diff(starts)
    if (length == 3).all():
        every = np.arange(len(corners), dtype=np.int32)
        return Triangulation(every.reshape(-1, 3), every[: len(length)].copy(), 0)
    ends = np.cumsum(length - 2)
    triangles = np.empty((int(ends[-1]), 3), np.int32)
    crossing = 0
    for n in np.unique(length):
        faces = np.flatnonzero(length == n)
        for batch in np.array_split(faces, -(-len(faces) * int(n) // _BATCH)):
            first = starts[batch][:, None, None]
            local = np.arange(3)[None, None, :]
            if n > 3:
                local, crossed = _cut(positions[corners[first[..., 0] + np.arange(n)]].astype(np.float64))
                crossing += crossed
            rows = (ends[batch] - (n - 2))[:, None] + np.arange(n - 2)
            triangles[rows] = np.where(local < 0, -1, first + local)
    face = np.repeat(np.arange(len(length), dtype=np.int32), length - 2)
    kept = triangles[:, 0] >= 0
    return Triangulation(triangles[kept], face[kept], crossing)


def _cut(points: Float[np.ndarray, "faces n 3"]) -> tuple[Int[np.ndarray, "faces n-2 3"], int]:
    """Local corners of n - 2 triangles of each polygon, -1 where fewer fill it, and how many cross themselves."""
    count, n, _ = points.shape
    points = points - points[:, :1]
    normal = 0.5 * np.cross(points, np.roll(points, -1, axis=1)).sum(axis=1)  # Newell's: the mean over the surface
    area = np.linalg.norm(normal, axis=1)
    normal /= np.where(area > 0.0, area, 1.0)[:, None]
    triangles = np.tile(_fan(n, 0), (count, 1, 1))
    # a smaller share of the area is rounding of coordinates; the first triangle of a round n-gon's fan has about 40/n³
    sliver = 1e-9 * (4.0 / n) ** 3
    pending = np.arange(count)
    for start in range(min(n, _FANS) if n > 4 else 2):
        fan = _fan(n, start)
        fills = _fills(points[pending], fan, normal[pending], sliver * area[pending])
        triangles[pending[fills]] = fan
        pending = pending[~fills]
        if not len(pending):
            break
    crossing = 0
    for face in pending:
        flat = points[face] @ _plane(normal[face]).T
        if area[face] > 0.0:
            ears = mapbox_earcut.triangulate_float64(np.ascontiguousarray(flat), np.array([n], np.uint32))
            cut = ears.astype(np.int64).reshape(-1, 3)[: n - 2]
            triangles[face] = -1
            signed = _signed(flat[cut])
            cut[signed < 0.0] = cut[signed < 0.0, ::-1]
            cut = cut[np.abs(signed) > 2.0 * sliver * area[face]]
            triangles[face, : len(cut)] = cut
            filled = np.abs(signed).sum()
        else:  # nothing, or an outline like an 8
            corner = points[face][triangles[face]]
            filled = np.linalg.norm(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1).sum()
        # 1e-6 of the size: far above the rounding of coordinates in files, far below any overlap that is seen
        crossing += bool(abs(filled - 2.0 * area[face]) > 1e-6 * np.ptp(points[face], axis=0).max() ** 2)
    return triangles, crossing


def _fan(n: int, start: int) -> Int[np.ndarray, "steps 3"]:
    step = np.arange(1, n - 1)
    return (np.column_stack([np.zeros_like(step), step, step + 1]) + start) % n


def _fills(
    points: Float[np.ndarray, "faces n 3"],
    fan: Int[np.ndarray, "steps 3"],
    normal: Float[np.ndarray, "faces 3"],
    least: Float[np.ndarray, "faces"],
) -> Bool[np.ndarray, "faces"]:
    """Whether all triangles of a fan face the polygon's way, with areas above the least: then they fill it, because the
    areas of a fan, signed, add up to the polygon's."""
    spokes = points - points[:, fan[0, 0]][:, None]
    signed = np.einsum("ftk,fk->ft", np.cross(spokes[:, fan[:, 1]], spokes[:, fan[:, 2]]), normal)
    return (signed > 2.0 * least[:, None]).all(axis=1)


def _plane(normal: Float[np.ndarray, "3"]) -> Float[np.ndarray, "2 3"]:
    """Two unit vectors that span the plane, right-handed with its normal."""
    u = np.cross(normal, np.eye(3)[np.abs(normal).argmin()])
    u /= max(float(np.linalg.norm(u)), 1e-300)
    return np.stack([u, np.cross(normal, u)])


def _signed(triangles: Float[np.ndarray, "triangles 3 2"]) -> Float[np.ndarray, "triangles"]:
    a, b = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
