"""A scene of moving, matte or glowing parts on the device: the host's side of `shaders/matte.wgsl`."""

from collections.abc import Iterable

import numpy as np
import wgpu

from reflet.render.device.textures import ADDRESS_MODES, upload_picture
from reflet.render.meshes.device_mesh import VERTEX_BUFFERS, DeviceMesh, depth_state
from reflet.scene.material import REPEATS, Texture
from reflet.scene.scene import Part, Scene
from reflet.scene.sky_light import SkyLight
from reflet.shaders.link import link

_UNIFORM = np.dtype(
    [
        ("base_color", "f4", 3), ("double_sided", "u4"), ("emission", "f4", 4),
        ("sky", "f4", 4), ("ground", "f4", 4), ("sun", "f4", 4), ("towards_sun", "f4", 4),
    ]
)  # fmt: skip


class MatteScene:
    """Draws parts with the transforms of bind group 0, in their order; base colours count as albedo, metals' too.
    Colours of vertices count as their mean, and all textures are looked up by the meshes' first coordinates."""

    def __init__(
        self, device: wgpu.GPUDevice, scene: Scene, light: SkyLight, view_layout: wgpu.GPUBindGroupLayout
    ) -> None:
        self._device = device
        self._layout = _layout(device)
        self._pipeline_layout = device.create_pipeline_layout(bind_group_layouts=[view_layout, self._layout])
        self._module = device.create_shader_module(code=link("matte.wgsl"))
        self._pipelines: dict[tuple[str, str], wgpu.GPURenderPipeline] = {}
        self._meshes = [DeviceMesh(device, part.mesh) for part in scene.parts]
        self._groups = [self._group(part, light) for part in scene.parts]

    def draw(
        self,
        render_pass: wgpu.GPURenderPassEncoder,
        parts: Iterable[int],
        texture_format: str,
        onto_paraboloid: bool = False,
    ) -> None:
        """Draws parts into the view that is bound; sets bind group 1."""
        render_pass.set_pipeline(self._pipeline(texture_format, "paraboloid" if onto_paraboloid else "plane"))
        for part in parts:
            render_pass.set_bind_group(1, self._groups[part])
            self._meshes[part].draw(render_pass, part)

    def _pipeline(self, texture_format: str, onto: str) -> wgpu.GPURenderPipeline:
        if (texture_format, onto) not in self._pipelines:
            vertex = "vertex_matte" if onto == "plane" else "vertex_matte_paraboloid"
            self._pipelines[texture_format, onto] = self._device.create_render_pipeline(
                layout=self._pipeline_layout,
                vertex={"module": self._module, "entry_point": vertex, "buffers": VERTEX_BUFFERS},
                primitive={"topology": "triangle-list"},
                depth_stencil=depth_state(backdrop=False),
                fragment={
                    "module": self._module,
                    "entry_point": f"matte_{onto}",
                    "targets": [{"format": texture_format}],
                },
            )
        return self._pipelines[texture_format, onto]

    def _group(self, part: Part, light: SkyLight) -> wgpu.GPUBindGroup:
        material, colors = part.material, part.mesh.colors
        uniform = np.zeros((), _UNIFORM)
        uniform["base_color"], uniform["double_sided"] = material.base_color, material.double_sided
        if colors is not None:
            uniform["base_color"] *= colors[:, :3].mean(axis=0)
        for name, value in (
            ("emission", material.emission), ("sky", light.sky), ("ground", light.ground),
            ("sun", light.sun), ("towards_sun", light.towards_sun),
        ):  # fmt: skip
            uniform[name][:3] = value
        buffer = self._device.create_buffer_with_data(data=uniform.tobytes(), usage=wgpu.BufferUsage.UNIFORM)
        resources = [
            {"buffer": buffer},
            *self._picture(material.base_color_texture_srgb),
            *self._picture(material.emission_texture_srgb),
        ]
        entries = [{"binding": k, "resource": resource} for k, resource in enumerate(resources)]
        return self._device.create_bind_group(layout=self._layout, entries=entries)

    def _picture(self, texture: Texture | None) -> tuple[wgpu.GPUTextureView, wgpu.GPUSampler]:
        pixels = np.full((1, 1, 4), 255, np.uint8) if texture is None else texture.pixels
        picture = upload_picture(self._device, pixels, "rgba8unorm-srgb", mip_mapped=True)
        u, v = (ADDRESS_MODES[wrap] for wrap in (REPEATS if texture is None else texture.wraps))
        sampler = self._device.create_sampler(
            address_mode_u=u, address_mode_v=v, mag_filter="linear", min_filter="linear", mipmap_filter="linear"
        )
        return picture.create_view(), sampler


def _layout(device: wgpu.GPUDevice) -> wgpu.GPUBindGroupLayout:
    fragment = wgpu.ShaderStage.FRAGMENT
    texture = {"sample_type": "float", "view_dimension": "2d"}
    return device.create_bind_group_layout(
        entries=[
            {"binding": 0, "visibility": fragment, "buffer": {"type": "uniform"}},
            {"binding": 1, "visibility": fragment, "texture": texture},
            {"binding": 2, "visibility": fragment, "sampler": {"type": "filtering"}},
            {"binding": 3, "visibility": fragment, "texture": texture},
            {"binding": 4, "visibility": fragment, "sampler": {"type": "filtering"}},
        ]
    )
