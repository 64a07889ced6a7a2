"""Mirrors before env maps that have a geometry: against closed forms, and against the NumPy lookup."""

import numpy as np
import pytest
from map_scenes import analytic_levels, linear, view_rays
from reliefs import BALL, NOWHERE, ROOM, plane_relief, relief_of

from reflet.envmap.env_image import EnvImage
from reflet.envmap.env_map import EnvMap, env_map_of
from reflet.envmap.geometry import Box, Ellipsoid, Geometry, Hemisphere, InfiniteSphere, lookup_directions
from reflet.envmap.lod import lod_from_neighbours
from reflet.envmap.mip_chain import MipChain
from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS
from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.parameterizations.parameterization import Parameterization
from reflet.envmap.relief import Relief
from reflet.envmap.texture_filter import sample
from reflet.errors import RefletError
from reflet.reflectance.materials.map_material import MapMaterial
from reflet.reflectance.materials.material import GlossyPhong
from reflet.render.maps.env_map_texture import upload_env_map
from reflet.render.materials.env_map_renderer import EnvMapRenderer, render_mirror
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.meshes.primitives import sphere_mesh
from reflet.scene.views.camera import Camera

RADIUS, CENTRE = 0.4, (0.2, 0.1, 0.1)
CAMERA = Camera((0.9, 0.8, 1.3), CENTRE, fov_deg=50, width=192, height=160)  # within all geometries
OCTAHEDRAL = PARAMETERIZATIONS["octahedral"]
BOTH = pytest.mark.parametrize("kind", [CUBE, OCTAHEDRAL], ids=str)
START = Box((-3.0,) * 3, (4.0,) * 3, (0.0,) * 3)

SHAPES = [
    ROOM,
    BALL,
    Ellipsoid((0.1, 0.2, 0.0), (2.0, 1.8, 3.0), (0.0, 0.1, 0.2)),
    Hemisphere((0.0, -0.5, 0.0), (3.0, 3.0, 3.0), -0.5, (0.0, 0.2, 0.0)),
]


def near_map(geometry: Geometry, kind: Parameterization = CUBE) -> EnvMap:
    """Every level holds `linear` at its texels' centres."""
    return env_map_of(analytic_levels(kind, 64), geometry)


def reflections(camera: Camera = CAMERA) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Where rays meet the sphere, and their mirrored rays: of pixels, and of those right and below, (3, n, 3); and
    which pixels of all these are, away from the sphere's outline."""
    ray, eye = view_rays(camera), np.subtract(camera.position, CENTRE)
    b = ray @ eye
    with np.errstate(invalid="ignore"):
        t = -b - np.sqrt(b * b - eye @ eye + RADIUS**2)
    n = (eye + t[..., None] * ray) / RADIUS
    cosine = -np.einsum("...i,...i->...", ray, n)
    usable = np.isfinite(cosine) & (cosine > 0.4)
    usable[-1], usable[:, -1] = False, False
    return *_with_neighbours(np.asarray(CENTRE) + RADIUS * n, ray + 2.0 * cosine[..., None] * n, usable), usable


