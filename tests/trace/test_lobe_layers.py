"""Layers of rough parts: furnaces, quadrature, closed forms, and Mitsuba's path integrator with the same materials."""

from dataclasses import replace

import numpy as np
import pytest
from trace_scenes import CHROME, Vec3, camera, constant_light, no_irradiance, quad, scene, sphere

from reflet.reflectance.brdfs.dfg import dfg, energy_compensation, half_vector_samples
from reflet.scene.material import EnvironmentLight, Material, Texture
from reflet.scene.scene import Part, Scene
from reflet.scene.surfaces.irradiance import IrradianceMap
from reflet.trace import camera_rays
from reflet.trace.compose import compose, object_coverage
from reflet.trace.layers import SegmentedLayers, Shells
from reflet.trace.references.path_reference import PathReference
from reflet.trace.tracer import Tracer


def rough(perceptual_roughness: float, color: Vec3 = (1.0, 1.0, 1.0), metallic: float = 1.0) -> Material:
    return Material("rough", color, metallic, perceptual_roughness)


def tracer_of(what: Scene) -> Tracer:
    return Tracer(what, irradiance=no_irradiance(what))


def seen_sphere(layers: SegmentedLayers, centre: np.ndarray, least: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rows whose n·v on a unit sphere is at least so much, and there the unit vectors to the viewer and the normals."""
    view = layers.camera
    corner, dx, dy = view.ray_basis()
    y, x = np.divmod(layers.pixel, view.width)
    d = corner + (x + 0.5)[:, None] * dx + (y + 0.5)[:, None] * dy
    d /= np.linalg.norm(d, axis=-1, keepdims=True)
    eye = np.asarray(view.position) - centre
    b = d @ eye
    n = eye + (-b - np.sqrt(np.maximum(b * b - eye @ eye + 1.0, 0.0)))[:, None] * d
    some = (layers.coverage == 1.0) & (-(n * d).sum(-1) > least)
    return some, -d[some], n[some]


def test_a_furnace_shows_the_albedo() -> None:
    """All of it: what the dielectric does not reflect is diffuse, under irradiance/π of 1."""
    kinds = [(roughness, metallic) for roughness in (0.1, 0.3, 0.5, 0.8) for metallic in (0.0, 0.5, 1.0)]
    tiles = [
        Part(f"tile {k}", quad((0.0, k - 6.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)),
             rough(kind[0], (0.8, 0.8, 0.8), kind[1]), True)
        for k, kind in enumerate(kinds)
    ]  # fmt: skip
    what = scene(tiles, [tuple(range(12))], constant_light(1.0))
    once, zero = np.ones(24, np.uint32), np.zeros(24, np.uint32)
    tracer = Tracer(what, irradiance=IrradianceMap(once, zero, np.ones((6, 3), np.float32)))
    for n_dot_v in (1.0, 0.6, 0.25):  # nearly the same in all of the picture
        eye = (400.0 * np.sqrt(1.0 - n_dot_v**2) + 0.5, 0.001, 400.0 * n_dot_v)
        layers = tracer.view(replace(camera(eye, 72, (0.5, 0.0, 0.0)), fov_deg=1.8), spp=64).layers
        np.testing.assert_allclose(layers.distant, 1.0, rtol=1e-5)
        assert not layers.local.any() and not layers.alpha.any()
        for number, (roughness, metallic) in enumerate(kinds):
            rows = (layers.part == number) & (layers.coverage > 0.5)
            assert rows.sum() > 5
            a, b = dfg(np.array([n_dot_v]), roughness**2).T
            paint, metal = ((f0 * a + b) * energy_compensation(np.array(f0), a + b) for f0 in (0.04, 0.8))
            wanted = float((paint + metallic * (metal - paint))[0])
            # half a per cent: the table is good to 3e-3
            np.testing.assert_allclose(layers.fresnel[rows], wanted, rtol=5e-3)
            np.testing.assert_allclose(layers.combined[rows], layers.fresnel[rows], rtol=1e-5)
            np.testing.assert_allclose(
                layers.diffuse[rows], (1.0 - metallic) * 0.8 * (1.0 - float(paint[0])), atol=1e-3
            )


def test_distant_light_is_the_lobes_mean() -> None:
    """Of an environment of one harmonic, 1 + (3(a·l)² - 1)/2, against quadrature by half vectors."""
    axis = np.array([0.48, 0.6, 0.64])
    v, u = np.mgrid[0.5:64.5, 0.5:128.5] / 64.0 * np.pi
    towards = np.stack([-np.cos(u) * np.sin(v), np.cos(v), -np.sin(u) * np.sin(v)], -1)
    light = np.repeat(1.5 * (towards @ axis)[..., None] ** 2 + 0.5, 3, -1)
    balls = [
        Part(f"ball {r}", sphere((200.0 * k, 0.0, 0.0), rows=96), rough(r), True) for k, r in enumerate((0.2, 0.6))
    ]
    tracer = tracer_of(scene(balls, [(0, 1)], EnvironmentLight(light.astype(np.float32))))
    for number, roughness in enumerate((0.2, 0.6)):
        centre = np.array([200.0 * number, 0.0, 0.0])
        layers = tracer.view(camera((centre[0], 0.4, 4.0), 32, (centre[0], 0.0, 0.0)), spp=256).layers
        some, to_viewer, n = seen_sphere(layers, centre, 0.3)
        cosine = (to_viewer * n).sum(-1)
        drawn, _, weight = half_vector_samples(cosine, roughness**2, 4096)
        weight /= weight.sum(-1, keepdims=True)
        along = to_viewer - cosine[:, None] * n
        along /= np.linalg.norm(along, axis=-1, keepdims=True)
        x, z = np.moveaxis(drawn, -1, 0)
        at, an = along @ axis, n @ axis
        aside = np.maximum(1.0 - at**2 - an**2, 0.0)  # (axis·(n × along))²
        square = (weight * ((at[:, None] * x + an[:, None] * z) ** 2 + aside[:, None] * (1.0 - x * x - z * z))).sum(-1)
        error = layers.distant[some, 0] - (1.5 * square + 0.5)
        # 256 samples of deviation 0.4 leave 2.5 %, good points less; 450 pixels' mean a tenth of that
        assert np.sqrt((error**2).mean()) < 1.5e-2
        assert abs(error.mean()) < 2e-3
        # a facet's plane lies up to π/192 below its smooth normals' horizon and hides what the lobe has there
        assert layers.alpha[some].mean() < 1e-3


def test_below_the_limit_a_lobe_is_a_mirror_and_above_close_to_it() -> None:
    light = EnvironmentLight(np.random.default_rng(3).random((4, 8, 3)).astype(np.float32))
    pair = [sphere((-0.7, 0, 0), 0.6), sphere((0.7, 0, 0), 0.6)]

    def tracer(roughness: float) -> Tracer:
        metal = replace(CHROME, perceptual_roughness=roughness)
        return tracer_of(scene([Part(f"ball {k}", ball, metal, True) for k, ball in enumerate(pair)], [(0, 1)], light))

    assert not tracer(0.0299)._device.has_rough
    mirror, lobe = (tracer(roughness).view(camera(size=32), spp=64).layers for roughness in (0.0, 0.0301))
    np.testing.assert_array_equal(mirror.pixel, lobe.pixel)
    inside = mirror.coverage > 0.9
    # lobes of a few mrad: rays at edges meet others, and alpha is of light
    for name, tolerance in (("distant", 4e-3), ("local", 1.5e-2), ("alpha", 1.5e-2), ("combined", 1.5e-2)):
        difference = getattr(lobe, name)[inside] - getattr(mirror, name)[inside]
        assert np.sqrt((difference**2).mean()) < tolerance, name
    np.testing.assert_allclose(lobe.fresnel[inside], mirror.fresnel[inside], atol=4e-3)  # the table's rows


PLATE = quad((-1.0, -1.0, 0.0), (2.0, 0.0, 0.0), (0.0, 2.0, 0.0))
LAMP = quad((-0.5, -0.5, 3.0), (0.0, 1.0, 0.0), (1.0, 0.0, 0.0))  # shines towards -z
LID = quad((0.0, -0.9, 2.99), (0.9, 0.0, 0.0), (0.0, 1.8, 0.0))  # its back, black and opaque, towards the plate
PANEL = quad((-0.9, 0.0, 2.0), (1.8, 0.0, 0.0), (0.0, -0.9, 0.0))
AT_2 = Shells((0.0, 0.0, -50.0), (52.5,))


def lamp_scene(lamp: float, panel: float, sky: float, through: tuple[int, ...] = ()) -> Tracer:
    """A rough plate under a lamp, of which a part of its own object hides the right half, a nearer panel the lower."""
    parts = [Part("plate", PLATE, rough(0.7), True), Part("lid", LID, rough(0.7), True)]
    for name, mesh, glow in (("lamp", LAMP, lamp), ("panel", PANEL, panel)):
        parts.append(Part(name, mesh, Material(name, (0.0, 0.0, 0.0), 1.0, emission=(glow,) * 3)))
    what = scene(parts, [(0, 1)], constant_light(sky))
    return Tracer(what, irradiance=no_irradiance(what), through=through)


def test_alpha_is_the_share_of_the_light_that_is_hidden() -> None:
    """Half of a lamp's light, by symmetry, be it ever so little of the lobe's weight."""
    tracer = lamp_scene(lamp=8.0, panel=1e-9, sky=0.0)
    layers = tracer.view(camera((0.0, 0.0, 2.0), 32), spp=256, shells=[AT_2]).layers
    assert (layers.part == 0).all() and len(layers.pixel) == 1024
    alpha, near = layers.alpha.reshape(32, 32), layers.shells[:, 0, 3].reshape(32, 32)
    # 256 light samples, of which half are hidden: 3 %; and of their half again; the mean of 1024 pixels a tenth or two
    np.testing.assert_allclose(0.5 * (alpha + alpha[:, ::-1]), 0.5, atol=0.12)
    np.testing.assert_allclose(0.5 * (near + near[::-1]), 0.5, atol=0.12)
    assert alpha.mean() == pytest.approx(0.5, abs=4e-3)
    assert near.mean() == pytest.approx(0.5, abs=4e-3)
    assert alpha[:, 0].mean() < 0.48 and alpha[:, -1].mean() > 0.52, "more of what is near"
    assert not layers.local.any()
    # white metal: what it truly shows is the light that is left
    shown = layers.fresnel * (1.0 - layers.alpha[:, None]) * layers.distant
    np.testing.assert_allclose(layers.combined, shown, rtol=0.02)
    assert layers.distant[:, 0].mean() == pytest.approx(0.5 * layers.shells[:, 1, 0].mean(), rel=0.01)


def test_shells_compose_to_the_distant_layer() -> None:
    """Where all that shines is equally bright every layer says 1, whichever way its light was found."""
    layers = lamp_scene(lamp=1.0, panel=1.0, sky=1.0).view(camera((0.0, 0.3, 2.0), 32), spp=256, shells=[AT_2]).layers
    near, far = layers.shells[:, 0], layers.shells[:, 1]
    luminance = np.array([0.2126, 0.7152, 0.0722])
    composed = near[:, :3] + (1.0 - near[:, 3:]) * far[:, :3]
    np.testing.assert_allclose(composed @ luminance, layers.distant @ luminance, rtol=1e-5)
    # the lamp and the panel fill a tenth of the lobe: their light's noise is some per cent of 1, in the mean a tenth
    np.testing.assert_allclose(layers.distant[:, 0], 1.0, atol=0.1)
    assert layers.distant[:, 0].mean() == pytest.approx(1.0, abs=2e-3)
    assert far[:, 0].mean() == pytest.approx(1.0, abs=2e-3)
    assert near[:, 0].mean() == pytest.approx(near[:, 3].mean(), rel=0.02)
    np.testing.assert_array_equal(far[:, 3], 1.0)
    assert 0.01 < near[:, 3].mean() < 0.5


def test_light_of_companions_is_local() -> None:
    """Rays go through the lamp and the panel: what these send is local, and nothing else changes what is seen."""
    view = camera((0.0, 0.3, 2.0), 32)
    apart, with_them = (lamp_scene(8.0, 1.0, 0.5, through).view(view, spp=64).layers for through in ((), (0, 1, 2, 3)))
    np.testing.assert_allclose(with_them.distant, 0.5, rtol=1e-5)
    # the same rays and emitters, summed in another order
    np.testing.assert_allclose(with_them.combined, apart.combined, rtol=1e-4)
    assert with_them.local.mean() > 0.1 and not apart.local.any()
    # a lamp hides little of a sky that is even: its share of the lobe's weight
    assert 0.02 < with_them.alpha.mean() < 0.5


def everything() -> Scene:
    """Rough metal, paint and a bumpy plate of varying roughness, in two objects, under a lamp and a bright spot of sky.

    Nothing is diffuse: that light is interpolated.
    """
    rng = np.random.default_rng(5)
    spots = rng.integers(0, 255, (4, 4, 4)).astype(np.uint8)
    spots[0, :2, 1] = 0  # mirrors
    bumps = np.clip(rng.normal((128, 128, 255, 255), (25, 25, 0, 0), (4, 4, 4)), 0, 255).astype(np.uint8)
    bumpy = Material(
        "bumpy", (0.9, 0.6, 0.3), 1.0, 0.6, double_sided=True, normal_texture=Texture(bumps),
        metallic_roughness_texture=Texture(np.where(np.arange(4) == 2, 255, spots).astype(np.uint8)),
    )  # fmt: skip
    back = quad((-1.2, -0.8, -0.8), (2.4, 0.0, 0.0), (0.0, 1.8, 0.0))
    back = replace(back, tangents=np.tile(np.array([1, 0, 0, -1], np.float32), (4, 1)))
    shine = Material("shine", (0.0, 0.0, 0.0), 1.0, emission=(6.0, 5.0, 4.0))
    v, u = np.mgrid[0.5:128.5, 0.5:256.5] / 128.0 * np.pi
    waves = 0.3 + 0.2 * np.stack([np.cos(u), np.sin(u), np.cos(2.0 * u)], -1) * np.sin(v)[..., None]
    spot = 15.0 * np.exp(-((v - 0.9) ** 2 + (u - 4.2) ** 2) / 0.02)
    sky = (waves + spot[..., None]).astype(np.float32)  # Mitsuba's rows lie up to half a pixel from ours
    lamp = quad((-0.6, 1.7, 0.2), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    return scene(
        [
            Part("lamp", lamp, shine),
            Part("metal", sphere((-0.5, 0.0, 0.0), 0.45), rough(0.3, (0.9, 0.9, 0.9)), True),
            Part("paint", sphere((0.5, 0.0, 0.0), 0.45), rough(0.45, (0.0, 0.0, 0.0), 0.3), True),
            Part("back", back, bumpy, True),
        ],
        [(1, 2), (3,)],
        EnvironmentLight(sky),
    )


@pytest.fixture(scope="module")
def tracer() -> Tracer:
    return tracer_of(everything())


VIEW = camera((0.3, 0.5, 2.8), 24)


def test_layers_recombine_to_the_path_integrator(tracer: Tracer) -> None:
    """Pixel by pixel within noise, by what the same number of pictures vary on both sides."""
    reference, runs = PathReference(tracer.scene, materials="gltf"), 7
    seen = [tracer.view(VIEW, spp=64, seed=k, surroundings=True).layers for k in range(runs)]
    inside = np.all([object_coverage(layers) > 0.0 for layers in seen], 0)
    luminance = np.array([0.2126, 0.7152, 0.0722])
    ours = np.array([compose(layers)[inside] for layers in seen]) @ luminance
    theirs = np.array([reference.picture(VIEW, spp=128, seed=k, max_depth=10)[inside] for k in range(runs)]) @ luminance
    difference = ours.mean(0) - theirs.mean(0)
    variance = (ours.var(0, ddof=1) + theirs.var(0, ddof=1)) / runs
    assert inside.sum() > 250
    # the mean of Student's t² with some 15 degrees of freedom is 1.15, of 300 of them 0.1 off
    assert (difference**2 / variance).mean() < 1.5
    # ratio estimators of 64 samples are off by their variance over 64
    assert abs(difference.mean()) < 4.0 * np.sqrt(variance.sum()) / inside.sum() + 2e-3 * theirs.mean()
    assert theirs.mean(0).std() > 0.05


def test_samples_follow_from_seed_and_pixel_alone(tracer: Tracer, monkeypatch: pytest.MonkeyPatch) -> None:
    first = tracer.view(VIEW, spp=16, seed=1).layers
    other = tracer.view(VIEW, spp=16, seed=2).layers
    monkeypatch.setattr(camera_rays, "LANES", 250 * 16)
    again = tracer.view(VIEW, spp=16, seed=1).layers
    for name in ("pixel", "part", "coverage", "distant", "local", "alpha", "fresnel", "combined", "shells"):
        np.testing.assert_array_equal(getattr(first, name), getattr(again, name))
    assert (first.distant[:50] != other.distant[:50]).any()
