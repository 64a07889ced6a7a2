"""Meshes on the device, and pictures to draw them into."""

from dataclasses import replace

import numpy as np
import wgpu
from jaxtyping import Float32

from reflet.errors import RefletError
from reflet.render.device.textures import check_size
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.views.camera import Camera

VERTEX_BUFFERS = [
    {
        "array_stride": 32,
        "attributes": [
            {"shader_location": 0, "offset": 0, "format": "float32x3"},
            {"shader_location": 1, "offset": 12, "format": "float32x3"},
            {"shader_location": 2, "offset": 24, "format": "float32x2"},
        ],
    }
]


class DeviceMesh:
    """Position, normal and uv of every vertex (`Vertex` in `shaders/view.wgsl`), and triangles."""

    def __init__(self, device: wgpu.GPUDevice, mesh: Mesh) -> None:
        uv = np.zeros((len(mesh.positions), 2), np.float32) if mesh.uv is None else mesh.uv
        vertices = np.concatenate([mesh.positions, mesh.normals, uv], 1)
        usage = wgpu.BufferUsage
        self._vertices = device.create_buffer_with_data(data=vertices.tobytes(), usage=usage.VERTEX)
        self._triangles = device.create_buffer_with_data(
            data=np.ascontiguousarray(mesh.triangles).tobytes(), usage=usage.INDEX
        )
        self._count = mesh.triangles.size

    def draw(self, render_pass: wgpu.GPURenderPassEncoder, instance: int = 0) -> None:
        """Draws all triangles with the transform of this number."""
        render_pass.set_vertex_buffer(0, self._vertices)
        render_pass.set_index_buffer(self._triangles, "uint32")
        render_pass.draw_indexed(self._count, 1, 0, 0, instance)


class Picture:
    """What a camera sees, with 1, 4 or 16 samples a pixel in a regular grid: 20 bytes a sample."""

    FORMAT = "rgba32float"

    def __init__(self, device: wgpu.GPUDevice, camera: Camera, samples: int = 1) -> None:
        if samples not in (1, 4, 16):
            raise RefletError(f"A picture has 1, 4 or 16 samples a pixel, not {samples}.")
        self._device, self._per_axis = device, round(samples**0.5)
        # The same view with a pixel for every sample.
        self.camera = replace(camera, width=camera.width * self._per_axis, height=camera.height * self._per_axis)
        width, height = self.camera.width, self.camera.height
        check_size(device, width, height, "A picture")
        usage = wgpu.TextureUsage.RENDER_ATTACHMENT
        self._colour = device.create_texture(
            size=(width, height, 1), format=self.FORMAT, usage=usage | wgpu.TextureUsage.COPY_SRC
        )
        self._depth = device.create_texture(size=(width, height, 1), format="depth32float", usage=usage)

    def begin(self, encoder: wgpu.GPUCommandEncoder) -> wgpu.GPURenderPassEncoder:
        """A pass into the cleared picture."""
        return begin_pass(encoder, self._colour.create_view(), self._depth.create_view())

    def read(self) -> Float32[np.ndarray, "height width 4"]:
        """The pixels, row 0 at the top: means of their samples."""
        width, height, n = self.camera.width, self.camera.height, self._per_axis
        data = self._device.queue.read_texture(
            {"texture": self._colour}, {"bytes_per_row": 16 * width, "rows_per_image": height}, (width, height, 1)
        )
        samples = np.frombuffer(data, np.float32).reshape(height // n, n, width // n, n, 4)
        return samples.mean((1, 3), dtype=np.float32)


def begin_pass(
    encoder: wgpu.GPUCommandEncoder, colour: wgpu.GPUTextureView, depth: wgpu.GPUTextureView
) -> wgpu.GPURenderPassEncoder:
    """A pass into cleared textures; depth is reversed."""
    return encoder.begin_render_pass(
        color_attachments=[{"view": colour, "clear_value": (0, 0, 0, 0), "load_op": "clear", "store_op": "store"}],
        depth_stencil_attachment={
            "view": depth,
            "depth_clear_value": 0.0,
            "depth_load_op": "clear",
            "depth_store_op": "discard",
        },
    )


def depth_state(backdrop: bool) -> dict:
    """Of pipelines that draw meshes, or what lies infinitely far behind them."""
    return {
        "format": "depth32float",
        "depth_write_enabled": not backdrop,
        "depth_compare": "greater-equal" if backdrop else "greater",
    }
