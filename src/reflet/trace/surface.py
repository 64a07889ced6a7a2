"""What a ray meets: position, normals and material of a hit, gathered from a `DeviceScene`."""

from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi

from reflet.scene.roughness import LEAST_ROUGHNESS
from reflet.trace.coat import Coat, coat_at
from reflet.trace.device_scene import DOUBLE_SIDED, GONE_THROUGH, OBJECT_SHIFT, UNLIT, DeviceScene
from reflet.trace.glass import glass_reflectance, refracted
from reflet.trace.lobe import GlossyLobe
from reflet.trace.textured import interpolated, more_uv, normal_mapped, texture_at, unit

BEND = 1e-3  # least cosine between a mirrored ray and the geometric normal, see CONVENTIONS.md
OFFSET = 1e-5  # a ray starts this far off its surface, in units of the largest coordinate there


@dataclass
class Surface:
    """Hits of many rays at once. ``visible`` are those of a front, or of either side of a double-sided face;
    ``gone_through`` are those that distant light goes through, as the device says.

    ``back`` tells that it is the back, whether it is visible or not. ``glow`` is the radiance that leaves towards the
    ray without mirroring: emission, and diffuse colour times radiosity. ``reflects`` marks visible reflective parts,
    whose Fresnel reflectance and mirrored ray are ``fresnel`` and ``mirrored``. The unit geometric normal faces the
    ray, the interpolated ``smooth_normal`` is as the mesh has it. A new ray starts ``offset`` metres off the surface.

    ``passes`` marks what is of glass and reflects, where scenes have any: what is not reflected goes on along
    ``refracted``, times ``transmittance``. ``absorption``, per metre, is that of the inside; 0 of thin sheets.

    ``rough`` marks what reflects by a ``lobe``, where scenes have any: its F is Schlick's of ``f0`` and ``f90``, which
    count light that bounces between microfacets; ``albedo`` is what it would reflect of constant light for F = 1. There
    ``fresnel`` is the directional albedo, and diffuse is what the dielectric's leaves.

    Where scenes have any ``coat``, all these reflectances are of what gets through it.
    """

    visible: Any
    back: Any
    part: Any
    object: Any
    gone_through: Any
    reflects: Any
    position: Any
    offset: Any
    geometric_normal: Any
    smooth_normal: Any
    diffuse: Any
    emission: Any
    glow: Any
    fresnel: Any
    mirrored: Any
    passes: Any = False
    refracted: Any = None
    transmittance: Any = 0.0
    absorption: Any = 0.0
    rough: Any = False
    lobe: GlossyLobe | None = None
    f0: Any = None
    f90: Any = None
    albedo: Any = 1.0
    coat: Coat | None = None


