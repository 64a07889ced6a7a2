"""An environment that changes from frame to frame, and its prefiltered maps, all made on the device."""

import wgpu

from reflet.envmap.env_image import EnvImage
from reflet.envmap.lamp import Lamp
from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.resampling.mip_reduction import mip_images
from reflet.envmap.resampling.resample import resample
from reflet.envmap.resampling.spread_light import HALF_MAX, held
from reflet.errors import RefletError
from reflet.reflectance.brdfs.phong import PhongKernel
from reflet.reflectance.lobes.lobe_taps import phong_taps
from reflet.reflectance.lobes.lobes import Lobes
from reflet.reflectance.materials.material import GlossyGgx, GlossyPhong, SurfaceMaterial
from reflet.reflectance.materials.measured_material import Measured
from reflet.render.device.device import shared_device
from reflet.render.filters.brdf_map_filter import BrdfMapFilter
from reflet.render.filters.lamp import LampPainter
from reflet.render.filters.phong_paraboloid import PhongParaboloidFilter
from reflet.render.filters.probe_filter import ProbeFilter
from reflet.render.filters.probe_pyramid import FILLED, DeviceLobes, ProbePyramid
from reflet.render.maps.device_maps import DeviceMaps
from reflet.render.maps.env_map_texture import HALF, EnvMapTexture, create_env_map, upload_env_map, write_levels
from reflet.render.maps.map_levels import MapLevels
from reflet.render.meshes.warp import Warp

_DIFFUSE_SIZE = 16  # rows: interpolated, the smooth diffuse map errs by some (0.1)²/8
_DRAWN = FILLED | wgpu.TextureUsage.STORAGE_BINDING


