"""What triangles wear, on the device: values of their corners, and textures."""

import drjit as dr
import mitsuba as mi

from reflet.trace.device_scene import NO_TEXTURE, DeviceScene


def interpolated(kind, table, corners, weights, active):  # type: ignore[no-untyped-def]
    return sum(dr.gather(kind, table, corners[k], active) * weights[k] for k in range(3))


def more_uv(device: DeviceScene, corners, weights, active):  # type: ignore[no-untyped-def]
    return [interpolated(mi.Point2f, table, corners, weights, active) for table in device.more_uv]


def unit(vector, otherwise):  # type: ignore[no-untyped-def]
    squared = dr.squared_norm(vector)
    return dr.select(squared > 1e-24, vector / dr.sqrt(dr.maximum(squared, 1e-30)), otherwise)


def texture_at(device: DeviceScene, slot, texcoords, active, srgb: bool, alpha: bool = False):  # type: ignore[no-untyped-def]
    """Bilinear lookup in linear values, or of ``alpha``, by the texture's own coordinates; white where a lane has no
    texture."""
    active = active & (slot != NO_TEXTURE)
    header = dr.gather(mi.Vector4u, device.texture_headers, slot, active)
    width, height = mi.Int32(dr.maximum(header.y, 1)), mi.Int32(dr.maximum(header.z, 1))
    uv = texcoords[0]
    for number, other in enumerate(texcoords[1:], 1):
        uv = dr.select((header.w >> 4) == number, other, uv)

    def axis(coordinate, size, wrap):  # type: ignore[no-untyped-def]
        repeats = wrap == 0
        wrapped = dr.select(repeats, coordinate - dr.floor(coordinate), dr.clip(coordinate, 0.0, 1.0))
        mirrored = dr.abs(coordinate - 2.0 * dr.floor(0.5 * coordinate + 0.5))
        x = dr.select(wrap == 2, mirrored, wrapped) * size - 0.5
        low = mi.Int32(dr.floor(x))
        high = low + 1
        fraction = x - low
        low = dr.select(low < 0, dr.select(repeats, size - 1, 0), low)
        high = dr.select(high >= size, dr.select(repeats, 0, size - 1), high)
        return low, high, fraction

    x0, x1, fx = axis(uv.x, width, header.w & 3)
    y0, y1, fy = axis(uv.y, height, (header.w >> 2) & 3)

    def texel(x, y):  # type: ignore[no-untyped-def]
        packed = dr.gather(mi.UInt32, device.texels, header.x + mi.UInt32(y * width + x), active)
        channels = [packed >> 24] * 3 if alpha else [packed & 255, (packed >> 8) & 255, (packed >> 16) & 255]
        if srgb:
            return mi.Color3f(*(dr.gather(mi.Float, device.linear_from_srgb, c, active) for c in channels))
        return mi.Color3f(*(mi.Float(c) / 255.0 for c in channels))

    value = dr.lerp(dr.lerp(texel(x0, y0), texel(x1, y0), fx), dr.lerp(texel(x0, y1), texel(x1, y1), fx), fy)
    return dr.select(active, value, 1.0)


def normal_mapped(device, corners, barycentrics, normal, slot, texcoords, scale, active):  # type: ignore[no-untyped-def]
    """The interpolated normal turned by a tangent-space normal map as glTF says; unit bitangent cross(n, t)·w."""
    active = active & (slot != NO_TEXTURE)
    tangent, handedness = mi.Vector4f(0.0), mi.Float(1.0)
    for k in range(3):
        corner = dr.gather(mi.Vector4f, device.tangents, corners[k], active)
        tangent += corner * barycentrics[k]
        handedness = corner.w if k == 0 else handedness
    along = dr.normalize(mi.Vector3f(tangent.x, tangent.y, tangent.z))
    n = dr.normalize(normal)
    across = dr.cross(n, along) * handedness
    local = texture_at(device, slot, texcoords, active, srgb=False) * 2.0 - 1.0
    mapped = along * (local.x * scale) + across * (local.y * scale) + n * local.z
    return dr.select(active, mapped, normal)
