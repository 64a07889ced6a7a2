"""The parameterizations, compiled: scalar functions for use inside compiled loops, in float64.

``kind`` is `Parameterization.kind`. The NumPy classes say what is computed and why; tests hold the two to each other.
"""

from math import atan2, copysign, cos, hypot, pi, sin, sqrt

import numpy as np
from numba import njit

from reflet.envmap.parameterizations.angular import Angular
from reflet.envmap.parameterizations.cube import AXES, Cube
from reflet.envmap.parameterizations.dual_paraboloid import DualParaboloid
from reflet.envmap.parameterizations.equal_area_octahedral import EqualAreaOctahedral
from reflet.envmap.parameterizations.gazing_ball import GazingBall
from reflet.envmap.parameterizations.latlong import LatLong
from reflet.envmap.parameterizations.octahedral import Octahedral

CUBE = Cube.kind
LATLONG = LatLong.kind
DUAL_PARABOLOID = DualParaboloid.kind
GAZING_BALL = GazingBall.kind
ANGULAR = Angular.kind
OCTAHEDRAL = Octahedral.kind
EQUAL_AREA_OCTAHEDRAL = EqualAreaOctahedral.kind

_AXES = np.ascontiguousarray(AXES)
_LEAST_SINE = 1e-3  # as in the NumPy classes: keeps sampling rates finite at poles


@njit(cache=True, error_model="numpy")
def face_of(x, y, z):  # type: ignore[no-untyped-def]
    """Index of the cube face that a direction meets."""
    if abs(x) >= abs(y) and abs(x) >= abs(z):
        return 0 if x >= 0.0 else 1
    if abs(y) >= abs(z):
        return 2 if y >= 0.0 else 3
    return 4 if z >= 0.0 else 5


@njit(cache=True, error_model="numpy")
def project(face, x, y, z):  # type: ignore[no-untyped-def]
    """(s, t) of a direction on the plane of a cube face, and whether it points to the plane's side at all."""
    axes = _AXES[face]
    major = x * axes[0, 0] + y * axes[0, 1] + z * axes[0, 2]
    scale = 1.0 / major if major > 0.0 else 0.0
    s = (x * axes[1, 0] + y * axes[1, 1] + z * axes[1, 2]) * scale
    t = (x * axes[2, 0] + y * axes[2, 1] + z * axes[2, 2]) * scale
    return s, t, major > 0.0


@njit(cache=True, error_model="numpy")
def point_of(kind, x, y, z):  # type: ignore[no-untyped-def]
    """(face, u, v) of a direction of any length but zero: `Parameterization.uv_from_direction`."""
    if kind == CUBE:
        face = face_of(x, y, z)
        s, t, _ = project(face, x, y, z)
        return face, 0.5 + 0.5 * s, 0.5 + 0.5 * t
    if kind == LATLONG:
        return 0, 0.5 + atan2(z, x) / (2.0 * pi), atan2(sqrt(x * x + z * z), y) / pi
    if kind == DUAL_PARABOLOID:
        half = 0.5 / (sqrt(x * x + y * y + z * z) + abs(z))
        return 0 if z >= 0.0 else 1, 0.5 + half * x, 0.5 - half * y
    if kind in (GAZING_BALL, ANGULAR):
        ring = sqrt(x * x + y * y)
        if kind == ANGULAR:
            radius = atan2(ring, -z) / pi
        else:
            # sin(θ/2) by the half-angle formula that does not cancel
            length = sqrt(ring * ring + z * z)
            radius = ring / sqrt(2.0 * length * (length + z)) if z >= 0.0 else sqrt(0.5 * (length - z) / length)
        if ring == 0.0:
            return 0, 0.5 + 0.5 * radius, 0.5
        return 0, 0.5 + 0.5 * radius * x / ring, 0.5 - 0.5 * radius * y / ring
    if kind == OCTAHEDRAL:
        scale = 1.0 / (abs(x) + abs(y) + abs(z))
        s, t = x * scale, z * scale
        if y < 0.0:
            s, t = copysign(1.0 - abs(t), s), copysign(1.0 - abs(s), t)
        return 0, 0.5 + 0.5 * s, 0.5 + 0.5 * t
    square = x * x + z * z
    length = sqrt(square + y * y)
    radius = sqrt(square / (length * (length + abs(y))))
    t = radius * atan2(abs(z), abs(x)) * (2.0 / pi)
    s = radius - t
    if y < 0.0:
        s, t = 1.0 - t, 1.0 - s
    return 0, 0.5 + 0.5 * copysign(s, x), 0.5 + 0.5 * copysign(t, z)


