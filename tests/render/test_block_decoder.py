"""Blocks of random bits, in every mode there is, as the decoder library and the graphics system read them."""

import numpy as np
import pytest
import wgpu

from reflet.files.textures.texel_formats import TEXEL_FORMATS
from reflet.render.device.device import shared_device

SIZE = 128
SHADER = """
@group(0) @binding(0) var blocks: texture_2d<f32>;
@group(0) @binding(1) var<storage, read_write> texels: array<vec4f>;
@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) at: vec3u) {
    texels[at.y * textureDimensions(blocks).x + at.x] = textureLoad(blocks, at.xy, 0);
}
"""


@pytest.fixture(name="decode")
def _decode():
    adapter = shared_device().adapter
    if "texture-compression-bc" not in adapter.features:
        pytest.skip("this adapter reads no blocks")
    if "SwiftShader" in adapter.info["device"]:
        pytest.skip("SwiftShader reads blocks in fragment shaders only")
    device = adapter.request_device_sync(required_features=["texture-compression-bc"])

    def decode(texture_format, stored):
        size = (SIZE, SIZE, 1)
        usage = wgpu.TextureUsage.TEXTURE_BINDING | wgpu.TextureUsage.COPY_DST
        texture = device.create_texture(size=size, format=texture_format, usage=usage)
        layout = {"bytes_per_row": SIZE // 4 * 16, "rows_per_image": SIZE // 4}
        device.queue.write_texture({"texture": texture}, stored, layout, size)
        usage = wgpu.BufferUsage.STORAGE | wgpu.BufferUsage.COPY_SRC
        texels = device.create_buffer(size=16 * SIZE * SIZE, usage=usage)
        module = device.create_shader_module(code=SHADER)
        pipeline = device.create_compute_pipeline(layout="auto", compute={"module": module, "entry_point": "main"})
        resources = [texture.create_view(), {"buffer": texels, "offset": 0, "size": texels.size}]
        entries = [{"binding": binding, "resource": resource} for binding, resource in enumerate(resources)]
        encoder = device.create_command_encoder()
        compute = encoder.begin_compute_pass()
        compute.set_pipeline(pipeline)
        compute.set_bind_group(0, device.create_bind_group(layout=pipeline.get_bind_group_layout(0), entries=entries))
        compute.dispatch_workgroups(SIZE // 8, SIZE // 8)
        compute.end()
        device.queue.submit([encoder.finish()])
        return np.frombuffer(device.queue.read_buffer(texels), np.float32).reshape(SIZE, SIZE, 4)

    return decode


@pytest.mark.parametrize(
    ("name", "texture_format", "tolerance"),
    [
        # half floats, by integer arithmetic that the format prescribes to the bit
        ("bc6h", "bc6h-rgb-ufloat", 0.0),
        ("bc6h_signed", "bc6h-rgb-float", 0.0),
        # 8 bits likewise; how they become floats may differ in the last bit
        ("bc7", "bc7-rgba-unorm", 1e-7),
    ],
)
def test_both_decode_alike(decode, name, texture_format, tolerance):
    form = TEXEL_FORMATS[name]
    stored = np.random.default_rng(3).integers(0, 256, (1, form.image_bytes(SIZE, SIZE)), dtype=np.uint8)
    ours = form.decode(stored, SIZE, SIZE)[0]
    theirs = decode(texture_format, stored)[..., : form.channels]
    assert len(np.unique(ours)) > 200
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=tolerance)
