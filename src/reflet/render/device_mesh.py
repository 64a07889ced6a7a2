"""Meshes on the device, and pictures to draw them into."""

import numpy as np
import wgpu
from jaxtyping import Float32

from reflet.render.textures import check_size
from reflet.scene.mesh import Mesh

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
    """A colour texture of four floats a pixel, with depth: 20 bytes a pixel."""

    FORMAT = "rgba32float"

    def __init__(self, device: wgpu.GPUDevice, width: int, height: int) -> None:
        check_size(device, width, height, "A picture")
        self._device, self.size = device, (width, height)
        usage = wgpu.TextureUsage.RENDER_ATTACHMENT
        self._colour = device.create_texture(
            size=(width, height, 1), format=self.FORMAT, usage=usage | wgpu.TextureUsage.COPY_SRC
        )
        self._depth = device.create_texture(size=(width, height, 1), format="depth32float", usage=usage)

    def begin(self, encoder: wgpu.GPUCommandEncoder) -> wgpu.GPURenderPassEncoder:
        """A pass into the cleared picture."""
        return begin_pass(encoder, self._colour.create_view(), self._depth.create_view())

    def read(self) -> Float32[np.ndarray, "height width 4"]:
        """The pixels, row 0 at the top."""
        width, height = self.size
        data = self._device.queue.read_texture(
            {"texture": self._colour}, {"bytes_per_row": 16 * width, "rows_per_image": height}, (width, height, 1)
        )
        return np.frombuffer(data, np.float32).reshape(height, width, 4).copy()


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
