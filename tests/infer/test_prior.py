"""Static maps become priors of any layout and frame."""

import numpy as np
import pytest

from reflet.envmap.mip_chain import MipChain
from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS
from reflet.envmap.parameterizations.cube import texel_directions
from reflet.infer.prior import prior_texels

CUBE = MipChain(64)
TURNED = np.array([[0.0, 0.0, -1.0], [0.6, 0.8, 0.0], [0.8, -0.6, 0.0]])  # a rotation, no axis of it the world's


def radiance(d: np.ndarray) -> np.ndarray:
    """Smooth, with no symmetry."""
    return 1.0 + np.stack([0.5 * d[..., 0], d[..., 1] * d[..., 2], 0.3 * d[..., 1] - 0.2 * d[..., 2]], -1)


@pytest.mark.parametrize("name", PARAMETERIZATIONS)
def test_a_constant_stays_constant(name: str) -> None:
    chain = MipChain(32, PARAMETERIZATIONS[name])
    prior = prior_texels(CUBE, np.full((CUBE.texel_count, 3), 0.7, np.float32), chain, np.eye(3))
    assert prior.shape == (chain.texel_count, 3)
    assert np.abs(prior - 0.7).max() < 1e-6  # float32


@pytest.mark.parametrize("name", [name for name in PARAMETERIZATIONS if name != "cube"])
def test_each_texel_holds_what_lies_in_its_direction(name: str) -> None:
    cube = np.concatenate([radiance(texel_directions(n)).reshape(-1, 3) for n in CUBE.level_sizes])
    chain = MipChain(32, PARAMETERIZATIONS[name])
    prior = prior_texels(CUBE, cube.astype(np.float32), chain, TURNED)
    directions, _ = chain.parameterization.texel_directions(32)
    # A texel sees up to 0.2 rad, and is looked up where the cube's texels do: filtering smooth radiance errs by 0.2²/8
    # times a second derivative of 1; at the cube's edges, where directions bend, by a quarter of a texel times 0.5.
    assert np.abs(chain.level(prior, 0) - radiance(directions @ TURNED)).max() < 0.03


def test_cubes_are_handed_through() -> None:
    texels = np.random.default_rng(0).random((CUBE.texel_count, 3)).astype(np.float32)
    assert prior_texels(CUBE, texels, CUBE, np.eye(3)) is texels
