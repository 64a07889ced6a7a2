"""Maps of measured BRDFs made on the device, against brute force in double precision."""

import numpy as np
import pytest
from map_scenes import analytic_levels

from reflet.envmap.env_image import EnvImage
from reflet.envmap.lamp import Lamp
from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.parameterizations.octahedral import Octahedral
from reflet.envmap.resampling.mip_reduction import mip_images
from reflet.reflectance.brdfs.brdf import FunctionBrdf
from reflet.reflectance.brdfs.lambert import Lambert
from reflet.reflectance.lobes.lobes import THETA, Lobes, fit_lobes
from reflet.reflectance.materials.material_maps import EnvironmentMaps
from reflet.reflectance.materials.measured_material import Measured
from reflet.render.filters.live_environment import LiveEnvironment
from reflet.render.maps.env_map_texture import EnvMapTexture
from reflet.render.materials.material_renderer import MaterialRenderer
from reflet.scene.meshes.primitives import sphere_mesh
from reflet.scene.views.camera import Camera

SIZE, ANGLES = 64, 3
LAMP = Lamp((0.5, 0.6, 0.3), 10.0, (20.0, 15.0, 8.0))


def paint(cos_i: np.ndarray, cos_o: np.ndarray, delta_phi: np.ndarray) -> np.ndarray:
    """Red ground, a yellow highlight, and a blue one back to the viewer."""
    sines = np.sqrt((1.0 - cos_i**2) * (1.0 - cos_o**2))
    mirrored, back = (np.maximum(cos_i * cos_o + side * sines * np.cos(delta_phi), 0.0) for side in (-1.0, 1.0))
    glossy, retro = (mirrored**20)[..., None] * [1.0, 1.0, 0.3], (back**10)[..., None] * [0.2, 0.4, 1.0]
    return 0.1 * np.array([1.0, 0.3, 0.2]) + glossy + retro


@pytest.fixture(scope="module")
def material() -> Measured:
    return Measured(fit_lobes(FunctionBrdf(paint), angles=ANGLES))


@pytest.fixture(scope="module")
def live() -> LiveEnvironment:
    """One for all tests: what was shown before must leave no trace."""
    return LiveEnvironment(SIZE)


def sky(direction: np.ndarray) -> np.ndarray:
    """With a lamp some 10° wide on an edge of the cube, 20 times as bright."""
    axis = np.array([0.7, 0.1, 0.7]) / np.linalg.norm([0.7, 0.1, 0.7])
    return 0.3 + 0.2 * direction[..., 1:2] + np.exp(150.0 * (direction @ axis - 1.0))[..., None] * [8.0, 4.0, 2.0]


def slices(shown: EnvMapTexture, level: int = 0) -> np.ndarray:
    """All of them: (slices, rows, columns, 3)."""
    count = shown.texture.depth_or_array_layers
    return np.concatenate([shown.read(level, k).texels[..., :3] for k in range(count)]).astype(float)


def error(shown: EnvMapTexture, image: EnvImage, lobes: Lobes) -> float:
    """Mean over all slices of what some texels are off, as a share of the mean of what they should hold.

    That is Σ k·L·Ω over the environment's texels, in double precision: of 1.4°, against lobes of 10° and more.
    """
    to, kind = shown.parameterization, image.parameterization
    some = np.random.default_rng(5).choice(shown.size**2, 100)
    direction, weight = (
        of(shown.size).reshape(shown.size**2, -1)[some]
        for of in (lambda n: to.texel_directions(n)[0], to.texel_solid_angle)
    )
    lit = image.texels.any(-1)
    light = image.texels[lit].astype(float) * kind.texel_solid_angle(image.size)[lit][:, None]
    angle = np.arccos(np.clip(direction @ kind.texel_directions(image.size)[0][lit].T, -1.0, 1.0))
    densities = np.concatenate([lobe.densities for lobe in lobes.lobes])
    found = slices(shown).reshape(len(densities), -1, 3)[:, some]
    expected = np.stack(
        [[np.interp(angle, THETA, table[:, c]) @ light[:, c] for c in range(3)] for table in densities]
    ).swapaxes(1, 2)
    return float((weight * np.abs(found - expected)).sum() / (weight * expected).sum())


def test_slices_against_brute_force(live: LiveEnvironment, material: Measured) -> None:
    image = analytic_levels(CUBE, SIZE, sky)[0]
    live.show(image)
    # 61 taps leave 0.004; light elsewhere or a slice that is another's 0.2 and more.
    assert error(live.maps(material).reflected, image, material.lobes) < 0.01


