"""Static maps become priors of any layout and frame."""

import numpy as np
import pytest
from synthetic import picture, sphere_mesh

from reflet.envmap.env_image import EnvImage
from reflet.envmap.env_map import EnvMap
from reflet.envmap.geometry import InfiniteSphere
from reflet.envmap.lod import lobe_spread, roughness_of_level
from reflet.envmap.mip_chain import MipChain
from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS
from reflet.envmap.parameterizations.cube import texel_directions
from reflet.envmap.parameterizations.latlong import LatLong
from reflet.envmap.resampling.mip_reduction import mip_images
from reflet.envmap.resampling.resample import resample
from reflet.infer.prior import lobe_levels, prior_texels
from reflet.infer.shown import shown_rows
from reflet.reflectance.brdfs.ggx import GgxKernel, d_ggx, v_smith_ggx
from reflet.reflectance.prefilter.prefilter import Prefilter
from reflet.report.measures import tone_map
from reflet.scene.builtin.labelled_court import labelled_court
from reflet.scene.material import Material
from reflet.scene.roughness import least_roughness
from reflet.scene.scene import Part, ReflectiveObject, Scene

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


def court(size: int) -> tuple[EnvImage, np.ndarray]:
    """A panorama without its sun, and it as a cube with all levels as box filters make them."""
    panorama = resample(labelled_court(256), LatLong(), 128)
    panorama = EnvImage(panorama.parameterization, np.minimum(panorama.texels[..., :3], 5.0))
    levels = mip_images(resample(panorama, MipChain(size).parameterization, size))
    return panorama, np.concatenate([level.texels.reshape(-1, 3) for level in levels]).astype(np.float32)


def test_the_roughness_of_a_level_is_looked_up_there() -> None:
    for level, size in ((0, 128), (2, 64), (4, 128)):
        texel = 0.5 * np.pi * 2**level / size
        assert np.arcsin(lobe_spread(roughness_of_level(level, size))) == pytest.approx(texel, rel=1e-9)
    assert np.arcsin(lobe_spread(1.0)) == pytest.approx(1.0)
    assert lobe_spread(0.0) == 0.0


def test_levels_are_filtered_for_the_lobes_that_read_them() -> None:
    chain = MipChain(32)
    _, texels = court(32)
    assert lobe_levels(chain, texels, 0.0) is texels  # mirrors
    white = np.full((chain.texel_count, 4), 0.7, np.float32)
    assert np.abs(lobe_levels(chain, white, 0.5) - 0.7).max() < 1e-6  # alpha too
    found = lobe_levels(chain, texels, 0.7)
    reads = [roughness_of_level(level, 32) for level in range(chain.level_count)]
    assert reads[2] < 0.7 < reads[4]
    np.testing.assert_array_equal(chain.level(found, 0), chain.level(texels, 0))  # too fine to be read
    kernel = GgxKernel(reads[3] ** 2)
    wanted = Prefilter(EnvImage(chain.parameterization, chain.level(texels, 0))).map(kernel, chain.parameterization, 4)
    np.testing.assert_array_equal(chain.level(found, 3), wanted.texels)


@pytest.mark.parametrize(("roughness", "least"), [(0.3, 35.0), (0.5, 36.0), (0.8, 42.0)])
def test_a_rough_sphere_shows_what_its_lobe_sees(roughness: float, least: float) -> None:
    """Beside the sum over all of the panorama in float64. Levels by box filters are 11 dB worse."""
    chain = MipChain(128)
    panorama, texels = court(128)
    ball = Part("ball", sphere_mesh(rings=32), Material("rough", perceptual_roughness=roughness), True)
    seen = picture(Scene((ball,), (ReflectiveObject("ball", (0,)),)), (0.0, 1.0, 3.0), 20, sample_count=1)
    (lookups,) = seen.gbuffer.lookups
    position = lookups.position[0].astype(float)
    normal = position / np.linalg.norm(position, axis=-1, keepdims=True)
    towards = np.array((0.0, 1.0, 3.0)) - position
    towards /= np.linalg.norm(towards, axis=-1, keepdims=True)
    counts = (normal * towards).sum(-1) > 0.15

    def shown(levels: np.ndarray) -> np.ndarray:
        return shown_rows(seen.gbuffer, [EnvMap(chain, levels, InfiniteSphere())], -1.5)[counts]

    wanted = lobe_sums(panorama, normal[counts], towards[counts], roughness**2)
    assert least_roughness([ball]) == roughness
    filtered, plain = (psnr(wanted, shown(levels)) for levels in (lobe_levels(chain, texels, roughness), texels))
    assert filtered > least and filtered > plain + 8.0


def lobe_sums(panorama: EnvImage, normal: np.ndarray, towards: np.ndarray, alpha: float) -> np.ndarray:
    """The means of a panorama by D·V·n·l about unit normals."""
    light, _ = panorama.parameterization.texel_directions(panorama.size)
    solid_angle = panorama.parameterization.texel_solid_angle(panorama.size).ravel()
    light, radiance_of = light.reshape(-1, 3), panorama.texels.reshape(-1, 3).astype(float)
    out = []
    for n, v in zip(normal, towards, strict=True):
        cosine = light @ n
        above = cosine > 0.0
        half = light[above] + v
        half /= np.linalg.norm(half, axis=-1, keepdims=True)
        weight = d_ggx(half @ n, alpha) * v_smith_ggx(cosine[above], np.array(n @ v), alpha) * cosine[above]
        weight *= solid_angle[above]
        out.append(weight @ radiance_of[above] / weight.sum())
    return np.array(out)


def psnr(a: np.ndarray, b: np.ndarray) -> float:
    """Of what displays show."""
    return float(-10.0 * np.log10(np.mean((tone_map(a) - tone_map(b)) ** 2)))
