"""Small scenes and pictures made without a ray tracer."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse

from reflet.infer.records import RenderingMatrix
from reflet.scene.material import Material
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.scene import Part, ReflectiveObject, Scene
from reflet.scene.surfaces.gbuffer import GBuffer
from reflet.scene.surfaces.surface import gbuffer_from_visibility
from reflet.scene.surfaces.visibility import Visibility
from reflet.scene.views.camera import Camera
from reflet.scene.views.sample_pattern import sample_positions
from reflet.trace.layers import SegmentedLayers


def sphere_mesh(radius: float = 1.0, rings: int = 12, centre: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Mesh:
    """A sphere of latitude rings with exact normals."""
    theta, phi = np.meshgrid(np.linspace(0, np.pi, rings + 1), np.linspace(0, 2 * np.pi, 2 * rings + 1), indexing="ij")
    normals = np.stack([np.sin(theta) * np.cos(phi), np.cos(theta), -np.sin(theta) * np.sin(phi)], -1).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(rings), np.arange(2 * rings), indexing="ij")
    a = (i * (2 * rings + 1) + j).ravel()
    b, c, d = a + 2 * rings + 1, a + 2 * rings + 2, a + 1
    triangles = np.concatenate([np.stack([a, b, c], -1)[i.ravel() < rings - 1], np.stack([a, c, d], -1)[i.ravel() > 0]])
    positions = np.asarray(centre) + radius * normals
    return Mesh(positions.astype(np.float32), normals.astype(np.float32), triangles.astype(np.uint32))


def mirror_scene(*meshes: Mesh, double_sided: bool = False) -> Scene:
    """The meshes as the parts of one mirror object."""
    material = Material(perceptual_roughness=0.0, double_sided=double_sided)
    parts = tuple(Part(f"part{i}", mesh, material, reflective=True) for i, mesh in enumerate(meshes))
    return Scene(parts, (ReflectiveObject("object", tuple(range(len(parts)))),))


def cast_visibility(scene: Scene, camera: Camera, sample_count: int) -> Visibility:
    """The nearest front face under every sub-sample, each ray against every triangle."""
    corners = np.concatenate([part.mesh.positions[part.mesh.triangles] for part in scene.parts]).astype(np.float64)
    corner, dx, dy = camera.ray_basis()
    pixel, sub_sample = np.divmod(np.arange(camera.width * camera.height * sample_count), sample_count)
    xy = np.stack([pixel % camera.width, pixel // camera.width], -1) + sample_positions(sample_count)[sub_sample]
    direction = corner + xy[:, :1] * dx + xy[:, 1:] * dy
    e1, e2 = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    w = np.asarray(camera.position) - corners[:, 0]
    normal, q = np.cross(e1, e2), np.cross(w, e1)
    best = np.full(len(pixel), -1)
    for start in range(0, len(pixel), 4096):
        d = direction[start : start + 4096]
        det = -d @ normal.T
        with np.errstate(divide="ignore", invalid="ignore"):
            b1, b2 = (d @ np.cross(e2, w).T) / det, (d @ q.T) / det
            t = np.einsum("ti,ti->t", e2, q) / det
        hit = (det > 0) & (b1 >= 0) & (b2 >= 0) & (b1 + b2 <= 1) & (t > 0)
        nearest = np.where(hit, t, np.inf).argmin(1)
        best[start : start + 4096] = np.where(hit.any(1), nearest, -1)
    seen = best >= 0
    return Visibility(
        camera,
        sample_count,
        pixel[seen].astype(np.int32),
        sub_sample[seen].astype(np.int32),
        best[seen].astype(np.uint32),
    )


@dataclass(frozen=True)
class Picture:
    """A scene seen by a camera, and its G-buffer."""

    scene: Scene
    visibility: Visibility
    gbuffer: GBuffer


def picture(scene: Scene, eye: tuple[float, float, float], size: int, sample_count: int = 16) -> Picture:
    """The scene from ``eye``, looking at the origin."""
    visibility = cast_visibility(scene, Camera(eye, (0.0, 0.0, 0.0), width=size, height=size), sample_count)
    return Picture(scene, visibility, gbuffer_from_visibility(scene, visibility))


def as_scipy(matrix: RenderingMatrix) -> scipy.sparse.csr_matrix:
    """The matrix in scipy's keeping, in float64."""
    shape = (len(matrix.starts) - 1, matrix.texel_count)
    return scipy.sparse.csr_matrix((matrix.weights.astype(np.float64), matrix.columns, matrix.starts), shape=shape)


def layers_of(seen: Picture, shells: np.ndarray, local: np.ndarray) -> SegmentedLayers:
    """Layers as a ray tracer would hand them on: ``shells`` (rows, shells, 4) and ``local`` (rows, 4)."""
    gbuffer, rows, camera = seen.gbuffer, len(seen.gbuffer.row_pixel), seen.visibility.camera
    distant = np.zeros((rows, 3))
    for number in reversed(range(shells.shape[1])):
        distant = shells[:, number, :3] + (1.0 - shells[:, number, 3:]) * distant
    return SegmentedLayers(
        camera=camera,
        pixel=gbuffer.row_pixel,
        part=gbuffer.row_part,
        coverage=(np.bincount(gbuffer.row_of_sample) / seen.visibility.sample_count).astype(np.float32),
        diffuse=np.zeros((rows, 3), np.float32),
        fresnel=np.ones((rows, 3), np.float32),
        distant=distant.astype(np.float32),
        local=local[:, :3].astype(np.float32),
        alpha=local[:, 3].astype(np.float32),
        combined=(local[:, :3] + (1.0 - local[:, 3:]) * distant).astype(np.float32),
        surroundings=np.zeros((camera.height, camera.width, 3), np.float32),
        shells=shells.astype(np.float32),
    )
