"""An environment that stays as it is, and its prefiltered maps, brought to the device."""

import wgpu

from reflet.envmap.env_image import EnvImage
from reflet.reflectance.materials.material import SurfaceMaterial
from reflet.reflectance.materials.material_maps import EnvironmentMaps
from reflet.reflectance.materials.measured_material import Measured
from reflet.reflectance.prefilter.brdf_map import BrdfMap3d
from reflet.render.maps.brdf_map_texture import BrdfMapTexture, upload_brdf_map
from reflet.render.maps.device_maps import DeviceMaps
from reflet.render.maps.env_map_texture import EnvMapTexture, upload_env_map


class StillEnvironment:
    """Maps filtered on the CPU. They go to the device when a material first needs them, and stay there.

    GGX's roughness is a choice of mip level, so that changing it costs nothing. A new Phong exponent takes a new map; a
    measured BRDF takes as many as its lobes have view angles.
    """

    def __init__(self, maps: EnvironmentMaps, device: wgpu.GPUDevice) -> None:
        self._maps, self._device = maps, device
        self._brdf_map: tuple[BrdfMap3d, BrdfMapTexture] | None = None  # the last one
        self._textures: dict[int, tuple[object, EnvMapTexture]] = {}

    @property
    def environment(self) -> EnvMapTexture:
        """The environment itself."""
        return self._texture(self._maps.levels)

    def maps(self, material: SurfaceMaterial) -> DeviceMaps:
        """What ``material`` looks up."""
        if isinstance(material, Measured):
            lobes = self._lobes(material)
            return DeviceMaps(lobes.slices, None, lobes.diffuse)
        maps = self._maps.maps(material)
        diffuse = None if maps.diffuse is None else self._texture((maps.diffuse,))
        return DeviceMaps(self._texture(maps.reflected), maps.roughness, diffuse)

    def _lobes(self, material: Measured) -> BrdfMapTexture:
        maps = self._maps.brdf_map(material.lobes)
        if self._brdf_map is None or self._brdf_map[0] is not maps:
            self._brdf_map = maps, upload_brdf_map(self._device, maps)
        return self._brdf_map[1]

    def _texture(self, levels: tuple[EnvImage, ...]) -> EnvMapTexture:
        """Uploaded once. Levels are known by their finest image, which is kept so that its number stays its own."""
        finest = levels[0]
        if id(finest) not in self._textures:
            self._textures[id(finest)] = finest, upload_env_map(self._device, levels)
        return self._textures[id(finest)][1]