def test_a_lamp_that_moves_against_brute_force(live: LiveEnvironment, material: Measured) -> None:
    """In the dark: nothing hides what is off. A disc with an edge shows single taps, and its light may not change."""
    dark = EnvImage(CUBE, np.zeros((6, SIZE, SIZE, 3), np.float16))
    direction, _ = CUBE.texel_directions(2 * SIZE)
    for azimuth in (0.0, 2.0):
        lamp = Lamp((np.cos(azimuth), 0.6, np.sin(azimuth)), LAMP.radius_deg, LAMP.radiance)
        live.show(dark, lamp)
        light = EnvImage(CUBE, (lamp.share(direction)[..., None] * lamp.radiance).astype(np.float32))
        shown = live.maps(material).reflected
        assert error(shown, light, material.lobes) < 0.07  # measured 0.056 and less
        solid_angle = Octahedral().texel_solid_angle(shown.size)[..., None]
        flux = (light.texels * CUBE.texel_solid_angle(2 * SIZE)[..., None]).sum((0, 1, 2))
        albedo = np.concatenate([lobe.albedo for lobe in material.lobes.lobes])
        kept = (slices(shown) * solid_angle).sum((1, 2))
        # Lookups at texels' centres, and a pyramid that catches a small lamp within some hundredths; atol: black slices
        np.testing.assert_allclose(kept, albedo * flux, rtol=0.03, atol=1e-4 * flux.max())


def test_light_is_refiltered_when_it_changes_and_only_then(live: LiveEnvironment, material: Measured) -> None:
    image = analytic_levels(CUBE, SIZE, sky, np.float16)[0]
    live.show(image)
    without = slices(live.maps(material).reflected)
    live.show(image, LAMP)
    lit = slices(live.maps(material).reflected)
    # Less would be light lost; half floats round by 2⁻¹¹ of themselves.
    assert (lit - without).min() > -(2.0**-10) * without.max() and (lit - without).max() > 0.1
    live.show(image)
    other = Measured(fit_lobes(FunctionBrdf(lambda *at: 0.5 * paint(*at)), angles=ANGLES))
    np.testing.assert_allclose(slices(live.maps(other).reflected), 0.5 * without, atol=2e-3 * without.max())  # fits'
    np.testing.assert_array_equal(slices(live.maps(material).reflected), without)


def test_white_furnace_on_all_levels(live: LiveEnvironment, material: Measured) -> None:
    radiance = 0.699707  # a half float
    live.show(EnvImage(CUBE, np.full((6, SIZE, SIZE, 3), radiance, np.float16)))
    shown = live.maps(material).reflected
    albedo = np.concatenate([lobe.albedo for lobe in material.lobes.lobes])
    for level in range(shown.texture.mip_level_count):
        # Half a step of half floats, twice: coarser levels are means of what is rounded. atol: black slices
        expected = np.broadcast_to(radiance * albedo[:, None, None], slices(shown, level).shape)
        np.testing.assert_allclose(slices(shown, level), expected, rtol=2.0**-10, atol=1e-4)


def test_coarser_levels_are_means(live: LiveEnvironment, material: Measured) -> None:
    live.show(analytic_levels(CUBE, SIZE, sky)[0])
    shown = live.maps(material).reflected
    for number in (0, ANGLES + 1):
        finest = EnvImage(Octahedral(), slices(shown)[number : number + 1].astype(np.float32))
        for level, expected in enumerate(mip_images(finest)[1 : shown.texture.mip_level_count], start=1):
            # Solid angles of texels by the density at their centres: off by hundredths in the coarsest
            off = np.abs(slices(shown, level)[number] - expected.texels[0])
            assert off.mean() < 0.01 * expected.texels.mean()


def test_pictures_are_those_of_maps_filtered_by_the_cpu(material: Measured) -> None:
    """All of it: slices, diffuse light, table. The environment has a sun, 100 times as bright as its sky."""
    direction, _ = CUBE.texel_directions(SIZE)
    sun = (direction @ np.array([0.6, 0.64, 0.48]) > 0.97)[..., None]
    image = EnvImage(CUBE, (0.4 + 0.3 * direction[..., 1:2] + 40.0 * sun * [1.0, 0.9, 0.7]).astype(np.float16))
    camera = Camera((1.5, 1.2, 2.6), (0.0, 0.0, 0.0), fov_deg=50, width=72, height=60)
    live = LiveEnvironment(SIZE)
    live.show(image)
    still = EnvironmentMaps(EnvImage(CUBE, image.texels.astype(np.float32)), 32)
    mesh = sphere_mesh(around=128)
    shown, expected = (
        MaterialRenderer(mesh, each).picture(material, camera, samples=1, backdrop=False)[..., :3]
        for each in (live, still)
    )
    assert np.abs(shown - expected).mean() < 0.02 * expected.mean()  # measured 0.009


def test_diffuse_reflection_alone_has_no_slices(live: LiveEnvironment) -> None:
    live.show(EnvImage(CUBE, np.full((6, SIZE, SIZE, 3), 1.0, np.float16)))
    matt = Measured(fit_lobes(Lambert(), ("diffuse",), 2))
    picture = MaterialRenderer(sphere_mesh(), live).picture(
        matt, Camera((0.0, 0.0, 3.0), (0.0, 0.0, 0.0), width=32, height=32), samples=1
    )
    np.testing.assert_allclose(picture[16, 16], 1.0, atol=1e-3)  # the fit's