def _with_neighbours(p: np.ndarray, r: np.ndarray, at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    right, below = np.roll(at, 1, 1), np.roll(at, 1, 0)
    return np.stack([p[at], p[right], p[below]]), np.stack([r[at], r[right], r[below]])


def looked_up(env_map: EnvMap, d: np.ndarray) -> np.ndarray:
    """By NumPy's LOD and texture filter, in directions of pixels and their neighbours."""
    return sample(env_map.chain, env_map.texels, d[0], lod_from_neighbours(env_map.chain, d, 0.0))


def mirror_picture(env_map: EnvMap, camera: Camera = CAMERA) -> np.ndarray:
    return render_mirror(sphere(), env_map, camera, samples=1)[..., :3]


def sphere() -> Mesh:
    return sphere_mesh(RADIUS, CENTRE, around=256)


# The device's neighbours may be those to the left or above. That moves the LOD by the footprint's change over a pixel,
# mostly less than a tenth of a level, of levels that differ by their curvature, (0.1)²/8 of slopes up to 0.5.
USUAL, MOST = 2e-4, 2e-3  # of 19 pixels in 20, and of all
# A relief's half floats turn lookups by up to 0.02°; at the edges between walls it is as blunt as its texels, 0.7°, are
# wide, and there the distance is right within a few of its hundredths.
USUAL_OF_RELIEF, MOST_OF_RELIEF = 2e-4, 4e-3


def assert_close(picture: np.ndarray, expected: np.ndarray, relief: bool = False) -> None:
    error = np.abs(picture - expected).max(-1)
    assert np.percentile(error, 95) < USUAL + relief * USUAL_OF_RELIEF
    assert error.max() < MOST + relief * MOST_OF_RELIEF


@BOTH
@pytest.mark.parametrize("geometry", [*SHAPES, relief_of(ROOM, start=START)], ids=lambda g: g.kind)
def test_a_mirror_shows_what_numpy_looks_up(geometry: Geometry, kind: Parameterization) -> None:
    p, r, usable = reflections()
    env_map = near_map(geometry, kind)
    expected = looked_up(env_map, lookup_directions(geometry, p, r))
    assert np.abs(expected - looked_up(env_map, r)).mean() > 0.02  # parallax shows
    assert_close(mirror_picture(env_map)[usable], expected)


@BOTH
@pytest.mark.parametrize("shape", [ROOM, BALL], ids=lambda g: g.kind)
def test_a_relief_of_a_shape_shows_what_the_shape_shows(shape, kind: Parameterization) -> None:  # type: ignore[no-untyped-def]
    p, r, usable = reflections()
    env_map = near_map(relief_of(shape, start=START), kind)
    hit = shape.lookup_direction(p, r) * np.asarray(getattr(shape, "radii", 1.0))
    assert_close(mirror_picture(env_map)[usable], looked_up(env_map, hit), relief=True)


@BOTH
def test_a_relief_of_a_floor_under_a_sky(kind: Parameterization) -> None:
    p, r, usable = reflections()
    env_map = near_map(plane_relief(0.5, start=Box((-3.0,) * 3, (3.0,) * 3, (0.0,) * 3)), kind)
    picture = mirror_picture(env_map)[usable]
    floor = p + r * ((-0.5 - p[..., 1]) / r[..., 1])[..., None]
    for directions, there in ((floor, r[0, :, 1] < -0.1), (r, r[0, :, 1] > 0.3)):  # the filter mixes what is between
        assert there.sum() > 1000
        assert_close(picture[there], looked_up(env_map, directions[:, there]), relief=True)


def test_a_plane_mirror_in_a_room_shows_its_mirror_image() -> None:
    """A mirror at y = 0 shows what an eye as far below it would see."""
    corner = np.array([[-0.5, 0, -0.5], [-0.5, 0, 0.5], [0.5, 0, 0.5], [0.5, 0, -0.5]], np.float32)
    up = np.tile(np.array([0, 1, 0], np.float32), (4, 1))
    mirror = Mesh(corner, up, np.array([[0, 1, 2], [0, 2, 3]], np.uint32))
    camera = Camera((0.2, 0.8, 0.9), (0.0, 0.0, 0.0), fov_deg=40, width=96, height=96)
    ray, eye = view_rays(camera), np.array(camera.position)
    p = eye - ray * (eye[1] / ray[..., 1])[..., None]
    inside = (np.abs(p[..., [0, 2]]) < 0.48).all(-1) & (ray[..., 1] < 0.0)
    inside[-1], inside[:, -1] = False, False
    p, r = _with_neighbours(np.broadcast_to(eye * (1, -1, 1), ray.shape), ray * (1, -1, 1), inside)
    for geometry in (ROOM, relief_of(ROOM, start=ROOM)):
        env_map = near_map(geometry)
        picture = render_mirror(mirror, env_map, camera, samples=1)
        assert (picture[inside][:, 3] == 1.0).all()
        expected = looked_up(env_map, ROOM.lookup_direction(p, r))
        assert_close(picture[inside][:, :3], expected, relief=geometry is not ROOM)


@BOTH
def test_the_backdrop_is_the_room_around_the_eye(kind: Parameterization) -> None:
    away = Camera((0.9, 0.8, 1.3), (2.0, 1.0, 3.0), fov_deg=70, width=64, height=48)
    ray = view_rays(away)
    inner = np.zeros(ray.shape[:2], bool)
    inner[:-1, :-1] = True
    p, r = _with_neighbours(np.broadcast_to(away.position, ray.shape), ray, inner)
    for geometry in (ROOM, relief_of(ROOM, start=ROOM)):
        env_map = near_map(geometry, kind)
        expected = looked_up(env_map, ROOM.lookup_direction(p, r))
        assert np.abs(expected - looked_up(env_map, r)).mean() > 0.02
        assert_close(mirror_picture(env_map, away)[inner], expected, relief=geometry is not ROOM)


@BOTH
def test_a_relief_of_zeros_is_the_sphere_at_infinity(kind: Parameterization) -> None:
    nowhere = Relief(np.zeros((6, 8, 8), np.float16), *NOWHERE, (0.1, 0.2, -0.3))
    boxed = Relief(np.zeros((6, 8, 8), np.float16), (-1.0,) * 3, (1.0,) * 3, (0.1, 0.2, -0.3))
    plain = render_mirror(sphere(), analytic_levels(kind, 64), CAMERA, samples=1)[..., :3]
    for geometry in (InfiniteSphere(), nowhere, boxed):
        picture = mirror_picture(near_map(geometry, kind))
        # The same numbers but for the LOD, whose neighbours are sums of the same terms in another order.
        np.testing.assert_allclose(picture, plain, atol=1e-5)


@BOTH
@pytest.mark.parametrize("geometry", [ROOM, relief_of(ROOM, start=ROOM)], ids=lambda g: g.kind)
def test_the_lod_is_that_of_the_policy(geometry: Geometry, kind: Parameterization) -> None:
    """Against NumPy's lookups of the pixels to the right and below; of reliefs with the pixel's own distance."""
    levels = [EnvImage(kind, np.full((*kind.shape(128 >> k), 3), k, np.float32)) for k in range(8)]
    p, r, usable = reflections()
    expected = lod_from_neighbours(MipChain(128, kind), lookup_directions(geometry, p, r), 0.0)
    error = np.abs(mirror_picture(env_map_of(levels, geometry))[usable][:, 0] - expected)
    assert np.ptp(expected) > 1.0
    # The device's neighbour may be the one to the left or above: the footprint's change over a pixel. A box's walls
    # change the footprint at once.
    assert np.median(error) < 0.03
    assert np.quantile(error, 0.9) < 0.3


def test_a_turned_map_keeps_its_room() -> None:
    """The geometry is the world's, the turn the map's."""
    turn = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
    turned = env_map_of(analytic_levels(CUBE, 64, lambda d: linear(d @ turn)), ROOM)
    picture = render_mirror(sphere(), turned, CAMERA, frame=turn, samples=1)[..., :3]
    # A quarter turn of a cube leads texels to texels.
    np.testing.assert_allclose(picture, mirror_picture(near_map(ROOM)), atol=1e-5)


def test_half_floats_are_filtered_by_the_hardware_likewise() -> None:
    relief = relief_of(ROOM, start=ROOM)
    half = env_map_of(analytic_levels(CUBE, 64, dtype=np.float16), relief)
    by_loads = EnvMap(half.chain, half.texels.astype(np.float32), relief)
    assert upload_env_map(EnvMapRenderer(sphere()).device, half).by_hardware
    # Graphics cards round filter weights to 8 bits: half a step of 1/256 of differences between texels of at most 0.1.
    pictures = [render_mirror(sphere(), each, CAMERA, samples=1) for each in (half, by_loads)]
    np.testing.assert_allclose(*pictures, atol=5e-4)


def test_glossy_materials_follow_and_shown_maps_are_refused() -> None:
    renderer = EnvMapRenderer(sphere())
    room = upload_env_map(renderer.device, near_map(ROOM))
    glossy = renderer.programs.material(GlossyPhong(20.0, (0.5, 0.25, 1.0), (0.0, 0.0, 0.0)))
    picture = renderer.picture(room, CAMERA, samples=1, material=glossy)[..., :3]
    mirror = renderer.picture(room, CAMERA, samples=1)[..., :3]
    usable = reflections()[2]
    np.testing.assert_allclose(picture[usable], mirror[usable] * (0.5, 0.25, 1.0), rtol=1e-5)  # one product in float32
    with pytest.raises(RefletError, match="box serves mirrors"):
        renderer.picture(room, CAMERA, material=renderer.programs.material(MapMaterial()))


def test_an_env_map_is_all_its_levels() -> None:
    levels = analytic_levels(OCTAHEDRAL, 16)
    whole = env_map_of(levels, ROOM)
    assert whole.chain == MipChain(16, OCTAHEDRAL)
    for came, went in zip(whole.images, levels, strict=True):
        assert came.parameterization == OCTAHEDRAL
        np.testing.assert_array_equal(came.texels, went.texels)
    with pytest.raises(RefletError, match="all mip levels of 16 rows down to 1; levels of 16, 8 rows came"):
        env_map_of(levels[:2], ROOM)
