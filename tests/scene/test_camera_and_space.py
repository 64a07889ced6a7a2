"""Cameras, the parameter space and the sample pattern."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from reflet.errors import RefletError
from reflet.scene.views.camera import Camera
from reflet.scene.views.parameter_space import Axis, Orbit, ParameterSpace, orbit_space
from reflet.scene.views.sample_pattern import PATTERN, Adaptive, sample_positions

BENCH = Orbit((0.01, 0.15, 0.0), azimuth_deg=60.0, elevation_deg=22.0, distance=1.25)
ORBIT = ParameterSpace((Axis("azimuth_deg", (60.0, 62.0, 64.0)),), BENCH)
GRID = ParameterSpace((Axis("elevation_deg", (10.0, 20.0)), Axis("azimuth_deg", (0.0, 5.0, 10.0))), BENCH)


def test_the_orbits_camera_is_the_benchmarks() -> None:
    # the position written, to six digits, in the Mitsuba file of the same scene
    np.testing.assert_allclose(ORBIT.camera(0).position, (0.589490, 0.618258, -1.003706), atol=1e-6)


def test_rays_and_projection_agree() -> None:
    camera = Camera((1.0, 2.0, 3.0), (0.2, 0.1, -0.4), fov_deg=40.0, width=640, height=480)
    corner, dx, dy = camera.ray_basis()
    clip_from_world = camera.clip_from_world(0.1, 100.0)
    for x, y in ((0, 0), (640, 0), (0, 480), (320, 240), (17.25, 400.5)):
        clip = clip_from_world @ np.append(np.array(camera.position) + 7.0 * (corner + x * dx + y * dy), 1.0)
        ndc = clip[:3] / clip[3]
        # float64 throughout
        np.testing.assert_allclose([(ndc[0] + 1) * 320, (1 - ndc[1]) * 240], [x, y], atol=1e-9)
        assert 0 < ndc[2] < 1
    assert np.dot(corner + 320 * dx + 240 * dy, camera.frame()[2]) == pytest.approx(1.0)


def test_depth_runs_from_near_to_far() -> None:
    camera = Camera((0, 0, 5), (0, 0, 0))
    for z, depth in ((-0.1, 0.0), (-100.0, 1.0)):
        clip = camera.clip_from_world(0.1, 100.0) @ [0, 0, 5 + z, 1]
        assert clip[2] / clip[3] == pytest.approx(depth, abs=1e-12)


@pytest.mark.parametrize(
    "bad", [{"position": (0, 1, 0)}, {"fov_deg": 180.0}, {"width": 0}, {"position": (float("nan"), 0, 0)}]
)
def test_impossible_cameras_are_refused(bad: dict) -> None:
    with pytest.raises(RefletError):
        Camera(**{"position": (0.0, 0.0, 5.0), "target": (0.0, 0.0, 0.0), **bad})


@given(st.floats(-179, 179), st.floats(-80, 80), st.floats(0.1, 50))
def test_point_of_inverts_the_orbit(azimuth: float, elevation: float, distance: float) -> None:
    point = {"azimuth_deg": azimuth, "elevation_deg": elevation, "distance": distance}
    back = BENCH.point_of(BENCH.camera(point))
    for name, value in point.items():
        assert back[name] == pytest.approx(value, abs=1e-6)


def test_weights_are_one_at_a_sample_and_even_halfway() -> None:
    assert ORBIT.blend_weights({"azimuth_deg": 62.0}) == {1: 1.0}
    assert ORBIT.blend_weights({"azimuth_deg": 63.0}) == {1: 0.5, 2: 0.5}
    assert ORBIT.blend_weights({"azimuth_deg": 63.0 - 360.0}) == {1: 0.5, 2: 0.5}
    assert ORBIT.blend_weights({"azimuth_deg": 20.0}) == {0: 1.0}
    assert ORBIT.blend_weights({"azimuth_deg": 100.0}) == {2: 1.0}


def test_a_full_turn_is_closed() -> None:
    """The last sample is the first one's neighbour: no border anywhere, and no jump."""
    turn = orbit_space(replace(BENCH, azimuth_deg=60.0), 36, 10.0)
    assert turn.axes[0].period == 360.0 and orbit_space(BENCH, 35, 10.0).axes[0].period is None
    assert orbit_space(BENCH, 7, 55.0).axes[0].period == 360.0  # the last gap is narrower, 30°
    for azimuth in (55.0, 415.0, -305.0):
        assert turn.blend_weights({"azimuth_deg": azimuth}) == {35: 0.5, 0: 0.5}
    assert turn.blend_weights({"azimuth_deg": 60.0 + 720.0}) == {0: 1.0}
    for azimuth in np.linspace(-400, 400, 97):
        assert turn.displacement_deg({"azimuth_deg": float(azimuth)}) == pytest.approx(0.0, abs=1e-9)
    before, after = (turn.blend_weights({"azimuth_deg": 60.0 + x}) for x in (-1e-3, 1e-3))
    assert all(abs(before.get(i, 0.0) - after.get(i, 0.0)) < 1e-3 for i in {*before, *after})


