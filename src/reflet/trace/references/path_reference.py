"""The same picture by Mitsuba's own path integrator: what segmented tracing is tested and timed against."""

import warnings
from dataclasses import replace
from typing import Any

import mitsuba as mi
import numpy as np
from jaxtyping import Float32

from reflet.errors import RefletWarning
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.scene import Part, Scene
from reflet.scene.views.camera import Camera
from reflet.trace.references.materials import MaterialPlugins, radiance_of
from reflet.trace.references.placed_texture import add_attributes
from reflet.trace.references.punctual_emitter import punctual_emitter
from reflet.trace.variant import use_variant

NEAR = 1e-4  # of the camera's distance from its target: nothing in front of the lens is cut off
LANES = 1 << 22  # samples of a pass: they bound its memory
APART = 1e-5  # of a mesh's size: how far behind its front the back of a double-sided emitter lies

# Mitsuba's u is atan2(x', -z')/2π and ours 1/2 + atan2(z, x)/2π: it looks along x' = -z, z' = x.
ENVIRONMENT_FROM_WORLD = np.array([[0, 0, -1, 0], [0, 1, 0, 0], [1, 0, 0, 0], [0, 0, 0, 1]], np.float64)


class PathReference:
    """A scene with Mitsuba's shapes, textures and emitters: ``scene`` is Mitsuba's.

    ``materials`` are "mirrors", as segmented tracing has them: reflective parts mirror by the project's Fresnel term or
    are glass, others are diffuse, and normal maps are left out, with a RefletWarning; or "gltf": every part is of its
    whole material, normal maps and all (`gltf_bsdf`), or glass, whether it is reflective or not. ``single_scattering``
    takes glTF's appendix B to the letter, which loses light; by default materials keep it, as played back. Raises
    RefletError for other ``materials``.
    """

    def __init__(
        self,
        scene: Scene,
        *,
        materials: str = "mirrors",
        single_scattering: bool = False,
        variant: str = "llvm_ad_rgb",
    ) -> None:
        use_variant(variant)
        if materials == "mirrors" and any(part.material.normal_texture for part in scene.parts):
            warnings.warn("The path traced reference leaves normal maps out.", RefletWarning, stacklevel=2)
        plugins = MaterialPlugins(materials, single_scattering)
        described: dict[str, Any] = {"type": "scene"}
        for number, part in enumerate(scene.parts):
            described[f"part{number}"] = _shape(part, part.mesh, plugins)
            if part.material.emits and part.material.double_sided:
                described[f"back{number}"] = _shape(part, _turned(part.mesh), plugins)
        if scene.environment is not None:
            described["environment"] = environment_emitter(scene.environment.radiance)
        for number, light in enumerate(scene.lights):
            described[f"light{number}"] = punctual_emitter(light)
        self.scene = mi.load_dict(described)
        self._kind = "volpath" if any(plugins.absorbs(part) for part in scene.parts) else "path"

    def picture(
        self, camera: Camera, *, spp: int, max_depth: int = 32, seed: int = 0
    ) -> Float32[np.ndarray, "height width 3"]:
        """Path traced radiance with at least ``spp`` independent samples a pixel and box filter; ``max_depth`` counts a
        path's segments, 1 being what the camera sees emit."""
        integrator = mi.load_dict({"type": self._kind, "max_depth": max_depth, "rr_depth": max_depth + 1})
        passes = -(-spp * camera.width * camera.height // LANES)
        each = -(-spp // passes)
        sensor = self.sensor(camera, each)
        total = np.zeros((camera.height, camera.width, 3))
        for number in range(passes):
            image = mi.render(self.scene, sensor=sensor, integrator=integrator, spp=each, seed=seed * passes + number)
            total += np.asarray(image).reshape(total.shape)
        return (total / passes).astype(np.float32)

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


def _shape(part: Part, mesh: Mesh, plugins: MaterialPlugins) -> "mi.Mesh":
    material = part.material
    properties = mi.Properties()
    properties["bsdf"] = plugins.bsdf(part)
    if plugins.absorbs(part):
        absorption = material.refraction.absorption  # type: ignore[union-attr]
        densest = float(absorption.max())
        density = {"type": "rgb", "value": (absorption / densest).tolist()}
        medium = {"type": "homogeneous", "albedo": 0.0, "sigma_t": density, "scale": densest}
        properties["interior"] = mi.load_dict(medium)
    if material.emits:
        properties["emitter"] = mi.load_dict({"type": "area", "radiance": radiance_of(part)})
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
    add_attributes(shape, mesh)
    if plugins.bumpy(part):
        tangents = np.ascontiguousarray(mesh.tangents, np.float32)
        shape.add_attribute("vertex_tangent", 3, tangents[:, :3].ravel())
        shape.add_attribute("face_handedness", 1, tangents[mesh.triangles[:, 0], 3])
    return shape


def _turned(mesh: Mesh) -> Mesh:
    """The mesh seen from behind, as far behind its front as rays can tell apart.

    With tangents (-t, -w) it has minus the shading normals of the front: double-sided faces turn the whole normal.
    """
    apart = APART * float(np.ptp(mesh.positions, axis=0).max())
    return replace(
        mesh,
        positions=mesh.positions - apart * mesh.normals,
        normals=-mesh.normals,
        triangles=mesh.triangles[:, [0, 2, 1]],
        tangents=None if mesh.tangents is None else -mesh.tangents,
    )


def environment_emitter(radiance: np.ndarray) -> "mi.Emitter":
    """Mitsuba's emitter for a lat-long picture in the project's convention."""
    bitmap = mi.Bitmap(np.ascontiguousarray(radiance, np.float32))
    to_world = mi.ScalarTransform4f(np.linalg.inv(ENVIRONMENT_FROM_WORLD))
    return mi.load_dict({"type": "envmap", "bitmap": bitmap, "to_world": to_world})
