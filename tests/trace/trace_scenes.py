"""Small scenes for the tests of trace/."""

import numpy as np

from reflet.scene.material import EnvironmentLight, Material
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.scene import Part, ReflectiveObject, Scene
from reflet.scene.surfaces.irradiance import IrradianceMap
from reflet.scene.views.camera import Camera

Vec3 = tuple[float, float, float]
CHROME = Material("chrome", base_color=(0.65, 0.65, 0.65), metallic=1.0, perceptual_roughness=0.0)


def constant_light(radiance: float) -> EnvironmentLight:
    return EnvironmentLight(np.full((4, 8, 3), radiance, np.float32))


def sphere(centre: Vec3 = (0.0, 0.0, 0.0), radius: float = 1.0, rows: int = 48) -> Mesh:
    """A finely tessellated sphere with its exact normals; fronts outside."""
    theta, phi = np.meshgrid(
        np.linspace(0.0, np.pi, rows + 1), np.linspace(0.0, 2.0 * np.pi, 2 * rows + 1), indexing="ij"
    )
    normal = np.stack([np.sin(theta) * np.cos(phi), np.cos(theta), np.sin(theta) * np.sin(phi)], -1).reshape(-1, 3)
    corner = (np.arange(rows)[:, None] * (2 * rows + 1) + np.arange(2 * rows)).ravel()
    right, below = corner + 1, corner + 2 * rows + 1
    triangles = np.concatenate([np.stack([corner, right, below + 1], -1), np.stack([corner, below + 1, below], -1)])
    points = normal[triangles]
    area = np.linalg.norm(np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0]), axis=-1)
    triangles = triangles[area > 1e-9]  # the poles' cells are triangles
    return Mesh(
        (np.asarray(centre) + radius * normal).astype(np.float32),
        normal.astype(np.float32),
        triangles.astype(np.uint32),
    )


def quad(corner: Vec3, along: Vec3, across: Vec3) -> Mesh:
    """A parallelogram whose front is where ``along`` × ``across`` points."""
    c, a, b = np.asarray(corner), np.asarray(along), np.asarray(across)
    normal = np.cross(a, b) / np.linalg.norm(np.cross(a, b))
    return Mesh(
        np.array([c, c + a, c + a + b, c + b], np.float32),
        np.tile(normal, (4, 1)).astype(np.float32),
        np.array([[0, 1, 2], [0, 2, 3]], np.uint32),
        np.array([[0, 0], [1, 0], [1, 1], [0, 1]], np.float32),
    )


def room(half: float = 1.0) -> Mesh:
    """A cube seen from inside: fronts point inwards."""
    h = half
    sides = [
        quad((-h, -h, -h), (0, 0, 2 * h), (2 * h, 0, 0)),
        quad((-h, h, -h), (2 * h, 0, 0), (0, 0, 2 * h)),
        quad((-h, -h, -h), (2 * h, 0, 0), (0, 2 * h, 0)),
        quad((-h, -h, h), (0, 2 * h, 0), (2 * h, 0, 0)),
        quad((-h, -h, -h), (0, 2 * h, 0), (0, 0, 2 * h)),
        quad((h, -h, -h), (0, 0, 2 * h), (0, 2 * h, 0)),
    ]
    return merged(sides)


def merged(meshes: list[Mesh]) -> Mesh:
    starts = np.cumsum([0] + [len(mesh.positions) for mesh in meshes])
    uv = [mesh.uv for mesh in meshes if mesh.uv is not None]
    return Mesh(
        np.concatenate([mesh.positions for mesh in meshes]),
        np.concatenate([mesh.normals for mesh in meshes]),
        np.concatenate([mesh.triangles + start for mesh, start in zip(meshes, starts[:-1], strict=True)]).astype(
            np.uint32
        ),
        np.concatenate(uv) if len(uv) == len(meshes) else None,
    )


def scene(parts: list[Part], groups: list[tuple[int, ...]], light: EnvironmentLight | None = None) -> Scene:
    return Scene(tuple(parts), tuple(ReflectiveObject(f"object{k}", group) for k, group in enumerate(groups)), light)


def camera(position: Vec3 = (0.0, 0.4, 4.0), size: int = 48, target: Vec3 = (0.0, 0.0, 0.0)) -> Camera:
    return Camera(position=position, target=target, width=size, height=size)


def no_irradiance(scene: Scene) -> IrradianceMap:
    none = np.zeros(scene.triangle_offsets[-1], np.uint32)
    return IrradianceMap(none, none, np.zeros((1, 3), np.float32))
