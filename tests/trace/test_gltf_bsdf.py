"""glTF's material as a BSDF: its samples follow their density, and it reflects what closed forms and oracles say."""

from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from reflet.reflectance.brdfs.brdf import FunctionBrdf, directional_albedo
from reflet.reflectance.brdfs.dfg import dfg
from reflet.reflectance.brdfs.ggx import v_smith_ggx
from reflet.reflectance.materials.material import GlossyGgx
from reflet.trace.references.gltf_bsdf import register_gltf
from reflet.trace.references.mirror_bsdf import register_mirror
from reflet.trace.variant import use_variant

COLOR = (0.8, 0.5, 0.2)
ROUGHNESS = [0.1, 0.3, 0.6, 1.0]
UP = (0.0, 0.0, 1.0)
VIEWS = np.array([0.1, 0.4, 0.7, 1.0])
SAMPLES = 1 << 18


@pytest.fixture(autouse=True)
def _plugins() -> None:
    use_variant()
    register_gltf()
    register_mirror()


def gltf(color: tuple[float, float, float] = COLOR, metallic: float = 0.0, roughness: float = 0.5, **more: Any) -> Any:
    """Of a coat ``clearcoat`` and ``clearcoat_roughness`` are numbers."""
    if "clearcoat" in more:
        coat = {"clearcoat_roughness": 0.0, **more}
        more |= {name: {"type": "uniform", "value": coat[name]} for name in ("clearcoat", "clearcoat_roughness")}
    return mi.load_dict(
        {
            "type": "reflet_gltf",
            "base_color": {"type": "srgb", "color": list(color)},
            "metallic": {"type": "uniform", "value": metallic},
            "perceptual_roughness": {"type": "uniform", "value": roughness},
            **more,
        }
    )


def seen_along(towards: np.ndarray, n: tuple[float, float, float] = UP, ng: tuple[float, float, float] = UP) -> Any:
    """A hit of shading normal n on a plane of normal ng, for each unit vector (3, lanes) to the viewer."""
    si = dr.zeros(mi.SurfaceInteraction3f, towards.shape[1])
    si.n = mi.Normal3f(*ng)
    si.sh_frame = mi.Frame3f(dr.normalize(mi.Vector3f(*n)))
    si.wi = si.to_local(mi.Vector3f(towards))
    return si


def views(n_dot_v: np.ndarray) -> np.ndarray:
    return np.stack([np.sqrt(1.0 - n_dot_v**2), np.zeros_like(n_dot_v), n_dot_v])


def upper(count: int, seed: int) -> np.ndarray:
    """Directions evenly over the upper hemisphere, but for its last degree."""
    random = np.random.default_rng(seed)
    z, phi = random.uniform(0.02, 1.0, count), random.uniform(0.0, 2.0 * np.pi, count)
    return np.stack([np.sqrt(1.0 - z * z) * np.cos(phi), np.sqrt(1.0 - z * z) * np.sin(phi), z])


def drawn(bsdf: Any, si: Any, seed: int = 1) -> tuple[Any, np.ndarray]:
    random = np.random.default_rng(seed).random((3, dr.width(si.wi))).astype(np.float32)
    sample, weight = bsdf.sample(mi.BSDFContext(), si, mi.Float(random[0]), mi.Point2f(random[1:]), True)
    return sample, np.array(weight)