class LiveEnvironment:
    """The device's twin of `EnvironmentMaps`: show it an environment in every frame, and ask for a material's maps.

    Nothing comes back to the CPU, and only what a material looks up is filtered, again when the environment or the
    exponent has changed: GGX by `ProbeFilter`; Phong, whose exponent may be new in every frame, from the same pyramid,
    or, with ``by_paraboloids``, by the paper's hardware method (`PhongParaboloidFilter`); the slices of a measured
    BRDF's lobes by `BrdfMapFilter`; diffuse light summed from the pyramid. The first GGX material takes some tenths of
    a second, to find its taps, and each measured one, of which the last is remembered, a tenth a slice.

    ``size`` rows (a power of two from 16 on) has the cube that is filtered. An environment that is no half-float cube
    becomes one first: images by `resample`, which keeps suns whole, textures by `Warp`. Memory: some 400·size² bytes.
    """

    def __init__(self, size: int = 128, device: wgpu.GPUDevice | None = None, by_paraboloids: bool = False) -> None:
        if size < 16:
            raise RefletError(f"A live environment has 16 rows or more, not {size}.")
        self.device = device or shared_device()
        self._pyramid = ProbePyramid(self.device, size)
        self._ggx: ProbeFilter | None = None
        self._brdf_map: BrdfMapFilter | None = None
        self._paraboloids = PhongParaboloidFilter(self.device, 2 * size) if by_paraboloids else None
        self._phong = create_env_map(self.device, CUBE, size // 2, (size // 2).bit_length(), HALF, _DRAWN)
        self._phong_levels = MapLevels(self.device, self._phong)
        self._phong_lobe = DeviceLobes(self.device, size, [phong_taps(1.0)])
        self._diffuse = create_env_map(self.device, CUBE, _DIFFUSE_SIZE, 1, HALF, FILLED)
        self._drawn = create_env_map(self.device, CUBE, size, size.bit_length(), HALF, _DRAWN)
        self._warp = Warp(self.device, self._drawn)
        self._lamps: dict[int, LampPainter] = {}  # by the rows of the cube
        self._shown: EnvMapTexture | None = None
        self._done: set[str] = set()  # what has been made since the environment was shown
        self._phong_exponent = 0.0

    @property
    def environment(self) -> EnvMapTexture:
        """What was last shown. Raises RefletError before that."""
        if self._shown is None:
            raise RefletError("A live environment is empty until it is shown an environment.")
        return self._shown

    def show(self, environment: EnvMapTexture | EnvImage, lamp: Lamp | None = None) -> None:
        """What surrounds all from now on: on the device, as `EnvironmentCapture` or `Warp` draw it, with mip levels.

        A texture whose texels have changed is shown again. An image is uploaded; light that is too
        bright for half floats is spread (`spread_light`). A ``lamp`` is added to a half-float
        cube as it is, to anything else as the cube that is filtered.
        """
        self._done.clear()
        if isinstance(environment, EnvImage):
            image = _whole(environment)
            self._shown = upload_env_map(self.device, mip_images(image))
            write_levels(self._drawn, mip_images(resample(image, CUBE, self._drawn.size)))
            self._done.add("cube")
        else:
            self._shown = environment
        if lamp is not None:
            encoder = self.device.create_command_encoder()
            cube = self._cube(encoder)
            if cube.size not in self._lamps:
                self._lamps[cube.size] = LampPainter(self.device, cube.size)
            self._shown = self._lamps[cube.size].paint(encoder, cube, lamp)
            self.device.queue.submit([encoder.finish()])
            self._done.clear()

    def maps(self, material: SurfaceMaterial) -> DeviceMaps:
        """What ``material`` looks up. Its textures hold that until the next call.

        Raises RefletError before an environment is shown.
        """
        environment = self.environment
        encoder = self.device.create_command_encoder()
        reflected, roughness = environment, None
        if isinstance(material, GlossyPhong):
            reflected = self._filtered_with_phong(encoder, material.phong_exponent)
        elif isinstance(material, GlossyGgx):
            reflected, roughness = self._filtered_with_ggx(encoder), material.perceptual_roughness
        elif isinstance(material, Measured):
            reflected = self._filtered_with_lobes(encoder, material.lobes)
        diffuse = self._filtered_diffusely(encoder) if material.diffuses else None
        self.device.queue.submit([encoder.finish()])
        return DeviceMaps(reflected, roughness, diffuse)

    def _filtered_with_phong(self, encoder: wgpu.GPUCommandEncoder, phong_exponent: float) -> EnvMapTexture:
        if self._paraboloids is not None:
            return self._paraboloids.refilter(encoder, self.environment, PhongKernel(phong_exponent))
        if self._is_new("phong") or phong_exponent != self._phong_exponent:
            self._fill_pyramid(encoder)
            self._phong_lobe.write([phong_taps(phong_exponent)])
            self._pyramid.filter(encoder, self._phong_lobe, self._phong)
            self._phong_levels.fill(encoder)
            self._phong_exponent = phong_exponent
        return self._phong

    def _filtered_with_ggx(self, encoder: wgpu.GPUCommandEncoder) -> EnvMapTexture:
        if self._ggx is None:
            self._ggx = ProbeFilter(self.device, self._pyramid.size, pyramid=self._pyramid)
        if self._is_new("ggx"):
            self._fill_pyramid(encoder)
            self._ggx.filter_levels(encoder, self._cube(encoder))
        return self._ggx.result

    def _filtered_with_lobes(self, encoder: wgpu.GPUCommandEncoder, lobes: Lobes) -> EnvMapTexture:
        if self._brdf_map is None or self._brdf_map.lobes is not lobes:
            self._brdf_map = BrdfMapFilter(self._pyramid, lobes)
            self._done.discard("lobes")
        if self._is_new("lobes"):
            self._fill_pyramid(encoder)
            self._brdf_map.refilter(encoder)
        return self._brdf_map.result

    def _filtered_diffusely(self, encoder: wgpu.GPUCommandEncoder) -> EnvMapTexture:
        if self._is_new("diffuse"):
            self._fill_pyramid(encoder)
            self._pyramid.diffuse(encoder, self._diffuse)
        return self._diffuse

    def _fill_pyramid(self, encoder: wgpu.GPUCommandEncoder) -> None:
        if self._is_new("pyramid"):
            self._pyramid.fill(encoder, self._cube(encoder))

    def _cube(self, encoder: wgpu.GPUCommandEncoder) -> EnvMapTexture:
        """The environment as a half-float cube."""
        if self.environment.by_hardware:
            return self.environment
        if self._is_new("cube"):
            self._warp.draw(encoder, self.environment)
        return self._drawn

    def _is_new(self, what: str) -> bool:
        """Whether it is asked for the first time since the environment was shown."""
        new = what not in self._done
        self._done.add(what)
        return new


def _whole(image: EnvImage) -> EnvImage:
    """The image with rows that can be halved to the end, and with light that half floats hold."""
    whole = 1 << (image.size.bit_length() - 1)
    fitting = image if image.size == whole else resample(image, image.parameterization, whole)
    return held([fitting], HALF_MAX, "a live environment")[0]