def surface_at(device: DeviceScene, triangle, uv, direction, valid) -> Surface:  # type: ignore[no-untyped-def]
    """The surface of scene triangles ``triangle`` at barycentrics ``uv`` (of the second and third vertex), for rays
    along the unit vectors ``direction``. Lanes that are not ``valid`` hold no meaning."""
    corners = dr.gather(mi.Vector4u, device.corners, triangle, valid)
    part = corners.w
    b1, b2 = uv.x, uv.y
    b0 = 1.0 - b1 - b2
    p = [dr.gather(mi.Vector4f, device.position_u, corners[k], valid) for k in range(3)]
    q = [dr.gather(mi.Vector4f, device.normal_v, corners[k], valid) for k in range(3)]
    at = p[0] * b0 + p[1] * b1 + p[2] * b2
    bt = q[0] * b0 + q[1] * b1 + q[2] * b2
    texcoords = [mi.Point2f(at.w, bt.w), *more_uv(device, corners, (b0, b1, b2), valid)]
    position = mi.Point3f(at.x, at.y, at.z)
    extent = dr.maximum(dr.max(dr.abs(position)), dr.max(dr.abs(mi.Vector3f(p[0].x, p[0].y, p[0].z))))

    flags = dr.gather(mi.UInt32, device.part_flags, part, valid)
    owner = flags >> OBJECT_SHIFT
    edge1, edge2 = (mi.Vector3f(v.x, v.y, v.z) for v in (p[1] - p[0], p[2] - p[0]))
    geometric = dr.select(valid, dr.normalize(dr.cross(edge1, edge2)), -direction)  # never NaN
    from_behind = dr.dot(geometric, direction) > 0.0
    double_sided = (flags & DOUBLE_SIDED) != 0
    visible = valid & (~from_behind | double_sided)
    geometric = dr.select(from_behind, -geometric, geometric)

    slots = dr.gather(mi.Vector4u, device.part_textures, part, valid)
    color_metallic = dr.gather(mi.Vector4f, device.part_color_metallic, part, valid)
    emission_scale = dr.gather(mi.Vector4f, device.part_emission_scale, part, valid)
    base_color = mi.Color3f(color_metallic.x, color_metallic.y, color_metallic.z)
    metallic = color_metallic.w
    roughness = dr.gather(mi.Float, device.part_roughness, part, valid) if device.has_rough else mi.Float(0.0)
    emission = mi.Color3f(emission_scale.x, emission_scale.y, emission_scale.z)
    normal = mi.Vector3f(bt.x, bt.y, bt.z)
    if device.has_colors:
        color = interpolated(mi.Vector4f, device.colors, corners, (b0, b1, b2), visible)
        base_color *= mi.Color3f(color.x, color.y, color.z)
    if device.has_textures:
        base_color *= texture_at(device, slots.x, texcoords, visible, srgb=True)
        other = texture_at(device, slots.y, texcoords, visible & (owner > 0), srgb=False)
        metallic *= other.z
        roughness *= other.y
        emission *= texture_at(device, slots.w, texcoords, visible, srgb=True)
    smooth = unit(normal, geometric)
    unbent = dr.select(dr.dot(smooth, geometric) < 0.0, -smooth, smooth)
    if device.has_normal_maps:
        normal = normal_mapped(device, corners, (b0, b1, b2), normal, slots.z, texcoords, emission_scale.w, visible)
    normal = unit(normal, geometric)
    normal = dr.select(dr.dot(normal, geometric) < 0.0, -normal, normal)

    reflects = visible & (owner > 0)
    diffuse = dr.select(reflects, base_color * (1.0 - metallic), base_color)
    dielectric = dr.gather(mi.Vector4f, device.part_dielectric, part, valid)
    f0 = base_color * metallic + mi.Color3f(dielectric.x, dielectric.y, dielectric.z) * (1.0 - metallic)
    f90 = metallic + dielectric.w * (1.0 - metallic)
    mirrored = direction - 2.0 * dr.dot(direction, normal) * normal
    above = dr.dot(mirrored, geometric)
    mirrored = dr.select(above < BEND, dr.normalize(mirrored + (BEND - above) * geometric), mirrored)
    cosine = dr.minimum(0.5 * dr.norm(mirrored - direction), 1.0)  # n·v, of bent rays about the normal that bends them
    grazing = dr.square(dr.square(1.0 - cosine)) * (1.0 - cosine)
    fresnel = f0 + (f90 - f0) * grazing
    passes, glass = mi.Bool(False), {}
    if device.has_glass:
        table = dr.gather(mi.Vector4f, device.part_glass, part, valid)
        index, transmission, thin = table.x, table.y, table.z > 0.5
        passes = reflects & (index > 0.0)
        index = dr.select(passes, index, 1.0)
        diffuse = dr.select(passes, base_color * (1.0 - transmission), diffuse)
        fresnel = dr.select(passes, mi.Color3f(glass_reflectance(cosine, index, from_behind, thin)), fresnel)
        dense = dr.gather(mi.Vector4f, device.part_absorption, part, valid)
        glass = {
            "refracted": refracted(direction, normal, geometric, index, from_behind, thin),
            "transmittance": base_color * transmission,
            "absorption": dr.select(passes, mi.Color3f(dense.x, dense.y, dense.z), 0.0),
        }
    rough: dict[str, Any] = {}
    if device.has_rough:
        lobe = GlossyLobe(-direction, normal, geometric, roughness)
        by_lobe = reflects & ~passes & (roughness >= LEAST_ROUGHNESS)
        a, b = dfg_at(device, lobe.n_dot_v, roughness)
        lost = 1.0 / (a + b) - 1.0
        facing, grazing = mi.Color3f(dielectric.x, dielectric.y, dielectric.z), dielectric.w
        paint, metal = 1.0 + facing * lost, 1.0 + base_color * lost
        f0 = dr.lerp(facing * paint, base_color * metal, metallic)
        f90 = dr.lerp(grazing * paint, metal, metallic)
        rough = {"rough": by_lobe, "lobe": lobe, "f0": f0, "f90": f90, "albedo": a + b}
        fresnel = dr.select(by_lobe, f0 * a + f90 * b, fresnel)
        diffuse *= dr.select(by_lobe, 1.0 - (facing * a + grazing * b) * paint, 1.0)
    coat = None
    if device.has_coats:
        weights = b0, b1, b2
        above = mi.Vector3f(bt.x, bt.y, bt.z)
        coat = coat_at(device, part, corners, weights, texcoords, above, geometric, direction, reflects & ~passes)
        below = 1.0 - coat.fresnel
        fresnel, diffuse = fresnel * below, diffuse * below
        rough |= {"f0": rough["f0"] * below, "f90": rough["f90"] * below}
    unlit = (flags & UNLIT) != 0
    emission = dr.select(unlit, base_color, emission)
    diffuse = dr.select(unlit, 0.0, diffuse)
    radiosity = radiosity_at(device, triangle, b1, b2, from_behind, visible, normal - unbent)
    return Surface(
        visible=visible,
        back=from_behind,
        part=part,
        object=owner - 1,
        gone_through=(flags & GONE_THROUGH) != 0,
        reflects=reflects,
        position=position,
        offset=extent * OFFSET,
        geometric_normal=geometric,
        smooth_normal=smooth,
        diffuse=diffuse,
        emission=emission,
        glow=dr.select(visible, emission + diffuse * radiosity, 0.0),
        fresnel=fresnel,
        mirrored=mirrored,
        passes=passes,
        coat=coat,
        **glass,
        **rough,
    )