@pytest.mark.parametrize(("values", "period"), [((0.0, 180.0, 360.0), 360.0), ((0.0,), 360.0), ((0.0, 1.0), -1.0)])
def test_closed_axes_say_no_coordinate_twice(values: tuple[float, ...], period: float) -> None:
    with pytest.raises(RefletError, match="two coordinates or more within less than that"):
        Axis("azimuth_deg", values, period)


@given(st.floats(-40, 60), st.floats(-400, 400))
def test_weights_interpolate_in_two_dimensions(elevation: float, azimuth: float) -> None:
    weights = GRID.blend_weights({"elevation_deg": elevation, "azimuth_deg": azimuth})
    assert sum(weights.values()) == pytest.approx(1.0) and 1 <= len(weights) <= 4 and min(weights.values()) > 0
    points = GRID.points()
    mean = sum(w * points[i]["elevation_deg"] for i, w in weights.items())
    assert mean == pytest.approx(np.clip(elevation, 10, 20))


def test_samples_are_numbered_in_c_order() -> None:
    assert GRID.shape == (2, 3) and GRID.sample_count == 6
    assert GRID.points()[4] == {"elevation_deg": 20.0, "azimuth_deg": 5.0}
    assert GRID.camera(4) == BENCH.camera({"elevation_deg": 20.0, "azimuth_deg": 5.0})


FIRST_16 = [(12, 4), (28, 12), (4, 20), (20, 28), (1, 3), (3, 9), (7, 31), (15, 15)] + [
    (11, 23),
    (13, 29),
    (23, 7),
    (21, 13),
    (19, 19),
    (27, 1),
    (25, 17),
    (29, 27),
]  # maps that are on disks were inferred with these


def test_the_pattern_starts_with_webgpus_four_and_the_sixteen_that_maps_were_inferred_with() -> None:
    np.testing.assert_array_equal(sample_positions(4) * 8, [[3, 1], [7, 3], [1, 5], [5, 7]])
    np.testing.assert_array_equal(sample_positions(1), [[0.5, 0.5]])
    np.testing.assert_array_equal(sample_positions(16) * 32, FIRST_16)
    with pytest.raises(RefletError, match="1, 4, 16, 64 or 256, not 3"):
        sample_positions(3)


@pytest.mark.parametrize(("count", "closest"), [(16, 5.6 / 32), (64, 12.7 / 128)])
def test_the_pattern_is_stratified(count: int, closest: float) -> None:
    pattern, cells = sample_positions(count), int(count**0.5)
    assert len({(int(x * cells), int(y * cells)) for x, y in pattern}) == count
    for axis in (0, 1):
        assert len(set(np.floor(pattern[:, axis] * max(count, 32)))) == count  # no two in a column or row
        assert pattern[:, axis].mean() == pytest.approx(0.5, abs=1 / 128)  # centred: at most 1/128 pixel off
    apart = np.abs(pattern[:, None] - pattern[None])
    apart = np.linalg.norm(np.minimum(apart, 1 - apart), axis=-1)[~np.eye(count, dtype=bool)]
    assert apart.min() > closest


