"""The same picture by Mitsuba's own path integrator: what segmented tracing is tested and timed against."""

import warnings
from typing import Any

import mitsuba as mi
import numpy as np
from jaxtyping import Float32

from reflet.errors import RefletWarning
from reflet.scene.material import Material, Refraction, Texture, Vec3
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.scene import Part, Scene
from reflet.scene.views.camera import Camera
from reflet.trace.references.mirror_bsdf import register_mirror
from reflet.trace.variant import use_variant

NEAR = 1e-4  # of the camera's distance from its target: nothing in front of the lens is cut off
APART = 1e-5  # of a mesh's size: how far behind its front the back of a double-sided emitter lies

# Mitsuba's u is atan2(x', -z')/2π and ours 1/2 + atan2(z, x)/2π: it looks along x' = -z, z' = x.
ENVIRONMENT_FROM_WORLD = np.array([[0, 0, -1, 0], [0, 1, 0, 0], [1, 0, 0, 0], [0, 0, 0, 1]], np.float64)


class PathReference:
    """A scene with Mitsuba's shapes, textures and emitters, its diffuse BSDFs and glass, and a mirror with the
    project's Fresnel term: ``scene`` is Mitsuba's. Normal maps are left out, with a RefletWarning."""

    def __init__(self, scene: Scene, *, variant: str = "llvm_ad_rgb") -> None:
        use_variant(variant)
        register_mirror()
        if any(part.material.normal_texture for part in scene.parts):
            warnings.warn("The path traced reference leaves normal maps out.", RefletWarning, stacklevel=2)
        described: dict[str, Any] = {"type": "scene"}
        for number, part in enumerate(scene.parts):
            described[f"part{number}"] = _shape(part, part.mesh)
            if any(part.material.emission) and part.material.double_sided:
                described[f"back{number}"] = _shape(part, _turned(part.mesh))
        if scene.environment is not None:
            described["environment"] = environment_emitter(scene.environment.radiance)
        self.scene = mi.load_dict(described)
        self._kind = "volpath" if any(_absorbs(part) for part in scene.parts) else "path"

    def picture(
        self, camera: Camera, *, spp: int, max_depth: int = 32, seed: int = 0
    ) -> Float32[np.ndarray, "height width 3"]:
        """Path traced radiance with ``spp`` independent samples a pixel and box filter; ``max_depth`` counts a path's
        segments, 1 being what the camera sees emit."""
        integrator = mi.load_dict({"type": self._kind, "max_depth": max_depth, "rr_depth": max_depth + 1})
        sensor = self.sensor(camera, spp)
        image = mi.render(self.scene, sensor=sensor, integrator=integrator, spp=spp, seed=seed)
        return np.asarray(image, np.float32).reshape(camera.height, camera.width, 3)

    def sensor(self, camera: Camera, spp: int) -> "mi.Sensor":
        """Mitsuba's sensor for a camera."""
        return mi.load_dict(sensor(camera, spp))

    def along(
        self, origin: Float32[np.ndarray, "rays 3"], direction: Float32[np.ndarray, "rays 3"], *, max_depth: int = 32
    ) -> Float32[np.ndarray, "rays 3"]:
        """One path's radiance along each ray; exact where nothing but emitters and perfect mirrors is met."""
        integrator = mi.load_dict({"type": self._kind, "max_depth": max_depth, "rr_depth": max_depth + 1})
        sampler = mi.load_dict({"type": "independent"})
        sampler.seed(0, len(origin))
        ray = mi.RayDifferential3f(mi.Ray3f(mi.Point3f(origin.T), mi.Vector3f(direction.T)))
        radiance, _, _ = integrator.sample(self.scene, sampler, ray)
        return np.stack([channel.numpy() for channel in radiance], -1)


def path_traced(
    scene: Scene, camera: Camera, *, spp: int, max_depth: int = 32, seed: int = 0
) -> Float32[np.ndarray, "height width 3"]:
    """One path traced picture of a scene; see `PathReference`."""
    return PathReference(scene).picture(camera, spp=spp, max_depth=max_depth, seed=seed)


def sensor(camera: Camera, spp: int) -> dict[str, Any]:
    distance = float(np.linalg.norm(np.subtract(camera.target, camera.position)))
    return {
        "type": "perspective",
        "fov": camera.fov_deg,
        "fov_axis": "y",
        "near_clip": NEAR * distance,
        "far_clip": 1e6 * distance,
        "to_world": mi.ScalarTransform4f().look_at(
            origin=list(camera.position), target=list(camera.target), up=list(camera.up)
        ),
        "sampler": {"type": "independent", "sample_count": spp},
        "film": {
            "type": "hdrfilm",
            "width": camera.width,
            "height": camera.height,
            "pixel_format": "rgb",
            "rfilter": {"type": "box"},
        },
    }


