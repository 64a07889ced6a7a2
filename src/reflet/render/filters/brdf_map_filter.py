"""The maps of a BRDF's lobes, made on the device as often as the light changes."""

import wgpu

from reflet.envmap.parameterizations.octahedral import Octahedral
from reflet.reflectance.lobes.brdf_taps import brdf_taps
from reflet.reflectance.lobes.lobes import Lobes
from reflet.reflectance.prefilter.brdf_map import rows_for
from reflet.render.filters.probe_pyramid import FILLED, DeviceLobes, ProbePyramid
from reflet.render.maps.brdf_map_texture import check_layers
from reflet.render.maps.env_map_texture import HALF, create_env_map

_LEAST = 4  # rows of the last mip level: a sphere of 16 texels


class BrdfMapFilter:
    """The device's twin of `reflet.reflectance.prefilter.brdf_map.brdf_map_3d`, but for the diffuse map.

    Each slice of each lobe is an octahedral map, as large as the narrowest lobe asks for, whose texels take up to 49
    hardware-filtered lookups from a ``pyramid`` (`brdf_taps`). To find these takes up to a tenth of a second a slice.
    ``result`` is the texture that is filled, the same every time. Raises RefletError for more layers than the device
    has. Memory: 11 bytes a texel.
    """

    def __init__(self, pyramid: ProbePyramid, lobes: Lobes) -> None:
        device, to = pyramid.device, Octahedral()
        count = max(len(lobes.lobes) * len(lobes.cos_theta_o), 1)
        check_layers(device, count)
        rows = rows_for(lobes, to, 2 * pyramid.size)
        self.lobes, self.pyramid = lobes, pyramid
        self._taps = DeviceLobes(device, pyramid.size, brdf_taps(lobes)) if lobes.lobes else None
        self.result = create_env_map(device, to, rows, (rows // _LEAST).bit_length(), HALF, FILLED, map_count=count)

    def refilter(self, encoder: wgpu.GPUCommandEncoder) -> None:
        """The passes that filter what the pyramid holds."""
        if self._taps is not None:
            self.pyramid.filter(encoder, self._taps, self.result)
            self.pyramid.coarser(encoder, self.result)
