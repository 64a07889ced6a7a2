"""Which pixels a mesh may cover: a conservative list, so that only they need be traced."""

from math import ceil, floor

import numpy as np
from jaxtyping import Bool, Float, UInt
from numba import njit

from reflet.scene.views.camera import Camera


def covered_pixels(
    camera: Camera, positions: Float[np.ndarray, "vertices 3"], triangles: UInt[np.ndarray, "triangles 3"]
) -> Bool[np.ndarray, "height width"]:
    """Pixels whose square any triangle's projection touches, whether something stands before it or not.

    Conservative: no touched pixel is missed. A triangle that reaches behind the camera counts as covering everything.
    """
    corner, dx, dy = camera.ray_basis()
    across, down = dx / (dx @ dx), dy / (dy @ dy)
    frame = np.stack([across, down, camera.frame()[2]])
    covered = np.zeros((camera.height, camera.width), np.bool_)
    _cover(
        np.asarray(camera.position, np.float64), frame, across @ corner, down @ corner, positions, triangles, covered
    )
    return covered


@njit(cache=True, error_model="numpy")
def _cover(eye, frame, left_edge, top_edge, positions, triangles, covered):  # type: ignore[no-untyped-def]
    height, width = covered.shape
    slack = 1e-3  # pixels, far above rounding of float32 ray casts
    xy = np.empty((3, 2))
    for k in range(len(triangles)):
        ahead = 0
        for c in range(3):
            p = positions[triangles[k, c]]
            x, y, z = p[0] - eye[0], p[1] - eye[1], p[2] - eye[2]
            depth = frame[2, 0] * x + frame[2, 1] * y + frame[2, 2] * z
            if depth > 0.0:
                ahead += 1
                xy[c, 0] = (frame[0, 0] * x + frame[0, 1] * y + frame[0, 2] * z) / depth - left_edge
                xy[c, 1] = (frame[1, 0] * x + frame[1, 1] * y + frame[1, 2] * z) / depth - top_edge
        if ahead == 0:
            continue
        if ahead < 3:
            covered[:] = True
            return
        left = max(floor(min(xy[0, 0], xy[1, 0], xy[2, 0]) - slack), 0)
        right = min(ceil(max(xy[0, 0], xy[1, 0], xy[2, 0]) + slack), width)
        top = max(floor(min(xy[0, 1], xy[1, 1], xy[2, 1]) - slack), 0)
        bottom = min(ceil(max(xy[0, 1], xy[1, 1], xy[2, 1]) + slack), height)
        for y in range(int(top), int(bottom)):
            for x in range(int(left), int(right)):
                if not covered[y, x] and _touches(xy, 0, 1, 2, x, y, slack):
                    covered[y, x] = True


@njit(cache=True, error_model="numpy")
def _touches(xy, a, b, c, x, y, slack):  # type: ignore[no-untyped-def]
    """No edge of the triangle separates it from the pixel's square (the boxes are known to meet)."""
    area = (xy[b, 0] - xy[a, 0]) * (xy[c, 1] - xy[a, 1]) - (xy[b, 1] - xy[a, 1]) * (xy[c, 0] - xy[a, 0])
    turn = 1.0 if area >= 0.0 else -1.0
    corners = (a, b, c, a)
    for e in range(3):
        p, q = corners[e], corners[e + 1]
        ex, ey = turn * (xy[q, 0] - xy[p, 0]), turn * (xy[q, 1] - xy[p, 1])
        # The square's largest value of the edge function: centre plus half its extent along the edge's normal.
        centre = ex * (y + 0.5 - xy[p, 1]) - ey * (x + 0.5 - xy[p, 0])
        if centre + (0.5 + slack) * (abs(ex) + abs(ey)) < 0.0:
            return False
    return True
