"""The viewpoints of the joint set: where they stand and how many there are."""

import numpy as np
import pytest

from reflet.pipelines.baking.joint_set import joint_points
from reflet.scene.views.parameter_space import Axis, Orbit, ParameterSpace

ORBIT = Orbit((0.0, 0.1, 0.0), 60.0, 22.0, 2.0)


def space(*azimuths: float, elevations: tuple[float, ...] = (), orbit: Orbit = ORBIT) -> ParameterSpace:
    axes = (Axis("azimuth_deg", azimuths), *([Axis("elevation_deg", elevations)] if elevations else []))
    return ParameterSpace(axes, orbit)


def rings(points: list[dict[str, float]]) -> dict[float, list[float]]:
    """Azimuths of each elevation."""
    found: dict[float, list[float]] = {}
    for point in points:
        found.setdefault(round(point["elevation_deg"], 9), []).append(point["azimuth_deg"])
    return found


def points_around(space: ParameterSpace, spacing: float | None = None) -> list[dict[str, float]]:
    """All but the last, which are the samples' own."""
    points = joint_points(space, spacing)
    samples = [{**space.middle_point(), **sample} for sample in space.points()]
    own = 0
    while points[len(points) - own - 1] in samples:
        own += 1
    return points[: len(points) - own]


def rings_around(space: ParameterSpace, spacing: float | None = None) -> dict[float, list[float]]:
    """The same by elevation."""
    return rings(points_around(space, spacing))


def gaps(azimuths: list[float]) -> np.ndarray:
    """Degrees from each azimuth to the next, all the way round."""
    return np.diff(np.sort(np.mod(azimuths, 360.0)), append=360.0 + min(np.mod(azimuths, 360.0)))


def test_beside_the_samples_they_are_dense_and_elsewhere_sparse() -> None:
    found = rings_around(space(60.0, 62.0, 64.0))
    assert sorted(found) == [12.0, 32.0, 52.0]
    assert found[32.0] == [40.0, 62.0, 84.0]  # two steps of about 20 over 44 degrees
    for elevation in (12.0, 52.0):
        assert found[elevation][:3] == [40.0, 62.0, 84.0]
        others = found[elevation][3:]
        np.testing.assert_allclose(others, 84.0 + np.arange(1, 8) * 39.5)  # eight steps of about 40 over 316 degrees
        assert gaps(found[elevation]).max() == pytest.approx(39.5)


def test_without_samples_they_are_sparse_all_around_the_orbits_own_place() -> None:
    found = rings(joint_points(space()))
    assert sorted(found) == [12.0, 52.0]
    for azimuths in found.values():
        np.testing.assert_allclose(gaps(azimuths), 40.0)
        assert 60.0 in azimuths
    one = rings_around(space(60.0))
    assert one[32.0] == [40.0, 60.0, 80.0]


def test_samples_all_around_need_none_of_their_own_side() -> None:
    points = joint_points(space(*np.arange(0.0, 360.0, 20.0).tolist()))
    for azimuths in rings(points).values():
        np.testing.assert_allclose(gaps(azimuths), 40.0)
    assert len(points) == 18


def test_none_stands_twice_and_all_sides_are_seen() -> None:
    """However far the samples go round."""
    for count in range(1, 36):
        azimuths = rings_around(space(*(10.0 * np.arange(count)).tolist()))
        around = [gaps(azimuths[elevation]) for elevation in (12.0, 52.0)]  # the ring between is on the samples' side
        assert all(each.min() > 13.0 and each.max() < 60.0 for each in around), (count, around)


def test_one_spacing_replaces_both() -> None:
    found = rings_around(space(60.0, 62.0, 64.0), 10.0)
    np.testing.assert_allclose(sorted(found), [12.0, 22.0, 32.0, 42.0, 52.0])
    for azimuths in found.values():
        assert len(azimuths) == 36 and gaps(azimuths).max() < 11.1
    coarsest = points_around(space(60.0), 180.0)
    assert len({point["azimuth_deg"] for point in coarsest}) == 3  # beside it, and one on the other side


def test_elevations_of_the_samples_are_all_covered() -> None:
    found = rings(joint_points(space(60.0, elevations=(0.0, 20.0, 40.0))))
    assert min(found) == -10.0 and max(found) == 70.0
    assert np.diff(sorted(each for each in found if 60.0 in found[each])).max() == 20.0


@pytest.mark.parametrize(("elevation", "expected"), [(75.0, (65.0, 80.0)), (90.0, (80.0,)), (-85.0, (-80.0, -55.0))])
def test_steep_ones_are_left_out_and_none_is_doubled(elevation: float, expected: tuple[float, ...]) -> None:
    points = points_around(space(60.0, orbit=Orbit((0.0, 0.0, 0.0), 60.0, elevation, 2.0)))
    found = rings(points)
    assert tuple(sorted(found))[:: max(len(found) - 1, 1)] == expected
    assert len({tuple(point.values()) for point in points}) == len(points)


def test_they_keep_the_distance_of_the_middle_sample() -> None:
    axes = (Axis("azimuth_deg", (0.0,)), Axis("distance", (1.5, 2.5, 3.0)))
    points = points_around(ParameterSpace(axes, ORBIT))
    assert {point["distance"] for point in points} == {2.5}
    only = joint_points(ParameterSpace((Axis("elevation_deg", (10.0, 30.0)),), ORBIT))
    assert {40.0, 60.0, 80.0} <= {point["azimuth_deg"] for point in only}


def test_the_samples_are_among_them_three_at_most() -> None:
    """What is looked at most is not left to viewpoints beside it."""
    assert [point["azimuth_deg"] for point in joint_points(space(60.0, 62.0, 64.0))[-3:]] == [60.0, 62.0, 64.0]
    many = joint_points(space(*np.arange(40.0, 81.0, 5.0).tolist()))
    assert [point["azimuth_deg"] for point in many if point["elevation_deg"] == 22.0] == [40.0, 60.0, 80.0]
    assert not [point for point in joint_points(space()) if point["elevation_deg"] == 22.0]
