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
from reflet.trace.light.irradiance import _foreseen, trace_irradiance
from reflet.trace.light.mesh_colors import MOST_SITES, sample_sites
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
        parts.append(
            Part(
                "ball",
                sphere(radius=0.5, rows=24),
                Material("all", base_color=(1, 1, 1), perceptual_roughness=0.0),
                True,
            )
        )
    found = irradiance(scene(parts, [(1,)] if mirror else []), spp=64, budget=3000)
    # A ball of triangles traps 0.5 % of the rays for over 8 bounces.
    mean = found.radiosity.mean(0)
    np.testing.assert_allclose(mean, [2.0, 1.25, 1.0], rtol=1e-2)
    assert found.radiosity[:, 2].std() < 0.1


def test_a_bright_furnace_settles() -> None:
    """Without foresight sixteen bounces would leave 0.9^17, a sixth of the light, out."""
    glow = Material("glow", base_color=(0.9, 0.9, 0.9), metallic=0.0, emission=(1.0, 1.0, 1.0))
    found = irradiance(scene([Part("room", room(), glow)], []), spp=64, budget=3000)
    # 0.13 % of the rays start in a corner and find no wall; over ten bounces they are 2 % of the light.
    np.testing.assert_allclose(found.radiosity.mean(0), 10.0, rtol=2.5e-2)


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


def bumps(count: int, size: float = 1.0) -> Mesh:
    """2·count² triangles of a wavy sheet around the origin."""
    u, v = np.meshgrid(np.linspace(-size, size, count + 1), np.linspace(-size, size, count + 1), indexing="ij")
    positions = np.stack([u, 0.05 * np.sin(9.0 * u) * np.sin(7.0 * v), v], -1).reshape(-1, 3).astype(np.float32)
    here = (np.arange(count)[:, None] * (count + 1) + np.arange(count)).ravel()
    across = here + count + 1
    triangles = np.concatenate([np.stack([here, here + 1, across], -1), np.stack([across, here + 1, across + 1], -1)])
    normals = np.zeros_like(positions)
    normals[:, 1] = 1.0
    return Mesh(positions, normals, triangles.astype(np.uint32))


def test_sites_grow_with_the_triangles_up_to_a_bound() -> None:
    """Every vertex is a site until there are four budgets of them; then neighbours share one."""
    budget, counts = 3000, {}
    for count in (20, 40, 80, 160, 320):
        sites = sample_sites(scene([Part("sheet", bumps(count), GREY)], []), budget)
        counts[count] = len(sites.starts) - 1
        assert len(sites.triangle) == sites.starts[-1] == len(sites.members)
        assert sites.triangle.max() == 2 * count * count - 1
    # every vertex, and samples besides in the largest triangles for a budget
    assert all((count + 1) ** 2 <= counts[count] <= (count + 1) ** 2 + budget for count in (40, 80))
    # the bound, and what the search for the size of cells may leave of it
    assert all(0.75 * MOST_SITES * budget <= counts[count] <= (MOST_SITES + 1) * budget for count in (160, 320))


def test_samples_that_share_a_site_lie_together_and_face_the_same_way() -> None:
    budget, mesh = 500, bumps(120)
    sites = sample_sites(scene([Part("sheet", mesh, Material(metallic=0.0, double_sided=True))], []), budget)
    r = sites.resolution[sites.triangle]
    weights = np.stack([r - sites.i - sites.j, sites.i, sites.j], -1) / r[:, None]
    position = np.einsum("sk,skc->sc", weights, mesh.positions[mesh.triangles[sites.triangle]])
    low, high = (np.full((len(sites.starts) - 1, 3), limit) for limit in (np.inf, -np.inf))
    np.minimum.at(low, sites.site, position)
    np.maximum.at(high, sites.site, position)
    # 2000 cells on the two sides of 4 m²: about 9 cm each, less than twice that with what is rounded
    assert (high - low).max() < 0.18
    backs = np.bincount(sites.site, sites.back)
    assert np.isin(backs / np.bincount(sites.site), (0.0, 1.0)).all(), "front and back are lit apart"


def test_small_triangles_do_not_take_the_samples_of_large_ones() -> None:
    """A floor of two triangles beside a sheet of many still shows shadows."""
    both = scene([Part("sheet", bumps(100), GREY), Part("floor", floor(2.0), GREY)], [])
    sites = sample_sites(both, 3000)
    assert (sites.resolution[-2:] > 40).all()  # 2·43²/2 = 1849 samples of at most 3000
    assert len(sites.starts) - 1 <= (MOST_SITES + 1) * 3000


def test_work_is_bounded_and_light_right_where_sites_are_shared() -> None:
    """Under a constant sky the sheet, its own shadows aside, shows the sky's radiance; paths are no more than for few
    triangles."""
    flat = bumps(120)
    flat.positions[:, 1] = 0.0
    found = irradiance(
        scene([Part("sheet", flat, Material(base_color=(0.5,) * 3, metallic=0.0))], [], constant_light(1.7)), budget=500
    )
    assert len(found.radiosity) == 3 * len(flat.triangles)
    # 16 paths a site, a quarter of 64, whose estimates spread by about 30 %; the mean over 2000 sites
    assert found.radiosity.mean() == pytest.approx(1.7, rel=1e-2)
    assert found.radiosity.std() < 0.1 * 1.7


@pytest.mark.parametrize("spp", [1, 3])
def test_any_number_of_paths_will_do(spp: int) -> None:
    """Also those that leave the last of the processor's packets half empty."""
    found = irradiance(scene([Part("floor", floor(1.0), WHITE)], [], constant_light(1.7)), spp=spp, budget=100)
    # estimates spread by about 30 %; 100 sites of them
    assert found.radiosity.mean() == pytest.approx(1.7, rel=0.1)


@pytest.mark.parametrize("means", [(0.97, 0.71, 0.35), (1.0, 0.5, 1e-6), (0.0, 1e-9, 1.0)])
def test_noise_foresees_no_negative_light(means: tuple[float, float, float]) -> None:
    """Means that fall, where the first passes found too much: what is foreseen is light all the same, and bounded."""
    assert 0.5 <= _foreseen(*means) <= 10.0
