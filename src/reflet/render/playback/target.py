"""What a picture of one size is drawn into and summed up in."""

from functools import cached_property

import wgpu

from reflet.render.device.textures import check_size


class Target:
    """Textures and buffers of one picture size; made when first drawn into.

    16 bytes a pixel of colour, 4 of depth, 16 of the sum; 12 more for samples where they count; 48 + 8 more where
    multi-sampled.
    """

    def __init__(self, device: wgpu.GPUDevice, width: int, height: int) -> None:
        check_size(device, width, height, "A picture")
        self.size = width, height
        self._device = device
        self._textures: dict[tuple[str, int], wgpu.GPUTexture] = {}
        self.sum = self._buffer(16)

    @cached_property
    def spread(self) -> wgpu.GPUBuffer:
        """How far each pixel's samples lie apart: `accumulate.wgsl`."""
        return self._buffer(8)

    @cached_property
    def enough(self) -> wgpu.GPUBuffer:
        """After how many samples each pixel had enough, 0 while it takes all."""
        return self._buffer(4)

    def texture(self, texture_format: str, sample_count: int = 1) -> wgpu.GPUTexture:
        """The texture of a format."""
        key = texture_format, sample_count
        if key not in self._textures:
            usage = wgpu.TextureUsage.RENDER_ATTACHMENT
            if sample_count == 1:
                usage |= wgpu.TextureUsage.TEXTURE_BINDING | wgpu.TextureUsage.COPY_SRC
            self._textures[key] = self._device.create_texture(
                size=(*self.size, 1), format=texture_format, sample_count=sample_count, usage=usage
            )
        return self._textures[key]

    def _buffer(self, bytes_a_pixel: int) -> wgpu.GPUBuffer:
        width, height = self.size
        return self._device.create_buffer(
            size=bytes_a_pixel * width * height,
            usage=wgpu.BufferUsage.STORAGE | wgpu.BufferUsage.COPY_SRC | wgpu.BufferUsage.COPY_DST,
        )
