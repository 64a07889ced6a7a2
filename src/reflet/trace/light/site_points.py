"""Points of the surfaces about the sites of mesh colours."""

from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from reflet.trace.device_scene import DeviceScene
from reflet.trace.light.mesh_colors import SampleSites
from reflet.trace.surface import surface_at


@dataclass
class SitePoint:
    """Points on the scene's triangles, with barycentrics ``uv`` and their ``position`` in space.

    The unit normals, the ``geometric`` and the interpolated ``smooth`` one, are those of the side that belongs to the
    site; ``origin`` is just off the surface on that side.
    """

    triangle: Any
    uv: Any
    position: Any
    origin: Any
    geometric: Any
    smooth: Any


class SitePoints:
    """Points of some sites, each within half a grid step of a sample that belongs to it."""

    def __init__(self, device: DeviceScene, sites: SampleSites) -> None:
        self.device = device
        self._members, self._starts = mi.UInt32(sites.members), mi.UInt32(sites.starts)
        self._triangle = mi.UInt32(sites.triangle)
        self._i, self._j, self._back = mi.UInt32(sites.i), mi.UInt32(sites.j), mi.UInt32(sites.back.astype(np.uint32))
        self._resolution = mi.UInt32(sites.resolution)

    def at(self, site, path, u, v) -> SitePoint:  # type: ignore[no-untyped-def]
        """Point (``u``, ``v``) in [0, 1)² of the cell of one of a site's samples, which take turns from ``path`` to
        path."""
        first = dr.gather(mi.UInt32, self._starts, site)
        alike = dr.gather(mi.UInt32, self._starts, site + 1) - first
        alike = dr.maximum(alike, 1)  # lanes that fill a packet up gather zeros: the processor would divide by them
        sample = dr.gather(mi.UInt32, self._members, first + path % alike)
        triangle = dr.gather(mi.UInt32, self._triangle, sample)
        back = dr.gather(mi.UInt32, self._back, sample) != 0
        uv = self._place(sample, triangle, u, v)
        # Looked at from the sampled side: against the geometric normal, or along it.
        front = surface_at(self.device, triangle, uv, mi.Vector3f(0.0, 1.0, 0.0), mi.Bool(True))
        geometric = dr.select(front.back ^ back, -front.geometric_normal, front.geometric_normal)
        smooth = dr.select(dr.dot(front.smooth_normal, geometric) < 0.0, -front.smooth_normal, front.smooth_normal)
        origin = mi.Point3f(front.position + geometric * front.offset)
        return SitePoint(triangle, uv, front.position, origin, geometric, smooth)

    def _place(self, sample, triangle, u, v):  # type: ignore[no-untyped-def]
        """Barycentrics, folded back into the triangle."""
        resolution = mi.Float(dr.gather(mi.UInt32, self._resolution, triangle))
        x = dr.abs(mi.Float(dr.gather(mi.UInt32, self._i, sample)) + u - 0.5) / resolution
        y = dr.abs(mi.Float(dr.gather(mi.UInt32, self._j, sample)) + v - 0.5) / resolution
        over = x + y > 1.0
        x, y = dr.select(over, 1.0 - y, x), dr.select(over, 1.0 - x, y)
        return mi.Point2f(dr.clip(x, 1e-4, 1.0), dr.clip(y, 1e-4, 1.0))
