"""The lobes of a BRDF as taps: what a GPU reads to filter their maps in every frame (see `lobe_taps`).

The channels of a slice share their places and differ in weights. As lobes change gradually with the view angle, each
search may begin where the one before ended.
"""

import numpy as np

from reflet.reflectance.brdfs.tabulated_kernel import TabulatedKernel
from reflet.reflectance.lobes.lobe_taps import LobeTaps, RingSearch, density_over_bins, ring_weights, taps_of_rings
from reflet.reflectance.lobes.lobes import THETA, Lobe, Lobes

_STEPS = 120  # of each search; more gain some thousandths
_NOTHING = 1e-4  # of the light: slices that reflect less are left black

_BLACK = LobeTaps(np.array([[0.0, 0.0, 1.0]]), np.array([0.1]), np.zeros((1, 3)))


def brdf_taps(lobes: Lobes) -> tuple[LobeTaps, ...]:
    """Taps of all slices, in the order of `reflet.reflectance.prefilter.brdf_map.BrdfMap3d`, of three channels each.

    Takes up to a tenth of a second a slice.
    """
    return tuple(taps for lobe in lobes.lobes for taps in _taps(lobe))


def _taps(lobe: Lobe) -> list[LobeTaps]:
    out, before = [], None
    for densities, albedo in zip(lobe.densities, lobe.albedo, strict=True):
        reflects = albedo > _NOTHING
        if not reflects.any():
            out.append(_BLACK)
            continue
        kernels = [TabulatedKernel(THETA, density) for density in densities.T[reflects]]
        search = RingSearch(np.stack([density_over_bins(kernel) for kernel in kernels], -1))
        starts = [search.start(), search.start_with_floor(), *([] if before is None else [before])]
        before = search.least(min(starts, key=search.distance), _STEPS)
        angle, blur = search.rings(before)
        weights = np.zeros((len(angle), len(albedo)))
        weights[:, reflects] = albedo[reflects] * ring_weights(search.density, angle, blur)[0]
        out.append(taps_of_rings(angle, blur, np.broadcast_to(weights, (len(angle), 3))))
    return out
