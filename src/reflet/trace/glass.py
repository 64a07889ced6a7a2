"""What a ray does at glass: exact Fresnel reflectance and Snell's law, on the device.

Rays that meet the back of a triangle come from the inside. A thin sheet has none.
"""

import drjit as dr
import mitsuba as mi

BEND = 1e-3  # least cosine between a ray that goes on and the geometric surface, see CONVENTIONS.md
LEAST_REFLECTANCE = 1e-3  # of glass: its local layer is what goes through, over this


def glass_reflectance(cosine, index, back, thin):  # type: ignore[no-untyped-def]
    """Reflectance of unpolarized light; 1 where it is reflected totally. ``index`` is that of the inside over that of
    the outside. Twin: `reflet.reflectance.brdfs.fresnel.fresnel_dielectric`."""
    beyond = dr.select(back & ~thin, dr.rcp(index), index)
    squared = (beyond - 1.0) * (beyond + 1.0) + dr.square(cosine)
    g = dr.sqrt(dr.maximum(squared, 1e-12))
    senkrecht = dr.square((g - cosine) / (g + cosine))
    ratio = (cosine * (g + cosine) - 1.0) / (cosine * (g - cosine) + 1.0)
    once = dr.select(squared <= 0.0, 1.0, 0.5 * senkrecht * (1.0 + dr.square(ratio)))
    return dr.maximum(dr.select(thin, 2.0 * once / (1.0 + once), once), LEAST_REFLECTANCE)


def refracted(direction, normal, geometric, index, back, thin):  # type: ignore[no-untyped-def]
    """The unit ray beyond the surface, straight on through a thin sheet; both normals face the ray. Where light is
    reflected totally it grazes the surface."""
    ratio = dr.select(back, index, dr.rcp(index))
    cosine = -dr.dot(direction, normal)
    squared = 1.0 - dr.square(ratio) * (1.0 - dr.square(cosine))
    beyond = direction * ratio + normal * (ratio * cosine - dr.sqrt(dr.maximum(squared, 0.0)))
    height = dr.dot(beyond, geometric)
    bent = mi.Vector3f(dr.select(height > -BEND, beyond - geometric * (height + BEND), beyond))
    return dr.select(thin, direction, dr.normalize(bent))
