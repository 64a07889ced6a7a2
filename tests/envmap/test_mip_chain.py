"""The flat order of all mip levels."""

import numpy as np
import pytest

from reflet.envmap.env_map import EnvMap
from reflet.envmap.geometry import InfiniteSphere
from reflet.envmap.mip_chain import MipChain
from reflet.errors import RefletError


@pytest.mark.parametrize("size", [1, 2, 64, 256])
def test_levels_tile_the_vector(size: int) -> None:
    chain = MipChain(size)
    assert chain.texel_count == 6 * (4 * size * size - 1) // 3
    texels = np.arange(chain.texel_count)
    levels = [chain.level(texels, level) for level in range(chain.level_count)]
    assert [level.shape[1] for level in levels] == list(chain.level_sizes)
    assert chain.level_sizes[-1] == 1
    np.testing.assert_array_equal(np.concatenate([level.ravel() for level in levels]), texels)


def test_a_level_is_a_view() -> None:
    chain = MipChain(4)
    texels = np.zeros((chain.texel_count, 3))
    chain.level(texels, 1)[2, 1, 0] = 7.0
    assert texels[chain.offsets[1] + (2 * 2 + 1) * 2 + 0, 0] == 7.0


@pytest.mark.parametrize("size", [0, 3, 100, 16384])
def test_sizes_that_are_no_power_of_two_are_refused(size: int) -> None:
    with pytest.raises(RefletError, match="power of two"):
        MipChain(size)


def test_an_env_map_wants_all_its_texels() -> None:
    with pytest.raises(ValueError, match="texels expected"):
        EnvMap(MipChain(4), np.zeros((5, 3), np.float32), InfiniteSphere())
