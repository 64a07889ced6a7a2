"""The fast prefilter against closed forms and against brute force."""

from pathlib import Path

import numpy as np
import pytest

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS
from reflet.envmap.parameterizations.cube import CUBE
from reflet.errors import RefletError
from reflet.files.pictures.hdr import read_hdr
from reflet.reflectance.brdfs.charlie import CharlieKernel
from reflet.reflectance.brdfs.ggx import GgxKernel
from reflet.reflectance.brdfs.kernel import Kernel
from reflet.reflectance.brdfs.lambert import DiffuseKernel
from reflet.reflectance.brdfs.phong import PhongKernel
from reflet.reflectance.brdfs.quadrature import filtered_reference
from reflet.reflectance.brdfs.tabulated_kernel import TabulatedKernel
from reflet.reflectance.prefilter.ggx_levels import FILAMENT, GEOMETRIC, LINEAR, ggx_levels, renderer_levels
from reflet.reflectance.prefilter.prefilter import Prefilter, prefiltered
from reflet.reflectance.prefilter.radiance_tree import radiance_tree
from reflet.reflectance.prefilter.sheen_levels import sheen_levels

HDR = Path(__file__).parents[2].parent / "shared" / "data" / "hdr"
LATLONG = PARAMETERIZATIONS["latlong"]
KERNELS: list[Kernel] = [
    DiffuseKernel(),
    PhongKernel(1.0),
    PhongKernel(50.0),
    PhongKernel(1000.0),
    GgxKernel(0.02),
    GgxKernel(0.0625),
    GgxKernel(0.25),
    GgxKernel(1.0),
    CharlieKernel(0.25),
]


def some_directions(count: int) -> np.ndarray:
    direction = np.random.default_rng(0).normal(size=(count, 3))
    return direction / np.linalg.norm(direction, axis=-1, keepdims=True)


