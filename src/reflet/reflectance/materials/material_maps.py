"""The maps that environment-mapped materials look up, made from one environment as they are asked for."""

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from jaxtyping import Float

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.octahedral import Octahedral
from reflet.envmap.parameterizations.parameterization import Parameterization
from reflet.envmap.resampling.mip_reduction import mip_images
from reflet.envmap.resampling.resample import resample
from reflet.reflectance.brdfs.lambert import DiffuseKernel
from reflet.reflectance.brdfs.phong import PhongKernel
from reflet.reflectance.lobes.lobes import Lobes
from reflet.reflectance.materials.material import GlossyGgx, GlossyPhong, SurfaceMaterial
from reflet.reflectance.prefilter.brdf_map import BrdfMap3d, brdf_map_3d, rows_for
from reflet.reflectance.prefilter.ggx_levels import renderer_levels
from reflet.reflectance.prefilter.prefilter import Prefilter, Progress, unheard

_DIFFUSE_SIZE = 64  # texels of 3°: interpolated, the smooth diffuse map errs by some (0.05)²/8


@dataclass(frozen=True)
class MaterialMaps:
    """What one material looks up. Mip levels come finest first."""

    reflected: tuple[EnvImage, ...]  # L_r, in the mirrored direction; several levels may have one size
    roughness: float | None  # perceptual_roughness to look up with, where its levels are filtered for that
    diffuse: EnvImage | None  # L_d, by the normal; none where the material has no use for it


class EnvironmentMaps:
    """An environment with its prefiltered maps, each made when first asked for and kept.

    ``size`` rows (a power of two) in ``parameterization`` have the maps of glossy materials; the environment itself
    stays what it is, but for sizes that are no powers of two. ``progress`` hears of the maps that a measured BRDF
    takes, some tenths of a second each: of those made, and of all. Radiance that is negative or not finite raises
    RefletError with the first prefiltered map.
    """

    def __init__(
        self,
        image: EnvImage,
        size: int = 256,
        parameterization: Parameterization | None = None,
        progress: Progress = unheard,
    ) -> None:
        self._size = size
        self._parameterization = parameterization or Octahedral()
        self._progress = progress
        self._image = EnvImage(image.parameterization, np.ascontiguousarray(image.texels[..., :3], np.float32))
        self._prefilter = Prefilter(self._image)
        self.phong = lru_cache(maxsize=16)(self._phong)
        self.brdf_map = lru_cache(maxsize=4)(self._brdf_map)

    @cached_property
    def levels(self) -> tuple[EnvImage, ...]:
        """The environment itself with all mip levels."""
        size = self._image.size
        whole = 1 << (size.bit_length() - 1)
        return mip_images(self._image if size == whole else resample(self._image, self._image.parameterization, whole))

    @cached_property
    def diffuse(self) -> EnvImage:
        """Irradiance/π by the normal."""
        return self._prefilter.map(DiffuseKernel(), self._parameterization, _DIFFUSE_SIZE)

    @cached_property
    def ggx(self) -> tuple[EnvImage, ...]:
        """`renderer_levels`: `GEOMETRIC` says which LOD is for which perceptual_roughness."""
        return renderer_levels(self._image, self._parameterization, self._size)

    def _phong(self, phong_exponent: float) -> tuple[EnvImage, ...]:
        """Filtered with a Phong lobe, by the mirrored direction; with mip levels."""
        return mip_images(self._prefilter.map(PhongKernel(phong_exponent), self._parameterization, self._size))

    def _brdf_map(self, lobes: Lobes) -> BrdfMap3d:
        """For materials that are `Measured`; no larger than the narrowest lobe asks for."""
        rows = rows_for(lobes, self._parameterization, self._size)
        return brdf_map_3d(self._image, lobes, self._parameterization, rows, self._progress)

    def maps(self, material: SurfaceMaterial) -> MaterialMaps:
        """What ``material`` looks up."""
        diffuse = self.diffuse if material.diffuses else None
        if isinstance(material, GlossyPhong):
            return MaterialMaps(self.phong(material.phong_exponent), None, diffuse)
        if isinstance(material, GlossyGgx):
            return MaterialMaps(self.ggx, material.perceptual_roughness, diffuse)
        return MaterialMaps(self.levels, None, diffuse)


def roughness_over(
    perceptual_roughness: float | Float[np.ndarray, "*batch"], footprint: Float[np.ndarray, "*batch"]
) -> Float[np.ndarray, "*batch"]:
    """perceptual_roughness of a GGX lobe widened by a pixel, whose mirrored rays spread over ``footprint`` radians.

    Variances add. Slopes of microfacets have α²/2 (Beckmann's; GGX's own has none) and mirrored rays turn twice as far:
    2α². A box has footprint²/12. So α² grows by footprint²/24.
    """
    return np.minimum((perceptual_roughness**4 + np.square(footprint) / 24.0) ** 0.25, 1.0)


def prepare(material: SurfaceMaterial, environment: EnvImage) -> MaterialMaps:
    """The maps of one material in one environment; `EnvironmentMaps` serves several without repeating itself."""
    return EnvironmentMaps(environment).maps(material)
