"""Meshes that mirror plain env maps, against closed forms."""

import numpy as np
import pytest
from map_scenes import analytic_levels, linear, sphere_reflections, view_rays

from reflet.envmap.env_image import EnvImage
from reflet.envmap.lod import lod_from_neighbours
from reflet.envmap.mip_chain import MipChain
from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS
from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.parameterizations.gazing_ball import GazingBall
from reflet.envmap.parameterizations.parameterization import Parameterization
from reflet.errors import RefletError
from reflet.render.maps.env_map_texture import upload_env_map
from reflet.render.materials.env_map_renderer import EnvMapRenderer, render_mirror, view_frame
from reflet.scene.meshes.primitives import sphere_mesh, torus_mesh
from reflet.scene.views.camera import Camera

CAMERA = Camera((1.5, 1.2, 2.6), (0.0, 0.0, 0.0), fov_deg=50, width=96, height=80)
EACH = pytest.mark.parametrize("kind", PARAMETERIZATIONS.values(), ids=str)


@EACH
def test_a_constant_environment_stays_constant(kind: Parameterization) -> None:
    levels = analytic_levels(kind, 32, np.ones_like)
    picture = render_mirror(torus_mesh(), levels, CAMERA, samples=1)
    covered = picture[..., 3] == 1.0
    assert 0.05 < covered.mean() < 0.9
    # Weights that add up to 1 but for rounding. A back that peeps out at the outline is black.
    off = np.abs(picture[..., :3] - 1.0).max(-1) > 1e-5
    assert not off[~covered].any()
    assert off[covered].sum() <= 3


# Linear radiance passes a bilinear filter but for curvature: texels of up to 3° give (0.05)²/8 of slopes up to 0.5, and
# interpolated normals are off by (π/256)²/8. Octahedral maps have kinks, at which a texel's eighth counts; a gazing
# ball's texels are deep near its rim, and around -z (20°) it shows next to nothing.
TOLERANCE = {"octahedral": 4e-3, "equal_area_octahedral": 4e-3, "gazing_ball": 3e-3}


def usable_on_sphere(kind: Parameterization, direction: np.ndarray, cosine: np.ndarray) -> np.ndarray:
    """Pixels of the sphere but for its outline, where a pixel sees too much of the environment."""
    usable = np.isfinite(cosine) & (cosine > 0.4)
    return usable & (direction[..., 2] > -0.9) if kind.is_view_dependent else usable


@EACH
def test_a_sphere_shows_the_environment(kind: Parameterization) -> None:
    finest = analytic_levels(kind, 128)[:1]
    picture = render_mirror(sphere_mesh(around=256), finest, CAMERA, samples=1)
    direction, cosine = sphere_reflections(CAMERA)
    usable = usable_on_sphere(kind, direction, cosine)
    assert usable.mean() > 0.1
    tolerance = TOLERANCE.get(kind.name, 4e-4)
    np.testing.assert_allclose(picture[usable][:, :3], linear(direction[usable]), atol=tolerance)


@EACH
def test_the_lod_is_that_of_the_policy(kind: Parameterization) -> None:
    levels = [
        EnvImage(kind, np.full((*kind.shape(128 >> level), 3), level, np.float32)) for level in range(8)
    ]  # which show their LOD
    picture = render_mirror(sphere_mesh(around=256), levels, CAMERA, samples=1)[..., 0]
    direction, cosine = sphere_reflections(CAMERA)
    usable = usable_on_sphere(kind, direction, cosine)[:-1, :-1]
    neighbours = np.stack([direction[:-1, :-1][usable], direction[:-1, 1:][usable], direction[1:, :-1][usable]])
    error = np.abs(picture[:-1, :-1][usable] - lod_from_neighbours(MipChain(128, kind), neighbours, 0.0))
    assert np.ptp(picture[:-1, :-1][usable]) > 1.0
    # The device's neighbour may be the one to the left or above: the footprint's change over a pixel.
    assert np.median(error) < 0.03
    assert np.quantile(error, 0.95) < 0.3


@EACH
def test_the_backdrop_is_the_environment(kind: Parameterization) -> None:
    away = Camera((0.0, 0.0, 5.0), (0.0, 1.0, 9.0), fov_deg=60, width=64, height=48)  # the sphere is behind
    picture = render_mirror(sphere_mesh(), analytic_levels(kind, 128)[:1], away, samples=4)
    assert (picture[..., 3] == 0.0).all()
    # Curvature as above; and the four samples' mean, half a pixel of 1° apart.
    tolerance = TOLERANCE.get(kind.name, 5e-4)
    np.testing.assert_allclose(picture[..., :3], linear(view_rays(away)), atol=tolerance)