def environment(size: int) -> EnvImage:
    """Smooth light of three colours and a sun of one texel, 20,000 times as bright, with half of all the light."""
    direction, _ = LATLONG.texel_directions(size)
    x, y, z = np.moveaxis(direction, -1, 0)
    texels = np.stack([1.0 + 0.5 * x * y, 0.6 + 0.4 * z, 1.5 + y + 0.4 * np.sin(9.0 * x)], -1)
    texels[0, size // 4, size // 3] = 2.0 * np.pi / LATLONG.texel_solid_angle(size)[0, size // 4, size // 3]
    return EnvImage(LATLONG, texels.astype(np.float32))


@pytest.mark.parametrize("name", PARAMETERIZATIONS)
@pytest.mark.parametrize("kernel", KERNELS[::2], ids=repr)
def test_white_furnace(name: str, kernel: Kernel) -> None:
    parameterization = PARAMETERIZATIONS[name]
    image = EnvImage(parameterization, np.full((*parameterization.shape(24), 3), 0.7, np.float32))
    for to, size in ((parameterization, 8), (CUBE, 5)):
        # Sums of some thousand float32 values, divided by sums of the same weights.
        np.testing.assert_allclose(prefiltered(image, kernel, to, size).texels, 0.7, rtol=1e-5)


def off_linear(name: str, size: int, kernel: Kernel) -> np.ndarray:
    """Relative errors where the environment is L = 1 + ½ω: of m·r, m being the kernel's first moment ∫ k·cos θ dω."""
    parameterization, direction = PARAMETERIZATIONS[name], some_directions(5000)
    if name == "gazing_ball":
        # Around -z is a circle, 20° of 128 rows, of which the map has but its last texel (`prefilter`).
        direction = direction[direction[:, 2] > -np.cos(4.0 / np.sqrt(size))]
    texels = 1.0 + 0.5 * parameterization.texel_directions(size)[0]
    s = ((np.arange(1 << 16) + 0.5) / (1 << 16)) ** 4  # dω = 4π ds, s = sin²(θ/2); u⁴ sees narrow lobes
    weight = kernel.density(s) * s**0.75
    moment = weight @ (1.0 - 2.0 * s) / weight.sum()
    radiance = Prefilter(EnvImage(parameterization, texels)).radiance(kernel, direction)
    return np.abs(radiance / (1.0 + 0.5 * moment * direction) - 1.0)


@pytest.mark.parametrize("name", PARAMETERIZATIONS)
@pytest.mark.parametrize("kernel", [DiffuseKernel(), *map(PhongKernel, (1.0, 2.0, 10.0, 100.0))], ids=repr)
def test_a_linear_environment_keeps_the_kernels_first_moment(name: str, kernel: Kernel) -> None:
    # What is promised is 0.1 %, everywhere. Cells of up to 0.35 rad are within the tolerance of 1 %; a tenth is left.
    assert off_linear(name, 128, kernel).max() < 1e-3


@pytest.mark.parametrize(
    ("name", "kernel"),
    [(name, PhongKernel(1000.0)) for name in PARAMETERIZATIONS if name != "gazing_ball"]
    + [("equal_area_octahedral", GgxKernel(0.01))],
    ids=str,
)
def test_narrow_lobes_too(name: str, kernel: Kernel) -> None:
    # The last is the worst, 0.07 %: bilinear interpolation over the creases of the map. It falls with texels' area.
    assert off_linear(name, 256, kernel).max() < 1e-3


@pytest.mark.parametrize("name", PARAMETERIZATIONS)
def test_what_was_filtered_before_makes_no_difference(name: str) -> None:
    parameterization, direction = PARAMETERIZATIONS[name], some_directions(200)
    x, y, z = np.moveaxis(parameterization.texel_directions(64)[0], -1, 0)
    image = EnvImage(parameterization, np.stack([1.0 + x * y, 1.0 + 0.9 * z, 1.5 + np.sin(9.0 * x)], -1))
    used = Prefilter(image)
    used.radiance(GgxKernel(0.04), direction)  # of an interpolated environment
    for kernel in (PhongKernel(30.0), DiffuseKernel()):
        radiance = used.radiance(kernel, direction)
        np.testing.assert_array_equal(radiance, Prefilter(image).radiance(kernel, direction))
        # Of texels themselves it is brute force, at the gazing ball's rim too; a tenth of the tolerance is left.
        assert np.abs(radiance / filtered_reference(image, kernel, direction) - 1.0).mean() < 1e-3


@pytest.mark.parametrize("kernel", KERNELS, ids=repr)
def test_with_a_sun_it_is_brute_force(kernel: Kernel) -> None:
    image, direction = environment(256), some_directions(100)
    reference = filtered_reference(image, kernel, direction)
    error = np.abs(Prefilter(image).radiance(kernel, direction) / reference - 1.0)
    # The tolerance is 1 %, of which the mean is to be a third at most. No fireflies: no texel is far off.
    assert error.mean() < 0.0035
    assert error.max() < 0.03


@pytest.mark.skipif(not HDR.is_dir(), reason="no shared data")
@pytest.mark.parametrize(
    ("kernel", "within"),
    [(DiffuseKernel(), 0.01), (PhongKernel(50.0), 0.03), (GgxKernel(0.02), 0.03), (GgxKernel(0.25), 0.03)],
    ids=lambda x: repr(x) if isinstance(x, Kernel) else "",
)
def test_kloppenheim_at_128_by_brute_force(kernel: Kernel, within: float) -> None:
    image = EnvImage(LATLONG, read_hdr(HDR / "kloppenheim_05_1k.hdr")[None])
    direction = CUBE.texel_directions(128)[0].reshape(-1, 3)
    some = np.random.default_rng(1).choice(len(direction), 30, replace=False)
    map_128 = prefiltered(image, kernel, CUBE, 128).texels.reshape(-1, 3)
    error = np.abs(map_128[some] / filtered_reference(image, kernel, direction[some]) - 1.0)
    # What is promised of the mean over texels; measured it is a tenth of that and less, so we hold it to a third.
    assert error.mean() < within / 3.0
    assert error.max() < within


def test_neighbours_differ_by_what_the_lobe_allows() -> None:
    """No seams between tiles, faces or levels of cells: on a line through the sun the map follows the kernel."""
    image = environment(128)
    sun = LATLONG.texel_directions(128)[0][0, 32, 42]
    aside = np.cross(sun, [0.0, 1.0, 0.0])
    aside /= np.linalg.norm(aside)
    angle = np.linspace(-1.5, 1.5, 1001)[:, None]
    line = np.cos(angle) * sun + np.sin(angle) * aside
    kernel = GgxKernel(0.0625)
    radiance = Prefilter(image).radiance(kernel, line)[:, 1].astype(np.float64)
    reference = filtered_reference(image, kernel, line)[:, 1]
    ratio = radiance / reference
    assert np.abs(np.diff(ratio)).max() < 5e-3  # steps between tiles: half the tolerance, invisible in 8 bits


def test_tables_filter_as_their_functions_and_keep_their_albedo() -> None:
    theta = np.linspace(0.0, 0.5 * np.pi, 3001)
    table = TabulatedKernel(theta, 0.6 * PhongKernel(30.0).density(np.sin(0.5 * theta) ** 2))
    image = environment(64)
    by_table, by_formula = (prefiltered(image, k, CUBE, 8).texels for k in (table, PhongKernel(30.0)))
    np.testing.assert_allclose(by_table, 0.6 * by_formula, rtol=2e-3)  # the verdicts differ a little


def test_lobes_narrower_than_texels_interpolate() -> None:
    """Between the four texels of the way the map must rise and fall as bilinear interpolation does, not in steps."""
    texels = np.ones((6, 8, 8, 1), np.float32)
    texels[4, 4, 4] = 2.0
    t = np.linspace(-0.125, 0.375, 101)
    line = np.stack([t, np.full_like(t, -0.125), np.ones_like(t)], -1)
    line /= np.linalg.norm(line, axis=-1, keepdims=True)
    for exponent in (300.0, 3000.0, 30000.0, 3000000.0):  # half heights at 5.5°, 1.7°, 0.6° and 0.05°; texels of 13°
        radiance = Prefilter(EnvImage(CUBE, texels)).radiance(PhongKernel(exponent), line)[:, 0]
        # The texel itself; the widest lobe, of a deviation σ of a quarter texel, leaves (1 - 0.8σ)² of the tent: 0.64.
        assert radiance[50] > (1.6 if exponent < 1000.0 else 1.9)
        assert radiance[0] < 1.1  # its neighbours'
        # From texel to texel are 50 steps of 0.02, but for the sixteen cells that they go by.
        assert np.abs(np.diff(radiance)).max() < 0.07


def test_any_number_of_channels() -> None:
    texels = environment(32).texels[..., [0, 1, 2, 0, 2]]
    five = prefiltered(EnvImage(LATLONG, texels), GgxKernel(0.25), CUBE, 4).texels
    np.testing.assert_allclose(five[..., 3:], five[..., [0, 2]], rtol=1e-6)


def test_no_light_is_lost_in_the_tree() -> None:
    image = environment(64)
    tree = radiance_tree(image, 64)
    solid_angle = LATLONG.texel_solid_angle(64)[..., None]
    total = np.append((image.texels * solid_angle).sum((0, 1, 2)), 4.0 * np.pi)
    ends = [*tree.starts[1:], len(tree.light)]
    for first, last in zip(tree.starts, ends, strict=True):
        np.testing.assert_allclose(tree.light[first:last].sum(0, dtype=np.float64), total, rtol=1e-5)  # float32 sums


def test_renderer_levels() -> None:
    image = environment(64)
    levels = renderer_levels(image, CUBE, 64)
    assert [level.size for level in levels] == [64, 64, 32, 32, 16, 16]
    assert [level.size for level in renderer_levels(image, CUBE, 16)] == [16, 16]
    kernel = GgxKernel(GEOMETRIC.roughness_of_level(3, 6) ** 2)
    np.testing.assert_array_equal(levels[3].texels, prefiltered(image, kernel, CUBE, 32).texels)


def test_lobes_between_levels_are_like_the_kernel() -> None:
    """The distance ∫ |blend - k| dω, which bounds what is wrong under a small sun, relative to its light."""
    x = (np.arange(20_000) + 0.5) / 20_000  # s = x⁴/2
    solid_angle = 8.0 * np.pi * x**3 / len(x)

    def lobe(perceptual_roughness: float) -> np.ndarray:
        return GgxKernel(perceptual_roughness**2).density(0.5 * x**4)

    distance = []
    for roughness in np.linspace(0.15, 1.0, 80).tolist():
        lod = GEOMETRIC.lod_from_roughness(roughness, 6)
        level = min(int(lod), 4)
        finer, coarser = (lobe(GEOMETRIC.roughness_of_level(k, 6)) for k in (level, level + 1))
        blend = finer + (lod - level) * (coarser - finer)
        distance.append(float((np.abs(blend - lobe(roughness)) * solid_angle).sum()))
    # α grows by 2.8 from one lobe to the next. Halfway, two such lobes are 0.2 from the one between them; were there
    # five levels, α growing by 3.7, it would be 0.3.
    assert max(distance) < 0.22


def test_ggx_levels() -> None:
    levels = ggx_levels(environment(64), CUBE, 64)
    assert [level.size for level in levels] == [64, 32, 16]
    for scale in (LINEAR, FILAMENT, GEOMETRIC):
        assert [scale.roughness_of_level(k, 5) for k in (0, 4)] == [0.0, 1.0]
        for level in range(5):
            assert scale.lod_from_roughness(scale.roughness_of_level(level, 5), 5) == pytest.approx(level)
    # The last level of roughness 1 is the diffuse kernel's.
    diffuse = prefiltered(environment(64), DiffuseKernel(), CUBE, 16)
    np.testing.assert_allclose(levels[-1].texels, diffuse.texels, rtol=1e-4)
    with pytest.raises(RefletError, match="2 to 7 levels"):
        ggx_levels(environment(64), CUBE, 64, level_count=8)


@pytest.mark.parametrize("name", PARAMETERIZATIONS)
def test_constants_stay_constant_in_all_levels(name: str) -> None:
    parameterization = PARAMETERIZATIONS[name]
    image = EnvImage(parameterization, np.full((*parameterization.shape(20), 3), 0.7, np.float32))
    for to, size in ((parameterization, 32), (PARAMETERIZATIONS["octahedral"], 9)):
        for levels in (ggx_levels(image, to, size, 3, FILAMENT), sheen_levels(image, to, size, 3)):
            for level in levels:
                # What is promised is 0.05 %. Sums of some thousand float32 values.
                np.testing.assert_allclose(level.texels, 0.7, rtol=1e-5)


def test_sheen_levels() -> None:
    image, direction = environment(128), CUBE.texel_directions(128)[0]
    levels = sheen_levels(image, CUBE, 128, 5)
    assert [level.size for level in levels] == [128, 64, 32, 16, 8]
    some = np.random.default_rng(0).choice(6 * 128 * 128, 60, replace=False)
    reference = filtered_reference(image, CharlieKernel(0.2**2), direction.reshape(-1, 3)[some])
    error = np.abs(levels[0].texels.reshape(-1, 3)[some] / reference - 1.0)
    # 3 % are promised of lobes. Interpolation leaves 1 % of the height of the sun's ring, and a little more where it
    # ends at the horizon with a bend.
    assert error.mean() < 0.005
    assert error.max() < 0.06
    reference = filtered_reference(image, CharlieKernel(0.75**2), CUBE.texel_directions(16)[0].reshape(-1, 3)[:60])
    np.testing.assert_allclose(levels[3].texels.reshape(-1, 3)[:60], reference, rtol=0.02)


def test_progress_reaches_its_end() -> None:
    heard: list[tuple[int, int]] = []
    ggx_levels(environment(64), CUBE, 256, 3, progress=lambda done, total: heard.append((done, total)))
    done = [part / total for part, total in heard]
    assert done == sorted(done) and done[-1] == 1.0
    assert len(heard) > 6 and max(np.diff(done)) < 0.3


def test_bad_radiance_is_refused() -> None:
    for bad, reason in ((-1.0, "negative"), (np.nan, "not finite")):
        texels = np.ones((6, 2, 2, 3), np.float32)
        texels[3, 0, 1, 2] = bad
        with pytest.raises(RefletError, match=reason):
            prefiltered(EnvImage(CUBE, texels), DiffuseKernel(), CUBE, 2)