def _shape(part: Part, mesh: Mesh) -> "mi.Mesh":
    material = part.material
    properties = mi.Properties()
    properties["bsdf"] = mi.load_dict(_bsdf(part))
    if _absorbs(part):
        absorption = material.refraction.absorption  # type: ignore[union-attr]
        densest = float(absorption.max())
        density = {"type": "rgb", "value": (absorption / densest).tolist()}
        medium = {"type": "homogeneous", "albedo": 0.0, "sigma_t": density, "scale": densest}
        properties["interior"] = mi.load_dict(medium)
    if any(material.emission):
        radiance = _texture(material.emission, material.emission_texture_srgb, mesh)
        properties["emitter"] = mi.load_dict({"type": "area", "radiance": radiance})
    shape = mi.Mesh(
        part.name,
        len(mesh.positions),
        len(mesh.triangles),
        has_vertex_normals=True,
        has_vertex_texcoords=mesh.uv is not None,
        props=properties,
    )
    parameters = mi.traverse(shape)
    parameters["vertex_positions"] = np.ascontiguousarray(mesh.positions, np.float32).ravel()
    parameters["vertex_normals"] = np.ascontiguousarray(mesh.normals, np.float32).ravel()
    parameters["faces"] = np.ascontiguousarray(mesh.triangles, np.uint32).ravel()
    if mesh.uv is not None:
        parameters["vertex_texcoords"] = np.ascontiguousarray(mesh.uv, np.float32).ravel()
    parameters.update()
    return shape


def _absorbs(part: Part) -> bool:
    refraction = part.material.refraction
    return part.reflective and refraction is not None and bool(refraction.absorption.any())


def _turned(mesh: Mesh) -> Mesh:
    """The mesh seen from behind, as far behind its front as rays can tell apart."""
    apart = APART * float(np.ptp(mesh.positions, axis=0).max())
    return Mesh(mesh.positions - apart * mesh.normals, -mesh.normals, mesh.triangles[:, ::-1].copy(), mesh.uv)


def _bsdf(part: Part) -> dict[str, Any]:
    material = part.material
    color = _texture(material.base_color, material.base_color_texture_srgb, part.mesh)
    if part.reflective and material.refraction is not None:
        return _glass(material.refraction, material.base_color, part)
    if part.reflective:
        return {
            "type": "reflet_mirror",
            "base_color": color,
            "metallic": _metallic(material, part.mesh),
            "double_sided": material.double_sided,
        }
    diffuse = {"type": "diffuse", "reflectance": color}
    return {"type": "twosided", "bsdf": diffuse} if material.double_sided else diffuse


def _glass(refraction: Refraction, base_color: Vec3, part: Part) -> dict[str, Any]:
    """Mitsuba's own; without the diffuse light of what lets only some of it through."""
    r, g, b = (refraction.transmission * c for c in base_color)
    tint = _texture((r, g, b), part.material.base_color_texture_srgb, part.mesh)
    kind = "thindielectric" if refraction.thin else "dielectric"
    return {"type": kind, "int_ior": refraction.index, "ext_ior": 1.0, "specular_transmittance": tint}


def _texture(factor: tuple[float, float, float], texture: Texture | None, mesh: Mesh) -> dict[str, Any]:
    if texture is None or mesh.uv is None:
        return {"type": "srgb", "color": [float(c) for c in factor], "unbounded": True}
    code = texture.pixels[..., :3].astype(np.float64) / 255.0
    linear = np.where(code <= 0.04045, code / 12.92, ((code + 0.055) / 1.055) ** 2.4)
    return _bitmap(linear * np.asarray(factor), texture.clamp)


def _metallic(material: Material, mesh: Mesh) -> dict[str, Any]:
    texture = material.metallic_roughness_texture
    if texture is None or mesh.uv is None:
        return {"type": "uniform", "value": float(material.metallic)}
    return _bitmap(texture.pixels[..., 2:3] / 255.0 * material.metallic, texture.clamp)


def _bitmap(linear: np.ndarray, clamp: bool) -> dict[str, Any]:
    return {
        "type": "bitmap",
        "data": mi.TensorXf(np.ascontiguousarray(linear, np.float32)),
        "raw": True,
        "wrap_mode": "clamp" if clamp else "repeat",
    }


def environment_emitter(radiance: np.ndarray) -> "mi.Emitter":
    """Mitsuba's emitter for a lat-long picture in the project's convention."""
    bitmap = mi.Bitmap(np.ascontiguousarray(radiance, np.float32))
    to_world = mi.ScalarTransform4f(np.linalg.inv(ENVIRONMENT_FROM_WORLD))
    return mi.load_dict({"type": "envmap", "bitmap": bitmap, "to_world": to_world})
