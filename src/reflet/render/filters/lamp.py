"""A lamp added to a cube on the device, as often as it moves: the host's side of `shaders/lamp.wgsl`."""

import numpy as np
import wgpu

from reflet.envmap.lamp import Lamp
from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.resampling.spread_light import HALF_MAX
from reflet.errors import RefletError
from reflet.render.device.face_passes import FacePasses, one_level
from reflet.render.maps.env_map_texture import HALF, EnvMapTexture, create_env_map

_UNIFORM = np.dtype([("direction", "f4", 3), ("square_chord", "f4"), ("radiance", "f4", 3), ("padding", "f4")])


class LampPainter:
    """Fills a half-float cube of ``size`` rows, a power of two, with another of its size and a lamp; all mip levels.

    Where the lamp is not, levels stay what they were. Memory: 64·size² bytes.
    """

    def __init__(self, device: wgpu.GPUDevice, size: int) -> None:
        self._device = device
        self._passes = FacePasses(device, "lamp.wgsl", HALF)
        usage = wgpu.BufferUsage.UNIFORM | wgpu.BufferUsage.COPY_DST
        self._uniform = device.create_buffer(size=_UNIFORM.itemsize, usage=usage)
        self._result = create_env_map(device, CUBE, size, size.bit_length(), HALF, wgpu.TextureUsage.RENDER_ATTACHMENT)

    def paint(self, encoder: wgpu.GPUCommandEncoder, source: EnvMapTexture, lamp: Lamp) -> EnvMapTexture:
        """The passes that do so; the same texture every time. One lamp a submission.

        Raises RefletError for sources of another size or kind, or without all mip levels, and for lamps brighter than
        half floats can be.
        """
        size, levels = self._result.size, self._result.texture.mip_level_count
        if not source.by_hardware or (source.size, source.texture.mip_level_count) != (size, levels):
            raise RefletError(
                f"A lamp is painted into half-float cubes of {size} rows with {levels} levels, not into a "
                f"{source.parameterization} map of {source.size} rows in {source.texture.format}; warp it to a cube."
            )
        if max(lamp.radiance) > HALF_MAX:
            raise RefletError(
                f"A lamp on the device is at most {HALF_MAX:.0f} bright, not {max(lamp.radiance):g}; make it wider "
                "instead (radius_deg)."
            )
        uniform = np.zeros((), _UNIFORM)
        uniform["direction"], uniform["square_chord"] = lamp.unit_direction, lamp.square_chord
        uniform["radiance"] = lamp.radiance
        self._device.queue.write_buffer(self._uniform, 0, uniform.tobytes())
        for level in range(levels):
            bound: dict[int, object] = {0: one_level(source.texture, level), 2: {"buffer": self._uniform}}
            if level:
                bound[1] = one_level(self._result.texture, level - 1)
            entry_point = "coarser" if level else "finest"
            self._passes.draw(encoder, entry_point, self._result.texture, level, bound, SIZE=size >> level)
        return self._result
