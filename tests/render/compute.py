"""Runs WGSL functions on arrays, to hold them to their NumPy twins."""

from collections.abc import Sequence

import numpy as np
import wgpu

from reflet.render.device.device import shared_device
from reflet.render.device.textures import upload_reliefs
from reflet.render.playback.layouts import FRAME
from reflet.shaders.link import link_text


def run(
    code: str,
    inputs: list[np.ndarray],
    floats_out: int,
    map_levels: Sequence[np.ndarray] | None = None,
    reliefs: Sequence[np.ndarray] | None = None,
) -> np.ndarray:
    """Runs ``code`` once for each row of the inputs, which are float32 of shape (n, k).

    ``code`` imports what it needs and is the body of a function that reads ``in0[k*i + …]``, ``in1[…]``, … and writes
    ``out[floats_out*i + …]``. ``map_levels``, mip levels as (layers, rows, columns, 4), are its ``maps``, a
    texture_2d_array; ``reliefs``, each (6, size, size) half floats, its ``reliefs``, a texture_cube_array, beside
    ``linear``.
    """
    device, count = shared_device(), len(inputs[0])
    declared = "".join(f"@group(2) @binding({k}) var<storage, read> in{k}: array<f32>;\n" for k in range(len(inputs)))
    lines = [line.strip() for line in code.splitlines()]
    imports = "".join(line + "\n" for line in lines if line.startswith("#import"))
    body = "\n".join(line for line in lines if not line.startswith("#import"))
    if map_levels is not None:
        declared += f"@group(2) @binding({len(inputs) + 1}) var maps: texture_2d_array<f32>;\n"
    if reliefs is not None:
        declared += f"@group(2) @binding({len(inputs) + 1}) var reliefs: texture_cube_array<f32>;\n"
        declared += f"@group(2) @binding({len(inputs) + 2}) var linear: sampler;\n"
    text = link_text(
        f"{imports}{declared}@group(2) @binding({len(inputs)}) var<storage, read_write> out: array<f32>;\n"
        "@compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3u) {\n"
        f"let i = id.x; if (i >= {count}u) {{ return; }}\n{body}\n}}\n"
    )
    storage = wgpu.BufferUsage.STORAGE
    buffers = [device.create_buffer_with_data(data=x.astype(np.float32).tobytes(), usage=storage) for x in inputs]
    result = device.create_buffer(size=4 * count * floats_out, usage=storage | wgpu.BufferUsage.COPY_SRC)
    pipeline = device.create_compute_pipeline(
        layout="auto", compute={"module": device.create_shader_module(code=text), "entry_point": "main"}
    )
    entries = [{"binding": k, "resource": {"buffer": b}} for k, b in enumerate([*buffers, result])]
    if map_levels is not None:
        entries.append({"binding": len(entries), "resource": _texture(map_levels)})
    if reliefs is not None:
        sampler = device.create_sampler(mag_filter="linear", min_filter="linear")
        entries += [
            {"binding": len(entries), "resource": upload_reliefs(device, reliefs)},
            {"binding": len(entries) + 1, "resource": sampler},
        ]
    encoder = device.create_command_encoder()
    compute_pass = encoder.begin_compute_pass()
    compute_pass.set_pipeline(pipeline)
    compute_pass.set_bind_group(2, device.create_bind_group(layout=pipeline.get_bind_group_layout(2), entries=entries))
    if "var<uniform> frame" in text:  # all zeros will do
        frame = device.create_buffer(size=FRAME.itemsize, usage=wgpu.BufferUsage.UNIFORM)
        layout = pipeline.get_bind_group_layout(0)
        group = device.create_bind_group(layout=layout, entries=[{"binding": 0, "resource": {"buffer": frame}}])
        compute_pass.set_bind_group(0, group)
    compute_pass.dispatch_workgroups(-(-count // 64))
    compute_pass.end()
    device.queue.submit([encoder.finish()])
    return np.frombuffer(device.queue.read_buffer(result), np.float32).reshape(count, floats_out)


def _texture(levels: Sequence[np.ndarray]) -> wgpu.GPUTextureView:
    layers, rows, columns, _ = levels[0].shape
    texture = shared_device().create_texture(
        size=(columns, rows, layers),
        format="rgba32float",
        mip_level_count=len(levels),
        usage=wgpu.TextureUsage.TEXTURE_BINDING | wgpu.TextureUsage.COPY_DST,
    )
    for k, level in enumerate(levels):
        layers, rows, columns, _ = level.shape
        shared_device().queue.write_texture(
            {"texture": texture, "mip_level": k},
            np.ascontiguousarray(level, np.float32),
            {"bytes_per_row": 16 * columns, "rows_per_image": rows},
            (columns, rows, layers),
        )
    return texture.create_view(dimension="2d-array")
