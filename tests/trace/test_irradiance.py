"""Cached diffuse light: closed forms, seams, sides, and the path integrator."""

import numpy as np
import pytest
from trace_scenes import CHROME, camera, constant_light, quad, room, scene, sphere

from reflet.scene.material import EnvironmentLight, Material
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.scene import Part, Scene
from reflet.scene.surfaces.irradiance import IrradianceMap
from reflet.trace.compose import compose
from reflet.trace.device_scene import DeviceScene
from reflet.trace.light.irradiance import trace_irradiance
from reflet.trace.light.mesh_colors import sample_sites
from reflet.trace.references.path_reference import path_traced
from reflet.trace.tracer import Tracer
from reflet.trace.variant import use_variant

WHITE = Material("white", base_color=(1, 1, 1), metallic=0.0)
GREY = Material("grey", base_color=(0.5, 0.5, 0.5), metallic=0.0)
BLACK_LAMP = Material("lamp", base_color=(0, 0, 0), metallic=0.0, emission=(5.0, 5.0, 5.0))


def irradiance(what: Scene, spp: int = 64, budget: int = 2000, seed: int = 0) -> IrradianceMap:
    use_variant()
    return trace_irradiance(DeviceScene(what), spp=spp, budget=budget, seed=seed)


def disc(radius: float, height: float, downwards: bool, count: int = 64) -> Mesh:
    angle = 2.0 * np.pi * np.arange(count) / count
    # the polygon's area is made the circle's
    r = radius * np.sqrt(2.0 * np.pi / count / np.sin(2.0 * np.pi / count))
    rim = np.stack([r * np.cos(angle), np.full(count, height), r * np.sin(angle)], -1)
    fan = np.stack([np.zeros(count - 2), np.arange(1, count - 1), np.arange(2, count)], -1).astype(np.uint32)
    normal = (0.0, -1.0, 0.0) if downwards else (0.0, 1.0, 0.0)
    order = fan if downwards else fan[:, ::-1].copy()
    return Mesh(rim.astype(np.float32), np.tile(normal, (count, 1)).astype(np.float32), order)


def floor(half: float = 0.05) -> Mesh:
    return quad((-half, 0, -half), (0, 0, 2 * half), (2 * half, 0, 0))


def test_plane_under_a_constant_sky_shows_its_radiance() -> None:
    found = irradiance(scene([Part("floor", floor(1.0), WHITE)], [], constant_light(1.7)))
    # 64 paths a sample whose estimates spread by about 30 % leave 4 %; the mean over 2000 samples 0.1 %
    np.testing.assert_allclose(found.radiosity, 1.7, rtol=0.2)
    assert found.radiosity.mean() == pytest.approx(1.7, rel=5e-3)


def test_disc_lamp_over_a_plane_has_its_form_factor() -> None:
    radius, height = 0.5, 1.0
    parts = [Part("floor", floor(), WHITE), Part("lamp", disc(radius, height, downwards=True), BLACK_LAMP)]
    found = irradiance(scene(parts, []), spp=128)
    factor = radius**2 / (radius**2 + height**2)
    # the floor is 1/20 of the height across: the factor falls by less than 1 % from its middle to its rim
    assert found.radiosity.mean() == pytest.approx(5.0 * factor, rel=1e-2)
    assert found.resolution[2:].max() == 0, "black lamps need no samples"


def test_lamp_that_shines_away_or_hides_behind_a_back_gives_nothing() -> None:
    away = [Part("floor", floor(), WHITE), Part("lamp", disc(0.5, 1.0, downwards=False), BLACK_LAMP)]
    assert not irradiance(scene(away, [])).radiosity.any()
    shade = quad((-2, 0.5, -2), (0, 0, 4), (4, 0, 0))
    hidden = [
        Part("floor", floor(), WHITE),
        Part("shade", shade, WHITE),
        Part("lamp", disc(0.5, 1.0, downwards=True), BLACK_LAMP),
    ]
    found = irradiance(scene(hidden, []))
    on_floor = found.offset[2]
    assert not found.radiosity[:on_floor].any(), "the shade's back is opaque and black"
    assert found.radiosity[on_floor:].mean() > 0.1


@pytest.mark.parametrize("mirror", [False, True])
def test_closed_furnace(mirror: bool) -> None:
    """Walls of emission e and albedo ρ see e/(1 - ρ) everywhere, a perfect mirror among them or not."""
    glow = Material("glow", base_color=(0.5, 0.2, 0.0), metallic=0.0, emission=(1.0, 1.0, 1.0))
    parts = [Part("room", room(), glow)]
    if mirror:
        parts.append(Part("ball", sphere(radius=0.5, rows=24), Material("all", base_color=(1, 1, 1)), True))
    found = irradiance(scene(parts, [(1,)] if mirror else []), spp=64, budget=3000)
    # Sixteen passes leave 0.5^17 of the light out; a ball of triangles traps 0.5 % of the rays for over 8 bounces.
    mean = found.radiosity.mean(0)
    np.testing.assert_allclose(mean, [2.0, 1.25, 1.0], rtol=1e-2)
    assert found.radiosity[:, 2].std() < 0.1


