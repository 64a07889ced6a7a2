"""Where pictures are drawn from, and onto what: the host's side of `shaders/view.wgsl`."""

from collections.abc import Sequence

import numpy as np
import wgpu
from jaxtyping import Float

from reflet.envmap.parameterizations.cube import AXES
from reflet.scene.views.camera import Camera, Vec3

Rotation = Float[np.ndarray, "3 3"]

VIEW = np.dtype(
    [
        ("clip_from_world", "f4", (4, 4)), ("eye", "f4", 3), ("near", "f4"), ("ray_corner", "f4", 3),
        ("front_is_clockwise", "u4"), ("ray_dx", "f4", 3), ("face", "u4"), ("ray_dy", "f4", 3), ("row", "f4"),
    ]
)  # fmt: skip

# The near plane's distance as a share of the target's. Depth is floating and reversed, so it may be small.
_NEAR_SHARE = 1e-3


def camera_view(camera: Camera) -> np.ndarray:
    """`VIEW` of a camera."""
    near = _NEAR_SHARE * float(np.linalg.norm(np.subtract(camera.target, camera.position)))
    clip_from_world = camera.clip_from_world(1.0, 2.0)
    clip_from_world[2] = 0.0, 0.0, 0.0, near  # reversed: near/distance, which floats resolve evenly at all distances
    view = np.zeros((), VIEW)
    view["clip_from_world"], view["eye"], view["near"] = clip_from_world.T, camera.position, near
    view["ray_corner"], view["ray_dx"], view["ray_dy"] = camera.ray_basis()
    return view


def face_view(face: int, size: int) -> np.ndarray:
    """`VIEW` of a whole face of a map of ``size`` rows, into which other maps are drawn."""
    view = np.zeros((), VIEW)
    view["face"], view["row"] = face, 1.0 / size
    return view


def cube_view(face: int, size: int, eye: Vec3, near: float, map_from_world: Rotation) -> np.ndarray:
    """`VIEW` of 90° from ``eye`` onto a cube's face.

    A face's s runs right, its t down: seen from inside, that is a mirrored picture, where fronts come out clockwise.
    """
    outward, right, down = AXES[face] @ map_from_world
    clip_from_world = _seen_from(eye, np.stack([right, -down, np.zeros(3), outward]))
    clip_from_world[2, 3] = near
    return _onto_face(face, size, clip_from_world, eye, near, mirrors=True)


def paraboloid_view(face: int, size: int, eye: Vec3, near: float, map_from_world: Rotation) -> np.ndarray:
    """`VIEW` from ``eye`` onto a face of a dual paraboloid: ``clip_from_world`` only leads into the map's space.

    The front's picture is mirrored, with x to the right as z comes towards the viewer; the back's is not.
    """
    affine = _seen_from(eye, np.concatenate([map_from_world, np.zeros((1, 3))]))
    affine[3, 3] = 1.0
    return _onto_face(face, size, affine, eye, near, mirrors=face == 0)


def _seen_from(eye: Vec3, linear: Float[np.ndarray, "4 3"]) -> Float[np.ndarray, "4 4"]:
    """The linear map of what lies around ``eye``."""
    return np.concatenate([linear, -(linear @ np.asarray(eye))[:, None]], 1)


def _onto_face(
    face: int, size: int, clip_from_world: Float[np.ndarray, "4 4"], eye: Vec3, near: float, mirrors: bool
) -> np.ndarray:
    view = np.zeros((), VIEW)
    view["clip_from_world"], view["eye"], view["near"] = clip_from_world.T, eye, near
    view["front_is_clockwise"], view["face"], view["row"] = mirrors, face, 1.0 / size
    return view


def view_layout(device: wgpu.GPUDevice) -> wgpu.GPUBindGroupLayout:
    """Bind group 0."""
    vertex, both = wgpu.ShaderStage.VERTEX, wgpu.ShaderStage.VERTEX | wgpu.ShaderStage.FRAGMENT
    return device.create_bind_group_layout(
        entries=[
            {"binding": 0, "visibility": both, "buffer": {"type": "uniform"}},
            {"binding": 1, "visibility": vertex, "buffer": {"type": "read-only-storage"}},
        ]
    )


class Views:
    """Bind groups for several views of the same meshes; written anew for every frame."""

    def __init__(
        self, device: wgpu.GPUDevice, layout: wgpu.GPUBindGroupLayout, view_count: int, mesh_count: int
    ) -> None:
        self._device = device
        uniform, storage = wgpu.BufferUsage.UNIFORM, wgpu.BufferUsage.STORAGE
        write = wgpu.BufferUsage.COPY_DST
        self._transforms = device.create_buffer(size=64 * mesh_count, usage=storage | write)
        self._uniforms = [device.create_buffer(size=VIEW.itemsize, usage=uniform | write) for _ in range(view_count)]
        self.groups = [
            device.create_bind_group(
                layout=layout,
                entries=[
                    {"binding": 0, "resource": {"buffer": each}},
                    {"binding": 1, "resource": {"buffer": self._transforms}},
                ],
            )
            for each in self._uniforms
        ]

    def write(self, views: Sequence[np.ndarray], world_from_mesh: Float[np.ndarray, "meshes 4 4"]) -> None:
        """New views, and new places of the meshes: rigid transforms."""
        for buffer, view in zip(self._uniforms, views, strict=True):
            self._device.queue.write_buffer(buffer, 0, view.tobytes())
        columns = np.ascontiguousarray(world_from_mesh.transpose(0, 2, 1), np.float32)
        self._device.queue.write_buffer(self._transforms, 0, columns.tobytes())