@EACH
def test_a_turned_map_is_turned_back(kind: Parameterization) -> None:
    turn = view_frame(Camera((1.0, 2.0, 0.5), (0.0, 0.0, 0.0)))
    # d in the map's space; turn is map_from_world
    levels = analytic_levels(kind, 128, lambda d: linear(d @ turn))[:1]
    picture = render_mirror(sphere_mesh(around=256), levels, CAMERA, frame=turn, samples=1)
    direction, cosine = sphere_reflections(CAMERA)
    usable = usable_on_sphere(kind, direction @ turn.T, cosine)
    tolerance = TOLERANCE.get(kind.name, 4e-4)
    np.testing.assert_allclose(picture[usable][:, :3], linear(direction[usable]), atol=tolerance)


def test_the_hardware_cube_agrees_with_loads() -> None:
    half = analytic_levels(CUBE, 64, dtype=np.float16)
    by_hardware = render_mirror(sphere_mesh(), half, CAMERA, samples=1)
    by_loads = render_mirror(
        sphere_mesh(), [EnvImage(CUBE, level.texels.astype(np.float32)) for level in half], CAMERA, samples=1
    )
    # Graphics cards round filter weights to 8 bits: half a step of 1/256 of differences between texels of at most 0.1.
    np.testing.assert_allclose(by_hardware, by_loads, atol=5e-4)


def test_reflectance_multiplies_and_alpha_covers() -> None:
    renderer = EnvMapRenderer(sphere_mesh(), reflectance=(0.5, 0.25, 1.0))
    white = upload_env_map(renderer.device, analytic_levels(CUBE, 8, np.ones_like))
    picture = renderer.picture(white, CAMERA, backdrop=False, samples=4)
    # Edges are means of 4 samples, of which each shows the mirror or nothing.
    expected = picture[..., 3:] * np.array([0.5, 0.25, 1.0])
    assert (np.abs(picture[..., :3] - expected).max(-1) > 1e-5).sum() <= 3
    assert set(np.unique(picture[..., 3])) == {0.0, 0.25, 0.5, 0.75, 1.0}


def test_a_gazing_ball_serves_its_own_view_only() -> None:
    own = Camera((0.0, 0.0, 3.5), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), 40, 96, 96)
    aside = Camera(
        (-3.5 * np.sin(np.pi / 3), 0.0, 3.5 * np.cos(np.pi / 3)), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), 40, 96, 96
    )
    turn = view_frame(aside)

    def stripes(d: np.ndarray) -> np.ndarray:  # six around y
        return np.repeat(0.5 + 0.4 * np.sin(6.0 * np.arctan2(d[..., 2], d[..., 0]))[..., None], 3, -1)

    made_for_own = analytic_levels(GazingBall(), 128, stripes)[:1]
    made_for_aside = analytic_levels(GazingBall(), 128, lambda d: stripes(d @ turn))[:1]

    def largest_error(camera: Camera, levels: tuple[EnvImage, ...], frame: np.ndarray | None) -> float:
        picture = render_mirror(sphere_mesh(around=256), levels, camera, frame=frame, samples=1)[..., :3]
        direction, cosine = sphere_reflections(camera)
        # Where the surface faces the viewer within 60°, away from the poles of the stripes.
        usable = (cosine > 0.5) & (np.abs(direction[..., 1]) < 0.5)
        return float(np.abs(picture[usable] - stripes(direction[usable])).max())

    at_own = largest_error(own, made_for_own, None)
    # Curvature of the stripes, (6·0.03)²/8·0.4, where texels are deepest: 120° from +z. Measured 0.005.
    assert at_own < 0.01
    # Made anew for the other view, the map is as good there; without, its singularity is in the picture: 0.12.
    assert largest_error(aside, made_for_aside, turn) < 0.01
    assert largest_error(aside, made_for_own, None) > 10.0 * at_own


def test_levels_of_different_sizes_are_refused() -> None:
    renderer = EnvMapRenderer(sphere_mesh())
    one, _, three = analytic_levels(CUBE, 16)[:3]
    with pytest.raises(RefletError, match="half as large"):
        upload_env_map(renderer.device, [one, three])
    with pytest.raises(RefletError, match="1, 4 or 16"):
        renderer.picture(upload_env_map(renderer.device, [one]), CAMERA, samples=3)
