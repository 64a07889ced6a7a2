"""Lights without extent as an emitter of Mitsuba's, for the path traced reference: glTF's cones and ranges, which
Mitsuba's own plugins do not have."""

from functools import cache

import drjit as dr
import mitsuba as mi

from reflet.scene.punctual_light import PunctualLight, packed


@cache
def _register(variant: str) -> None:
    class Punctual(mi.Emitter):  # type: ignore[name-defined, misc]
        """``intensity``, ``position`` and ``axis`` are the rows of `packed`, of a light that has a place."""

        def __init__(self, properties: "mi.Properties") -> None:
            super().__init__(properties)
            intensity, place, axis = (properties[name] for name in ("intensity", "position", "axis"))
            self.intensity, self.place, self.axis = mi.Color3f(intensity), mi.Point3f(place), mi.Vector3f(axis)
            self.inverse_range, self.offset = properties["inverse_range"], properties["offset"]
            self.m_flags = +mi.EmitterFlags.DeltaPosition

        def sample_direction(self, it, sample, active=True):  # type: ignore[no-untyped-def]
            """The one direction in which it lies."""
            found = dr.zeros(mi.DirectionSample3f, dr.width(it.p))
            found.p, found.n, found.uv, found.time = mi.Point3f(self.place), 0.0, 0.5, it.time
            found.pdf, found.delta, found.emitter = mi.Float(1.0), mi.Bool(True), mi.EmitterPtr(self)
            away = self.place - it.p
            found.dist = dr.norm(away)
            found.d = away / found.dist
            cone = dr.clip(dr.dot(self.axis, found.d) + self.offset, 0.0, 1.0)
            window = dr.maximum(1.0 - dr.power(found.dist * self.inverse_range, 4), 0.0)
            return found, dr.select(active, self.intensity * (dr.square(cone / found.dist) * window), 0.0)

        def pdf_direction(self, it, ds, active=True):  # type: ignore[no-untyped-def]
            """No ray meets it by chance."""
            return mi.Float(0.0)

        def eval(self, si, active=True):  # type: ignore[no-untyped-def]
            """Nothing is seen of it."""
            return mi.Color3f(0.0)

        def bbox(self):  # type: ignore[no-untyped-def]
            """Its place."""
            return mi.ScalarBoundingBox3f(mi.ScalarPoint3f(dr.slice(self.place)))

    mi.register_emitter("reflet_punctual", Punctual)


def punctual_emitter(light: PunctualLight) -> "mi.Emitter":
    """Mitsuba's emitter that shines as the light."""
    intensity, place, cone = packed([light])[0].astype(float).tolist()
    if light.position is None:
        shines = [-axis for axis in place[:3]]
        return mi.load_dict(
            {"type": "directional", "direction": shines, "irradiance": {"type": "rgb", "value": intensity[:3]}}
        )
    _register(mi.variant())
    return mi.load_dict(
        {
            "type": "reflet_punctual",
            "intensity": mi.ScalarColor3f(intensity[:3]),
            "position": mi.ScalarPoint3f(place[:3]),
            "axis": mi.ScalarVector3f(cone[:3]),
            "inverse_range": intensity[3],
            "offset": cone[3],
        }
    )