def dfg_at(device: DeviceScene, n_dot_v, perceptual_roughness):  # type: ignore[no-untyped-def]
    """A and B, as of `dfg_lookup`."""
    rows, columns = device.dfg.shape[:2]
    x = (dr.sqrt(n_dot_v) * (columns - 1.0) + 0.5) / columns
    y = (perceptual_roughness * (rows - 1.0) + 0.5) / rows
    return device.dfg.eval(mi.Point2f(x, y))


def alpha_at(device: DeviceScene, triangle, uv, valid):  # type: ignore[no-untyped-def]
    """Alpha of scene triangles at barycentrics, and what it is compared with: 0 of opaque surfaces, below 0 of blended
    ones."""
    corners = dr.gather(mi.Vector4u, device.corners, triangle, valid)
    part, weights = corners.w, (1.0 - uv.x - uv.y, uv.x, uv.y)
    table = dr.gather(mi.Vector2f, device.part_alpha, part, valid)
    alpha = table.x
    if device.has_colors:
        alpha = alpha * interpolated(mi.Vector4f, device.colors, corners, weights, valid).w
    if device.has_textures:
        slots = dr.gather(mi.Vector4u, device.part_textures, part, valid)
        u = interpolated(mi.Vector4f, device.position_u, corners, weights, valid).w
        v = interpolated(mi.Vector4f, device.normal_v, corners, weights, valid).w
        texcoords = [mi.Point2f(u, v), *more_uv(device, corners, weights, valid)]
        alpha = alpha * texture_at(device, slots.x, texcoords, valid, srgb=False, alpha=True).x
    return alpha, table.y