@njit(cache=True, error_model="numpy")
def direction_at(kind, face, u, v):  # type: ignore[no-untyped-def]
    """Unit direction (x, y, z) of a place on a face, outside a round map's disc its continuation."""
    if kind == CUBE:
        axes, s, t = _AXES[face], 2.0 * u - 1.0, 2.0 * v - 1.0
        scale = 1.0 / sqrt(1.0 + s * s + t * t)
        return (
            (axes[0, 0] + s * axes[1, 0] + t * axes[2, 0]) * scale,
            (axes[0, 1] + s * axes[1, 1] + t * axes[2, 1]) * scale,
            (axes[0, 2] + s * axes[1, 2] + t * axes[2, 2]) * scale,
        )
    if kind == LATLONG:
        phi, theta = (u - 0.5) * (2.0 * pi), v * pi
        ring = sin(theta)
        return ring * cos(phi), cos(theta), ring * sin(phi)
    if kind in (DUAL_PARABOLOID, GAZING_BALL, ANGULAR):
        x, y = 2.0 * u - 1.0, 1.0 - 2.0 * v
        square = x * x + y * y
        if kind == DUAL_PARABOLOID:
            scale = 1.0 / (1.0 + square)
            return 2.0 * x * scale, 2.0 * y * scale, (1.0 - square) * (scale if face == 0 else -scale)
        if kind == GAZING_BALL:
            if square > 1.0:
                scale = 1.0 - 2.0 / sqrt(square)
                x, y, square = scale * x, scale * y, scale * scale * square
            height = sqrt(max(1.0 - square, 0.0))
            return 2.0 * height * x, 2.0 * height * y, 2.0 * height * height - 1.0
        radius = sqrt(square)
        scale = sin(pi * radius) / radius if radius > 0.0 else pi
        return scale * x, scale * y, -cos(pi * radius)
    s, t = 2.0 * u - 1.0, 2.0 * v - 1.0
    height = 1.0 - abs(s) - abs(t)
    if kind == OCTAHEDRAL:
        x, z = s, t
        if height < 0.0:
            x, z = copysign(1.0 - abs(t), s), copysign(1.0 - abs(s), t)
        scale = 1.0 / sqrt(x * x + height * height + z * z)
        return x * scale, height * scale, z * scale
    radius = 1.0 - abs(height)
    phi = (0.25 * pi) * ((abs(t) - abs(s)) / radius + 1.0) if radius > 0.0 else 0.0
    ring = radius * sqrt(2.0 - radius * radius)
    return copysign(ring * cos(phi), s), copysign(1.0 - radius * radius, height), copysign(ring * sin(phi), t)


@njit(cache=True, error_model="numpy")
def rate_at(kind, x, y, z):  # type: ignore[no-untyped-def]
    """`Parameterization.sampling_rate` of a unit direction."""
    if kind == CUBE:
        return 0.25 / max(abs(x), abs(y), abs(z)) ** 3
    if kind == LATLONG:
        return 1.0 / (pi**2 * max(hypot(x, z), _LEAST_SINE))
    if kind == DUAL_PARABOLOID:
        return 0.25 / (1.0 + abs(z)) ** 2
    if kind == GAZING_BALL:
        return 1.0 / 16.0
    if kind == ANGULAR:
        ring = hypot(x, y)
        theta = atan2(ring, -z)
        return (1.0 if theta < _LEAST_SINE else theta / max(ring, _LEAST_SINE)) / (4.0 * pi**2)
    if kind == OCTAHEDRAL:
        return 0.25 / (abs(x) + abs(y) + abs(z)) ** 3
    return 0.25 / pi
