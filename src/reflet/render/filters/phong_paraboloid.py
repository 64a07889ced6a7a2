"""Prefiltering on the device by the paper's hardware method, as often as the environment or the lobe changes."""

import numpy as np
import wgpu

from reflet.envmap.parameterizations.dual_paraboloid import DualParaboloid
from reflet.errors import RefletError
from reflet.reflectance.brdfs.kernel import Kernel
from reflet.reflectance.prefilter.plane_filter import PlaneFilter, plane_filters
from reflet.render.device.face_passes import FacePasses, one_level
from reflet.render.maps.env_map_texture import FULL, EnvMapTexture, create_env_map

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
        self._constants = {"SIZE": size, "BORDER": border}
        self._passes = FacePasses(device, "phong_paraboloid.wgsl", FULL)
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
        draw, constants = self._passes.draw, self._constants
        incoming = {0: source.texture.create_view(dimension="2d-array")}
        draw(encoder, "with_border", self._flux, 0, incoming, KIND=source.parameterization.kind, **constants)
        for level in range(1, 1 + max(each.shrink_level for each in filters)):
            draw(encoder, "halved", self._flux, level, {1: one_level(self._flux, level - 1)})
        shown = []
        for each, texture, buffer in zip(filters, (self._small, self._large), self._weights, strict=True):
            self._device.queue.write_buffer(buffer, 0, _packed(each))
            level = each.shrink_level
            bound = {1: one_level(self._flux, level), 2: {"buffer": buffer}}
            draw(encoder, "filtered", texture, level, bound)
            shown.append(one_level(texture, level))
        draw(encoder, "blended", self._result.texture, 0, dict(enumerate(shown, start=3)), **constants)
        return self._result

    def _texture(self, level_count: int) -> wgpu.GPUTexture:
        return self._device.create_texture(
            size=(self._rows, self._rows, _FACES),
            mip_level_count=level_count,
            format=FULL,
            usage=wgpu.TextureUsage.RENDER_ATTACHMENT | wgpu.TextureUsage.TEXTURE_BINDING,
        )


def _packed(plane_filter: PlaneFilter) -> bytes:
    return plane_filter.weights.astype(np.float32).tobytes().ljust(_WEIGHTS, b"\0")
