"""Lookups by quadratic B-splines on the device, over seams and at corners, and several levels of one size."""

import numpy as np
import pytest
from compute import run

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.parameterizations.octahedral import Octahedral
from reflet.envmap.parameterizations.parameterization import NONE, Parameterization
from reflet.errors import RefletError
from reflet.render.device.device import shared_device
from reflet.render.maps.env_map_texture import upload_env_map

SIZE = 8
EACH = pytest.mark.parametrize("p", [CUBE, Octahedral()], ids=str)  # what live and still environments look up


def smooth(p: Parameterization, texels: np.ndarray, direction: np.ndarray) -> np.ndarray:
    """`sample_level_smoothly` on the device."""
    code = f"""
    #import map_lookup
    let d = vec3f(in0[3*i], in0[3*i+1], in0[3*i+2]);
    let c = sample_level_smoothly({p.kind}u, maps, 0, map_point({p.kind}u, d), 0);
    out[4*i] = c.x; out[4*i+1] = c.y; out[4*i+2] = c.z; out[4*i+3] = c.w;
    """
    return run(code, [direction], 4, [texels])


def directions(count: int = 3000) -> np.ndarray:
    d = np.random.default_rng(7).normal(size=(count, 3)).astype(np.float32)
    d[:200] = np.sign(d[:200]) + 0.02 * d[:200]  # about corners
    return d


@EACH
def test_against_the_weights_of_b_splines(p: Parameterization) -> None:
    texels = np.random.default_rng(8).random((*p.shape(SIZE), 4)).astype(np.float32)
    d = directions()
    face, uv = p.uv_from_direction(d.astype(float))
    place = SIZE * uv
    middle = np.minimum(place.astype(int), SIZE - 1)
    expected, present = np.zeros((len(d), 4)), np.zeros((len(d), 1))
    for row in (-1, 0, 1):
        for column in (-1, 0, 1):
            # The B-spline by distance from the texel's centre: 3/4 - t² within half a texel, (3/2 - |t|)²/2 outside.
            t = np.abs(place - (middle + [column, row] + 0.5))
            weight = np.where(t < 0.5, 0.75 - t * t, 0.5 * (1.5 - t) ** 2).prod(-1, keepdims=True)
            at, y, x = p.across_seams(face, middle[:, 1] + row, middle[:, 0] + column, SIZE)
            weight[at == NONE] = 0.0
            expected += weight * texels[at, y, x]
            present += weight
    # 8 columns times uv good to 3e-7, times slopes of up to 1, ten times.
    np.testing.assert_allclose(smooth(p, texels, d), expected / present, atol=2e-5)


@EACH
def test_gradients_do_not_jump_between_texels(p: Parameterization) -> None:
    texels = np.random.default_rng(9).random((*p.shape(SIZE), 4)).astype(np.float32)
    # A line within one octant and one face, 31 to 40 steps a texel. A spline's second derivative is at most the second
    # difference of texels, 2 here; that of uv by angle adds a tenth. Interpolated linearly, a gradient jumps by up to
    # 2/31 from step to step.
    angle = np.linspace(0.05, 0.55, 80)
    line = np.stack([np.sin(angle), np.cos(angle), 0.1 + 0.0 * angle], -1).astype(np.float32)
    value = smooth(p, texels, line)
    assert np.abs(np.diff(value, 2, axis=0)).max() < 3.0 / 31.0**2


def test_levels_of_one_size_are_layers_of_a_mip_level() -> None:
    sizes = [8, 8, 4, 4]
    levels = [
        EnvImage(Octahedral(), np.full((*Octahedral().shape(size), 3), k, np.float32)) for k, size in enumerate(sizes)
    ]
    env_map = upload_env_map(shared_device(), levels)
    assert (env_map.levels_a_size, env_map.level_count, env_map.texture.mip_level_count) == (2, 4, 2)
    assert (env_map.read(1).texels[..., :3] == 2.0).all()  # the first of its size
    for wrong in (levels[:3], [levels[0], levels[2], levels[1]], levels[1:]):
        with pytest.raises(RefletError, match="half as large"):
            upload_env_map(shared_device(), wrong)