def radiosity_at(device: DeviceScene, triangle, b1, b2, back, active, bend):  # type: ignore[no-untyped-def]
    """Irradiance/π from the mesh colours, linear in each small triangle; black where there are none. ``bend`` is what
    the unit normal has more than the interpolated one."""
    grid = dr.gather(mi.Vector2u, device.radiosity_grid, triangle, active)
    resolution = grid.x
    active = active & (resolution > 0)
    x, y = dr.maximum(b1, 0.0) * resolution, dr.maximum(b2, 0.0) * resolution
    # Column i and row j of the small square; on the far edge the last square serves.
    i = dr.minimum(mi.UInt32(x), dr.maximum(resolution, 1) - 1)
    j = dr.minimum(mi.UInt32(y), dr.maximum(resolution, 1 + i) - 1 - i)
    fx, fy = x - i, y - j
    upper = (fx + fy > 1.0) & (i + j + 1 < resolution)
    # Weights of the corner the small triangle keeps, and of its neighbours (i + 1, j) and (i, j + 1).
    w_x, w_y = dr.select(upper, 1.0 - fy, fx), dr.select(upper, 1.0 - fx, fy)
    step = dr.select(upper, mi.UInt32(1), mi.UInt32(0))
    start = grid.y + dr.select(back, (resolution + 1) * (resolution + 2) // 2, 0)

    def index(a, b):  # type: ignore[no-untyped-def]
        return start + a * (2 * resolution + 3 - a) // 2 + b

    corners = index(i + step, j + step), index(i + 1, j), index(i, j + 1)

    def mean(table):  # type: ignore[no-untyped-def]
        return interpolated(mi.Vector4f, table, corners, (1.0 - w_x - w_y, w_x, w_y), active)

    value = mean(device.radiosity)
    radiosity = mi.Color3f(value.x, value.y, value.z)
    if not device.has_gradients:
        return radiosity
    gradient = mean(device.gradient)
    change = dr.dot(mi.Vector3f(gradient.x, gradient.y, gradient.z), bend)
    return radiosity * dr.maximum(1.0 + change / dr.maximum(luminance(radiosity), 1e-20), 0.0)


def luminance(color):  # type: ignore[no-untyped-def]
    """Of linear Rec. 709."""
    return 0.2126 * color.x + 0.7152 * color.y + 0.0722 * color.z


def environment_radiance(device: DeviceScene, direction, active):  # type: ignore[no-untyped-def]
    """Radiance of the environment light along unit directions, bilinear between the centres of its pixels."""
    if device.scene.environment is None:
        return mi.Color3f(0.0)
    value = sky_lookup(device, device.environment, direction, active)
    return mi.Color3f(value.x, value.y, value.z)


def sky_lookup(device: DeviceScene, table, direction, active):  # type: ignore[no-untyped-def]
    """A table of four floats for each pixel of the environment light, bilinear: around in u, repeating the last row."""
    height, width = device.environment_size
    x = (0.5 + dr.atan2(direction.z, direction.x) * dr.inv_two_pi) * width - 0.5
    y = dr.safe_acos(direction.y) * dr.inv_pi * height - 0.5
    fx, fy = dr.floor(x), dr.floor(y)
    column, row = mi.Int32(fx), mi.Int32(fy)

    def pixel(dx: int, dy: int):  # type: ignore[no-untyped-def]
        c = column + dx
        c = dr.select(c < 0, c + width, dr.select(c >= width, c - width, c))
        r = dr.clip(row + dy, 0, height - 1)
        return dr.gather(mi.Vector4f, table, mi.UInt32(r * width + c), active)

    top = dr.lerp(pixel(0, 0), pixel(1, 0), x - fx)
    bottom = dr.lerp(pixel(0, 1), pixel(1, 1), x - fx)
    return dr.lerp(top, bottom, y - fy)
