"""Prefiltering on the device by the paper's hardware method, as often as the environment or the lobe changes."""

from collections.abc import Sequence

import numpy as np
import wgpu

from reflet.envmap.dual_paraboloid import DualParaboloid
from reflet.errors import RefletError
from reflet.reflectance.kernel import Kernel
from reflet.reflectance.plane_filter import PlaneFilter, plane_filters
from reflet.render.env_map_texture import FULL, EnvMapTexture, create_env_map
from reflet.shaders.link import link

_WEIGHTS = 208  # bytes: 49 floats, in whole vectors of four
_FACES = 2


class PhongParaboloidFilter:
    """Filters an env map with a lobe, into a dual paraboloid whose faces have ``size`` rows.

    Implements [Heidrich00, sec. 3.2.5, steps 1 to 13] in render passes: a map with a ``border`` that shows the other
    hemisphere, and its mip levels, weighted by solid angle; on two of these levels the map S, filtered as the middle
    asks, and L, filtered as the rim does, each with at most 7² texels (`plane_filter`); and both stretched and blended
    by d². Memory: some 9·(size + 2·border)²·16 bytes.

    ``size`` is a power of two from 16, ``border`` a multiple of an eighth of it: by default a quarter, which is as far
    as filters reach over the rim for Phong exponents from 10 on. Wider ones lose what lies beyond.
    """

    def __init__(self, device: wgpu.GPUDevice, size: int, border: int | None = None) -> None:
        border = size // 4 if border is None else border
        if size < 16 or size & (size - 1):
            raise RefletError(f"A filtered paraboloid's size must be a power of two from 16 on, not {size}.")
        if border < 0 or border % (size // 8):
            raise RefletError(
                f"A border around {size} rows is a multiple of {size // 8}, not {border}; try {size // 4}."
            )
        self.size, self._device = size, device
        self._rows = size + 2 * border
        self._constants = {"SIZE": float(size), "BORDER": float(border)}
        self._module = device.create_shader_module(code=link("phong_paraboloid.wgsl"))
        self._pipelines: dict[tuple[str, int], wgpu.GPURenderPipeline] = {}
        level_count = (size // 4).bit_length()  # filters shrink at most so far
        self._flux, self._small, self._large = (self._texture(level_count) for _ in range(3))
        usage = wgpu.BufferUsage.UNIFORM | wgpu.BufferUsage.COPY_DST
        self._weights = [device.create_buffer(size=_WEIGHTS, usage=usage) for _ in range(2)]
        self._result = create_env_map(device, DualParaboloid(), size, 1, FULL, wgpu.TextureUsage.RENDER_ATTACHMENT)

    def refilter(
        self, encoder: wgpu.GPUCommandEncoder, source: EnvMapTexture, kernel: Kernel, limit: float = 0.1
    ) -> EnvMapTexture:
        """The passes that filter ``source``, of any parameterization; the same texture every time, of one level.

        The lobe counts as zero below ``limit`` of its peak, and its rest is normalized: radiance, for every kernel. One
        refilter a submission: the filters' weights are written at once, not by the encoder.
        """
        filters = plane_filters(kernel, self.size, limit)
        kind = source.parameterization.kind
        self._draw(
            encoder, "with_border", _layers(self._flux, 0), {0: source.texture.create_view(dimension="2d-array")}, kind
        )
        for level in range(1, 1 + max(each.shrink_level for each in filters)):
            self._draw(encoder, "halved", _layers(self._flux, level), {1: _level(self._flux, level - 1)})
        shown = []
        for each, texture, buffer in zip(filters, (self._small, self._large), self._weights, strict=True):
            self._device.queue.write_buffer(buffer, 0, _packed(each))
            level = each.shrink_level
            group = {1: _level(self._flux, level), 2: {"buffer": buffer}}
            self._draw(encoder, "filtered", _layers(texture, level), group)
            shown.append(_level(texture, level))
        self._draw(encoder, "blended", _layers(self._result.texture, 0), dict(enumerate(shown, start=3)))
        return self._result

    def _texture(self, level_count: int) -> wgpu.GPUTexture:
        return self._device.create_texture(
            size=(self._rows, self._rows, _FACES),
            mip_level_count=level_count,
            format=FULL,
            usage=wgpu.TextureUsage.RENDER_ATTACHMENT | wgpu.TextureUsage.TEXTURE_BINDING,
        )

    def _draw(
        self,
        encoder: wgpu.GPUCommandEncoder,
        entry_point: str,
        faces: Sequence[wgpu.GPUTextureView],
        bound: dict[int, object],
        kind: int = 0,
    ) -> None:
        pipeline = self._pipeline(entry_point, kind)
        entries = [{"binding": k, "resource": resource} for k, resource in bound.items()]
        group = self._device.create_bind_group(layout=pipeline.get_bind_group_layout(0), entries=entries)
        for face, view in enumerate(faces):
            render_pass = encoder.begin_render_pass(
                color_attachments=[{"view": view, "load_op": "clear", "store_op": "store"}]
            )
            render_pass.set_pipeline(pipeline)
            render_pass.set_bind_group(0, group)
            render_pass.draw(3, 1, 0, face)
            render_pass.end()

    def _pipeline(self, entry_point: str, kind: int) -> wgpu.GPURenderPipeline:
        key = entry_point, kind
        if key not in self._pipelines:
            self._pipelines[key] = self._device.create_render_pipeline(
                layout="auto",
                vertex={"module": self._module, "entry_point": "vertex_face"},
                primitive={"topology": "triangle-list"},
                fragment={
                    "module": self._module,
                    "entry_point": entry_point,
                    "constants": {**self._constants, "KIND": kind},
                    "targets": [{"format": FULL}],
                },
            )
        return self._pipelines[key]


def _packed(plane_filter: PlaneFilter) -> bytes:
    return plane_filter.weights.astype(np.float32).tobytes().ljust(_WEIGHTS, b"\0")


def _layers(texture: wgpu.GPUTexture, mip_level: int) -> Sequence[wgpu.GPUTextureView]:
    """Each face of a level, to draw into."""
    return [
        texture.create_view(
            dimension="2d", base_array_layer=face, array_layer_count=1, base_mip_level=mip_level, mip_level_count=1
        )
        for face in range(_FACES)
    ]


def _level(texture: wgpu.GPUTexture, mip_level: int) -> wgpu.GPUTextureView:
    return texture.create_view(dimension="2d-array", base_mip_level=mip_level, mip_level_count=1)