def test_each_sixteen_of_the_pattern_are_stratified() -> None:
    """So a picture on its way to 64 samples is even at 32 and 48."""
    for sixteen in PATTERN.reshape(4, 16, 2):
        assert len({(int(x * 4), int(y * 4)) for x, y in sixteen}) == 16


def test_more_samples_are_worth_it_at_edges() -> None:
    """The root mean square error of the share of a pixel beside a line, for lines that cross it anywhere."""
    rng = np.random.default_rng(1)
    angle, apart = rng.uniform(0.0, 2.0 * np.pi, 4000), rng.uniform(-0.7, 0.7, 4000)
    normal = np.stack([np.cos(angle), np.sin(angle)])

    def share(positions: np.ndarray) -> np.ndarray:
        return ((positions - 0.5) @ normal < apart).mean(0)

    fine = (np.stack(np.meshgrid(*[np.arange(128)] * 2), -1).reshape(-1, 2) + 0.5) / 128
    errors = [np.sqrt(np.mean((share(sample_positions(count)) - share(fine)) ** 2)) for count in (4, 16, 64, 256)]
    # four times as many random ones would halve it
    assert errors[1] < errors[0] / 2 and errors[2] < errors[1] / 2 and errors[3] < errors[2] / 2


@pytest.mark.parametrize(("first", "most"), [(1, 4), (16, 16), (64, 16), (4, 15), (64, 1024)])
def test_adaptive_counts_are_those_of_the_pattern(first: int, most: int) -> None:
    with pytest.raises(RefletError, match=f"not from {first} to {most}"):
        Adaptive(first, most)


def test_displacement_from_the_sampled_range() -> None:
    """The chord from the closest camera of the range over its distance from the target, as an angle."""
    orbit = Orbit((0.3, 0.1, -0.2), 60.0, 20.0, 1.25)
    ring = ParameterSpace((Axis("azimuth_deg", (50.0, 60.0, 70.0)),), orbit)
    ten = np.degrees(2.0 * np.sin(np.radians(5.0)))  # the chord of 10°
    for point, expected in (
        ({"azimuth_deg": 60.0}, 0.0),
        ({"azimuth_deg": 57.3}, 0.0),  # between samples
        ({"azimuth_deg": -300.0}, 0.0),  # once around
        ({"azimuth_deg": 55.0, "elevation_deg": 30.0}, ten),
        ({"azimuth_deg": 55.0, "elevation_deg": 10.0}, ten),
        ({"azimuth_deg": 80.0}, ten * np.cos(np.radians(20.0))),  # circles of latitude are smaller
        ({"azimuth_deg": 60.0, "distance": 2.5}, np.degrees(1.0)),
        ({"azimuth_deg": 60.0, "distance": 1.0}, np.degrees(0.2)),
    ):
        assert ring.displacement_deg(point) == pytest.approx(expected, abs=1e-9)
    dome = ParameterSpace((*ring.axes, Axis("elevation_deg", (0.0, 40.0)), Axis("distance", (1.0, 2.0))), orbit)
    inside = {"azimuth_deg": 66.0, "elevation_deg": 31.0, "distance": 1.7}
    for changed, expected in (
        ({}, 0.0),
        ({"elevation_deg": 50.0}, ten),
        ({"distance": 4.0}, np.degrees(1.0)),
        ({"distance": 0.5}, np.degrees(0.5)),
    ):
        assert dome.displacement_deg({**inside, **changed}) == pytest.approx(expected, abs=1e-9)