def evaluated(bsdf: Any, si: Any, light: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    value, density = bsdf.eval_pdf(mi.BSDFContext(), si, si.to_local(mi.Vector3f(light)), True)
    return np.array(value), np.array(density)


def furnace(bsdf: Any) -> tuple[np.ndarray, np.ndarray]:
    """What is reflected of constant light at `VIEWS`, and its standard error, by channel."""
    _, weight = drawn(bsdf, seen_along(views(np.repeat(VIEWS, SAMPLES))))
    each = weight.reshape(3, len(VIEWS), SAMPLES)
    return each.mean(-1), each.std(-1) / np.sqrt(SAMPLES)


@pytest.mark.parametrize("view", ["steep", "grazing", "from behind the shading normal"])
@pytest.mark.parametrize("what", ["half metal", "rough paint", "coated"])
def test_samples_follow_their_density(what: str, view: str) -> None:
    from mitsuba.python.chi2 import ChiSquareTest, SphericalDomain

    bsdf = {
        "half metal": lambda: gltf(metallic=0.5, roughness=0.4),
        "rough paint": lambda: gltf(roughness=0.9),
        "coated": lambda: gltf(roughness=0.8, clearcoat=1.0, clearcoat_roughness=0.4),
    }[what]()
    cosine = {"steep": 0.8, "grazing": 0.15, "from behind the shading normal": 0.2}[view]
    n = (-0.8, 0.2, 0.6) if view.startswith("from") else (0.1, 0.2, 0.9)

    def sample(points: Any) -> tuple[Any, Any]:
        si = seen_along(views(np.full(dr.width(points), cosine)), n)
        found, _ = bsdf.sample(mi.BSDFContext(), si, points[0], mi.Point2f(points[1], points[2]), True)
        return si.to_world(found.wo), dr.select(found.pdf > 0.0, mi.Float(1.0), 0.0)

    def density(light: Any) -> Any:
        si = seen_along(views(np.full(dr.width(light), cosine)), n)
        return bsdf.pdf(mi.BSDFContext(), si, si.to_local(light), True)

    test = ChiSquareTest(SphericalDomain(), sample, density, sample_dim=3, sample_count=300_000, res=50, ires=32)
    # Nine tests by chance all pass with probability 0.98.
    assert test.run(significance_level=0.002, quiet=True), test.messages


@pytest.mark.parametrize("roughness", ROUGHNESS)
@pytest.mark.parametrize("metallic", [0.0, 1.0])
def test_a_furnace_shows_appendix_b(metallic: float, roughness: float) -> None:
    albedo, noise = furnace(gltf(metallic=metallic, roughness=roughness, single_scattering=True))
    alpha, color = roughness**2, np.array(COLOR)
    a, b = dfg(VIEWS, alpha, 1 << 15).T
    f0 = color * metallic + 0.04 * (1.0 - metallic)

    def diffuse(cos_i: np.ndarray, cos_o: np.ndarray, delta_phi: np.ndarray) -> np.ndarray:
        """(1 - F(v·h))/π; cos Δφ = 1 here means one side, so that l·v is the larger."""
        l_dot_v = cos_i * cos_o + np.sqrt((1.0 - cos_i**2) * (1.0 - cos_o**2)) * np.cos(delta_phi)
        v_dot_h = np.sqrt(0.5 + 0.5 * l_dot_v)
        return ((0.96 - 0.96 * (1.0 - v_dot_h) ** 5) / np.pi)[..., None]

    below = directional_albedo(FunctionBrdf(diffuse), VIEWS)[:, 0] * (1.0 - metallic)
    wanted = f0[:, None] * a + b + color[:, None] * below
    # 5 standard errors, and what `dfg` is good to
    np.testing.assert_array_less(np.abs(albedo - wanted), 5.0 * noise + 4e-4)
    if metallic == 1.0 and roughness == 1.0:  # n·v = 1: 1 - ln 2 is left, see `directional_albedo` of 1/2π(n·l + 1)
        assert albedo[:, 3] == pytest.approx((1.0 - np.log(2.0)) * color, abs=3e-3)


@pytest.mark.parametrize("roughness", [0.0, *ROUGHNESS])
@pytest.mark.parametrize("metallic", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("color", [COLOR, (1.0, 1.0, 1.0)])
def test_a_furnace_shows_what_playback_draws(color: Any, metallic: float, roughness: float) -> None:
    """Of what is half metal, the mean of both, which keeps white white."""
    albedo, noise = furnace(gltf(color, metallic, roughness))
    wanted = sum(GlossyGgx(color, metallic, roughness).weights(VIEWS)).T
    # 5 standard errors, and what both tables err by
    np.testing.assert_array_less(np.abs(albedo - wanted), 5.0 * noise + 2e-3)
    if min(color) == 1.0:
        np.testing.assert_array_less(np.abs(albedo - 1.0), 5.0 * noise + 2e-3)


def test_single_scattering_is_reciprocal() -> None:
    bsdf = gltf(metallic=0.3, roughness=0.4, single_scattering=True, ior=1.8, specular=0.7)
    one, other = upper(4096, 1), upper(4096, 2)
    there, back = evaluated(bsdf, seen_along(one), other)[0], evaluated(bsdf, seen_along(other), one)[0]
    # h is 1e-7 short of its place, and D as steep as 2/α = 12 there; near the horizon cosines lose digits
    np.testing.assert_allclose(there / other[2], back / one[2], rtol=2e-4)


def test_a_white_metal_is_mitsubas_but_for_correlated_shadowing() -> None:
    alpha = 0.36
    ours = gltf((1.0, 1.0, 1.0), 1.0, np.sqrt(alpha), single_scattering=True)
    theirs = mi.load_dict({"type": "roughconductor", "distribution": "ggx", "alpha": alpha, "material": "none"})
    view, light = upper(4096, 3), upper(4096, 4)
    value, density = evaluated(ours, seen_along(view), light)
    expected, expected_density = evaluated(theirs, seen_along(view), light)

    def apart(cosine: np.ndarray) -> np.ndarray:
        """G1/(2 cos) [Walter07, eq. 34]: theirs are two, independent of each other."""
        return np.asarray(1.0 / (cosine + np.sqrt(alpha**2 + (1.0 - alpha**2) * cosine**2)))

    ratio = v_smith_ggx(light[2], view[2], alpha) / (apart(light[2]) * apart(view[2]))
    np.testing.assert_allclose(value, expected * ratio, rtol=2e-4)
    np.testing.assert_allclose(density, expected_density, rtol=2e-4)


def test_without_specular_light_it_is_mitsubas_diffuse() -> None:
    ours, theirs = gltf(specular=0.0), mi.load_dict({"type": "diffuse", "reflectance": {"type": "rgb", "value": COLOR}})
    view, light = upper(512, 5), upper(512, 6)
    value, _ = evaluated(ours, seen_along(view), light)
    np.testing.assert_allclose(value, evaluated(theirs, seen_along(view), light)[0], rtol=1e-5)


@pytest.mark.parametrize(("color", "metallic"), [(COLOR, 1.0), ((0.0, 0.0, 0.0), 0.0)])
def test_roughness_0_is_the_projects_mirror(color: Any, metallic: float) -> None:
    """Also where rays are bent above the surface: the shading normal leans by 50°."""
    mirror = mi.load_dict(
        {
            "type": "reflet_mirror",
            "f0": mi.ScalarColor3f(0.04),
            "f90": 1.0,
            "unlit": False,
            "base_color": {"type": "srgb", "color": list(color)},
            "metallic": {"type": "uniform", "value": metallic},
            "double_sided": False,
        }
    )
    si = seen_along(upper(4096, 7), (0.76, 0.0, 0.64))
    theirs, weight = drawn(mirror, si)
    ours, own = drawn(gltf(color, metallic, 0.0), si)
    mirrors = np.array(theirs.sampled_type) == +mi.BSDFFlags.DeltaReflection
    share = np.array(theirs.pdf)[mirrors]  # half of a dielectric's samples mirror
    assert mirrors.sum() > 1500
    np.testing.assert_array_equal(np.array(ours.sampled_type), +mi.BSDFFlags.DeltaReflection)
    np.testing.assert_allclose(np.array(ours.wo)[:, mirrors], np.array(theirs.wo)[:, mirrors], atol=1e-6)
    # The cosine is half a difference of two unit vectors in float32; Fresnel's fifth power makes 5 roundings of one.
    np.testing.assert_allclose(own[:, mirrors], weight[:, mirrors] * share, atol=1e-5)


def test_lobes_narrow_down_to_the_mirrored_ray() -> None:
    """Bent rays too, and those whose shading normal turns away from the viewer."""
    si = seen_along(upper(4096, 8), (0.76, 0.0, 0.64))
    mirrors, _ = drawn(gltf(COLOR, 1.0, 0.0), si)
    narrow, weight = drawn(gltf(COLOR, 1.0, 0.02), si)
    away = np.array(dr.norm(narrow.wo - mirrors.wo))
    # α = 4e-4: half of GGX's normals lie within α, and mirrored rays turn twice as far
    assert np.quantile(away, 0.5) < 1e-3
    assert np.quantile(away, 0.95) < 2e-2
    behind = np.array(si.wi)[2] < 0.0
    assert behind.sum() > 500
    assert np.mean(weight[0, behind] > 0.0) > 0.7, "no black where the shading normal turns away"


def test_a_shading_normal_turns_the_whole_lobe() -> None:
    """As if the plane itself were tilted, for light and viewer above both."""
    lean = np.array([0.3, 0.1, 0.9]) / np.linalg.norm([0.3, 0.1, 0.9])
    tilted = (float(lean[0]), float(lean[1]), float(lean[2]))
    view, light = upper(4096, 9), upper(4096, 10)
    mirrored = 2.0 * (lean @ view) * lean[:, None] - view
    keep = (lean @ view > 0.01) & (lean @ light > 0.01) & (mirrored[2] > 0.01)
    bsdf = gltf(metallic=0.5, roughness=0.4)
    shaded = evaluated(bsdf, seen_along(view[:, keep], tilted), light[:, keep])
    plane = evaluated(bsdf, seen_along(view[:, keep], tilted, tilted), light[:, keep])
    for one, other in zip(shaded, plane, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-5)


def test_index_specular_and_coat_reflect_as_their_extensions_say() -> None:
    si = seen_along(views(np.repeat([1.0, 0.3], SAMPLES)))

    def mean(**more: Any) -> np.ndarray:
        return drawn(gltf((0.0, 0.0, 0.0), 0.0, 0.0, **more), si)[1].reshape(3, 2, SAMPLES).mean(-1)

    grazing = 0.7**5
    water = (0.33 / 2.33) ** 2
    np.testing.assert_allclose(mean(ior=1.33)[0], [water, water + (1.0 - water) * grazing], atol=1e-5)
    red = mean(specular=0.5, specular_color=mi.ScalarColor3f(1.0, 0.0, 2.0))
    f0 = np.array([0.04, 0.0, 0.08])
    np.testing.assert_allclose(red[:, 0], 0.5 * f0, atol=1e-5)
    np.testing.assert_allclose(red[:, 1], 0.5 * (f0 + (1.0 - f0) * grazing), atol=1e-5)
    coat = 0.5 * np.array([0.04, 0.04 + 0.96 * grazing])
    np.testing.assert_allclose(mean(specular=0.0, clearcoat=0.5)[0], coat, atol=1e-5)


@pytest.mark.parametrize("roughness", [0.0, 0.6])
def test_what_a_coat_reflects_is_missing_below(roughness: float) -> None:
    albedo, noise = furnace(gltf((1.0, 1.0, 1.0), 1.0, 0.3, clearcoat=1.0, clearcoat_roughness=roughness))
    fresnel = 0.04 + 0.96 * (1.0 - VIEWS) ** 5
    kept = dfg(VIEWS, roughness**2, 1 << 15).sum(1)  # the coat's lobe has no gain
    np.testing.assert_array_less(np.abs(albedo - (fresnel * kept + 1.0 - fresnel)), 5.0 * noise + 4e-3)


def test_backs_are_black_unless_double_sided() -> None:
    below = views(-VIEWS)
    light = -upper(4, 11)
    assert not evaluated(gltf(), seen_along(below), light)[0].any()
    assert not drawn(gltf(), seen_along(below))[1].any()
    both = gltf(double_sided=True)
    back, _ = evaluated(both, seen_along(below), light)
    np.testing.assert_allclose(back, evaluated(both, seen_along(-below), -light)[0], rtol=1e-5)
    assert back.min() > 0.0
