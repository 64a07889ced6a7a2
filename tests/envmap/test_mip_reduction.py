"""Box reduction and its way back."""

import numpy as np

from reflet.envmap.mip_chain import MipChain
from reflet.envmap.parameterizations.cube import texel_directions, texel_solid_angle
from reflet.envmap.resampling.mip_reduction import mip_levels_from_finest, prolong

CHAIN = MipChain(16)


def test_every_level_has_the_same_mean_over_all_directions() -> None:
    finest = np.random.default_rng(0).random((6, 16, 16, 3))
    texels = mip_levels_from_finest(CHAIN, finest)
    means = [
        (CHAIN.level(texels, level) * texel_solid_angle(size)[None, :, :, None]).sum((0, 1, 2)) / (4.0 * np.pi)
        for level, size in enumerate(CHAIN.level_sizes)
    ]
    assert np.abs(np.array(means) - means[0]).max() < 1e-12  # sums of 1536 float64 values


def test_a_constant_stays_constant_both_ways() -> None:
    texels = mip_levels_from_finest(CHAIN, np.full((6, 16, 16), 0.3))
    assert np.abs(texels - 0.3).max() < 1e-12
    for level in range(CHAIN.level_count - 1):
        assert np.abs(prolong(CHAIN, texels, level) - 0.3).max() < 1e-12


def test_prolongation_follows_a_smooth_function_over_edges() -> None:
    chain = MipChain(64)

    def smooth(size: int) -> np.ndarray:
        return texel_directions(size) @ np.array([0.3, -0.7, 0.5])

    texels = np.zeros(chain.texel_count)
    chain.level(texels, 1)[...] = smooth(32)
    error = np.abs(prolong(chain, texels, 0) - smooth(64))
    # Inside a face bilinear interpolation errs by h²/8·|f''| ~ (1/16)²/8·2 = 1e-3; along edges the neighbour's texel
    # lies up to half a coarse texel (1/32 of the face's 2 units) beside the continued grid: 0.25·0.03·|f'|.
    assert error.max() < 0.01
    assert np.sqrt(np.mean(error**2)) < 1e-3