def test_a_sun_in_the_environment_is_found_by_sampling() -> None:
    """One pixel of the sky is 10⁴ times as bright as the rest: without importance sampling 64 rays would miss it."""
    sky = np.full((32, 64, 3), 0.1, np.float32)
    sky[6, 20] = 1e3
    theta = (6 + 0.5) / 32 * np.pi
    pixel = (np.cos(6 / 32 * np.pi) - np.cos(7 / 32 * np.pi)) * 2.0 * np.pi / 64
    found = irradiance(scene([Part("floor", floor(), WHITE)], [], EnvironmentLight(sky)))
    # bilinear filtering keeps a pixel's flux to second order in its size, 5°
    expected = 0.1 + 1e3 * np.cos(theta) * pixel / np.pi
    assert found.radiosity.mean() == pytest.approx(expected, rel=2e-2)
    # what is left is the spread of cosine over the pixel, and the dim sky's
    assert found.radiosity.std() < 0.03 * expected


def test_sides_of_a_double_sided_sheet_are_lit_apart() -> None:
    sheet = Material("paper", base_color=(0.8, 0.8, 0.8), metallic=0.0, double_sided=True)
    parts = [
        Part("sheet", quad((-0.2, 0, -0.2), (0, 0, 0.4), (0.4, 0, 0)), sheet),
        Part("lamp", disc(0.5, 1.0, downwards=True), BLACK_LAMP),
    ]
    found = irradiance(scene(parts, []))
    samples = int((found.resolution[0] + 1) * (found.resolution[0] + 2) // 2)
    assert found.offset[1] == 2 * samples
    assert found.radiosity[:samples].mean() == pytest.approx(5.0 * 0.2, rel=0.1)  # near the axis: form factor 1/5
    assert not found.radiosity[samples : 2 * samples].any()


def test_coincident_samples_are_one() -> None:
    """Where triangles meet they share estimates, so that no seam shows; where a wall turns they do not."""
    sites = sample_sites(scene([Part("floor", floor(1.0), GREY)], []), 500)
    resolution = int(sites.resolution[0])
    assert len(sites.starts) - 1 == (resolution + 1) ** 2
    assert len(sites.triangle) == (resolution + 1) * (resolution + 2)
    np.testing.assert_array_equal(np.sort(sites.members), np.arange(len(sites.site)))
    for site in range(len(sites.starts) - 1):
        members = sites.members[sites.starts[site] : sites.starts[site + 1]]
        assert (sites.site[members] == site).all()
    corner = sample_sites(scene([Part("room", room(), GREY)], []), 500)
    assert len(corner.starts) - 1 == 6 * (int(corner.resolution[0]) + 1) ** 2


def test_grid_points_are_numbered_as_the_record_says() -> None:
    sites = sample_sites(scene([Part("floor", floor(1.0), GREY)], []), 2000)
    r = int(sites.resolution[0])
    expected = [(i, j) for i in range(r + 1) for j in range(r + 1 - i)]
    np.testing.assert_array_equal(np.stack([sites.i, sites.j], -1)[: len(expected)], expected)
    assert len(sites.triangle) <= 2000 < 2 * (r + 2) * (r + 3) // 2 * 1.05


def test_cached_light_shows_the_path_integrators_picture() -> None:
    lamp = quad((-0.3, 0.98, -0.3), (0.6, 0, 0), (0, 0, 0.6))
    block = quad((-0.7, -0.4, 0.4), (0, 0, -0.6), (0.5, 0.0, 0.0))
    red = Material("red", base_color=(0.8, 0.2, 0.1), metallic=0.0, double_sided=True)
    parts = [
        Part("room", room(), GREY),
        Part("lamp", lamp, BLACK_LAMP),
        Part("shelf", block, red),
        Part("ball", sphere((0.4, -0.5, 0.0), 0.4, rows=24), CHROME, True),
    ]
    what = scene(parts, [(3,)])
    view = camera((0.0, 0.1, 0.95), size=32)
    found = compose(Tracer(what, irradiance=irradiance(what, 128, 20000)).view(view, spp=64, surroundings=True).layers)
    expected = path_traced(what, view, spp=512, max_depth=16)
    blocks = [image.reshape(8, 4, 8, 4, 3).mean((1, 3)) for image in (found, expected)]
    error = np.abs(blocks[0] - blocks[1]) / (0.05 + blocks[1])
    # the reference's own noise is about 2 % a block of 16 pixels, more where the lamp is mirrored
    assert np.median(error) < 0.02
    assert np.quantile(error, 0.95) < 0.1
    assert found.mean() == pytest.approx(expected.mean(), rel=1.5e-2)
