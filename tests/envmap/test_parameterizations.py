"""All parameterizations, by one suite: round trips, orientation, sampling rate, solid angles, compiled twins.

Seams are in `test_seams`.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from samples_of_maps import EACH, ROUND, away_from_folds, directions, jacobian, places, unit

from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS, parameterization
from reflet.envmap.parameterizations.compiled_parameterization import direction_at, point_of, rate_at
from reflet.envmap.parameterizations.parameterization import Parameterization
from reflet.errors import RefletError

# Where the labelled directions lie: face, u, v. Half the root of 1/2 is the sphere map's place of 45° and 135°.
H = np.sqrt(0.125)
LABELS: dict[str, dict[tuple[int, int, int], tuple[int, float, float]]] = {
    "cube": {
        (1, 0, 0): (0, 0.5, 0.5), (-1, 0, 0): (1, 0.5, 0.5), (0, 1, 0): (2, 0.5, 0.5),
        (0, -1, 0): (3, 0.5, 0.5), (0, 0, 1): (4, 0.5, 0.5), (0, 0, -1): (5, 0.5, 0.5),
        # beside the centres, towards +y, and towards +z on the top and bottom: WebGPU's orientation
        (2, 1, 0): (0, 0.5, 0.25), (-2, 1, 0): (1, 0.5, 0.25), (0, 2, 1): (2, 0.5, 0.75),
        (0, -2, 1): (3, 0.5, 0.25), (0, 1, 2): (4, 0.5, 0.25), (0, 1, -2): (5, 0.5, 0.25),
    },
    "latlong": {
        (1, 0, 0): (0, 0.5, 0.5), (0, 0, 1): (0, 0.75, 0.5), (0, 0, -1): (0, 0.25, 0.5), (-1, 0, 0): (0, 1.0, 0.5),
        (0, 1, 0): (0, 0.5, 0.0), (0, -1, 0): (0, 0.5, 1.0), (1, 1, 0): (0, 0.5, 0.25), (1, -1, 0): (0, 0.5, 0.75),
    },
    "dual_paraboloid": {
        (0, 0, 1): (0, 0.5, 0.5), (0, 0, -1): (1, 0.5, 0.5), (1, 0, 0): (0, 1.0, 0.5), (-1, 0, 0): (0, 0.0, 0.5),
        (0, 1, 0): (0, 0.5, 0.0), (0, -1, 0): (0, 0.5, 1.0),
        (3, 0, 4): (0, 2 / 3, 0.5), (0, 3, 4): (0, 0.5, 1 / 3),
        (3, 0, -4): (1, 2 / 3, 0.5), (0, 3, -4): (1, 0.5, 1 / 3),
    },
    "gazing_ball": {
        (0, 0, 1): (0, 0.5, 0.5), (1, 0, 0): (0, 0.5 + H, 0.5), (-1, 0, 0): (0, 0.5 - H, 0.5),
        (0, 1, 0): (0, 0.5, 0.5 - H), (0, -1, 0): (0, 0.5, 0.5 + H), (0, 0, -1): (0, 1.0, 0.5),
    },
    "angular": {
        (0, 0, -1): (0, 0.5, 0.5), (1, 0, 0): (0, 0.75, 0.5), (-1, 0, 0): (0, 0.25, 0.5),
        (0, 1, 0): (0, 0.5, 0.25), (0, -1, 0): (0, 0.5, 0.75), (0, 0, 1): (0, 1.0, 0.5), (1, 0, 1): (0, 0.875, 0.5),
    },
    "octahedral": {
        (0, 1, 0): (0, 0.5, 0.5), (1, 0, 0): (0, 1.0, 0.5), (-1, 0, 0): (0, 0.0, 0.5), (0, 0, 1): (0, 0.5, 1.0),
        (0, 0, -1): (0, 0.5, 0.0), (0, -1, 0): (0, 1.0, 1.0),
        (1, -2, 1): (0, 0.875, 0.875), (-1, -2, 1): (0, 0.125, 0.875),
    },
    "equal_area_octahedral": {
        (0, 1, 0): (0, 0.5, 0.5), (1, 0, 0): (0, 1.0, 0.5), (-1, 0, 0): (0, 0.0, 0.5), (0, 0, 1): (0, 0.5, 1.0),
        (0, 0, -1): (0, 0.5, 0.0), (0, -1, 0): (0, 1.0, 1.0), (-1, 0, 1): (0, 0.25, 0.75),
    },
}  # fmt: skip

# The sign of det(∂d/∂u, ∂d/∂v, d) on each face: 1 seen from inside, -1 from outside.
HANDEDNESS = {
    "cube": [-1] * 6,
    "latlong": [1],
    "dual_paraboloid": [-1, 1],
    "gazing_ball": [-1],
    "angular": [1],
    "octahedral": [-1],
    "equal_area_octahedral": [-1],
}


# --- round trips


component = st.one_of(
    st.floats(-1.0, 1.0, allow_subnormal=False),
    st.sampled_from([0.0, 1.0, -1.0, 1e-3, -1e-3, 1e-8, -1e-8, 1e-15, 1 - 1e-9, -1 + 1e-9]),
)
share = st.one_of(st.floats(1e-9, 1.0), st.sampled_from([1e-9, 0.5, 0.5 + 1e-9, 0.5 - 1e-9, 1.0 - 1e-9, 1.0]))


@EACH
@settings(max_examples=25)
@given(d=arrays(np.float64, (50, 3), elements=component))
def test_a_direction_leads_to_its_place_and_back(p: Parameterization, d: np.ndarray) -> None:
    d = d[np.abs(d).max(1) > 1e-3]
    face, uv = p.uv_from_direction(d)
    assert ((face >= 0) & (face < p.face_count)).all() and ((uv >= -1e-15) & (uv <= 1 + 1e-15)).all()
    back, _ = p.direction_from_uv(face, uv)
    error = np.abs(back - unit(d)).max(1)
    # Some rounding of numbers near 1. On the sphere map's rim an arc sine ends: uv good to 1e-16 gives
    # an angle good to the root of that.
    tolerance = np.where(unit(d)[:, 2] < -0.99, 1e-7, 1e-13) if p.name == "gazing_ball" else 1e-14
    assert (error <= tolerance).all()


@EACH
@settings(max_examples=25)
@given(uv=arrays(np.float64, (50, 2), elements=share), which=arrays(np.float64, 50, elements=st.floats(0.0, 0.999)))
def test_a_place_leads_to_its_direction_and_back(p: Parameterization, uv: np.ndarray, which: np.ndarray) -> None:
    if (
        p.name in ROUND
    ):  # from the whole square into the disc, close to the rim but not on it, where all may be one point
        place = 2.0 * uv - 1.0
        uv = 0.5 + 0.5 * place * np.minimum(1.0, (1.0 - 1e-6) / np.maximum(np.hypot(*place.T), 1e-9))[:, None]
    face = (which * p.face_count).astype(int)
    direction, valid = p.direction_from_uv(face, uv)
    assert valid.all()
    np.testing.assert_allclose(np.linalg.norm(direction, axis=1), 1.0, atol=1e-14)
    face_back, uv_back = p.uv_from_direction(direction)
    np.testing.assert_allclose(p.direction_from_uv(face_back, uv_back)[0], direction, atol=1e-9)
    within = np.minimum(uv, 1.0 - uv).min(1) > 1e-12  # on a seam, the place's other name is as good
    np.testing.assert_array_equal(face_back[within], face[within])
    # A direction's rounding of 1e-16 is as much of uv times the map's stretch there: 1e6 at most, see above.
    np.testing.assert_allclose(uv_back[within], uv[within], atol=1e-9)


@EACH
def test_scale_does_not_matter(p: Parameterization) -> None:
    d = directions(500)
    face, uv = p.uv_from_direction(d)
    for scale in (1e-6, 4096.0):
        scaled_face, scaled_uv = p.uv_from_direction(scale * d)
        near = p.direction_from_uv(scaled_face, scaled_uv)[0] - p.direction_from_uv(face, uv)[0]
        # Ties may fall otherwise, and lead to the same direction. On the sphere map's rim: the root of rounding.
        assert np.abs(near).max() < (1e-7 if p.name == "gazing_ball" else 1e-14)


@pytest.mark.parametrize("name", ROUND)
def test_outside_the_disc_the_map_goes_on(name: str) -> None:
    """The paraboloid's inverse point on the other face; the others' point at 2 - r on the other side."""
    p = PARAMETERIZATIONS[name]
    rng = np.random.default_rng(2)
    place = rng.uniform(-1.0, 1.0, (2000, 2))
    radius = np.linalg.norm(place, axis=1, keepdims=True)
    place, radius = place[radius[:, 0] > 1.0], radius[radius[:, 0] > 1.0]
    face = rng.integers(0, p.face_count, len(place))
    outside, valid = p.direction_from_uv(face, 0.5 + 0.5 * place)
    assert not valid.any()
    there = place / radius**2 if name == "dual_paraboloid" else place * (1.0 - 2.0 / radius)
    inside, valid = p.direction_from_uv(1 - face if p.face_count == 2 else face, 0.5 + 0.5 * there)
    assert valid.all()
    np.testing.assert_allclose(outside, inside, atol=1e-14)


# --- orientation


@EACH
def test_labelled_directions_lie_where_the_classes_say(p: Parameterization) -> None:
    for direction, (face, u, v) in LABELS[p.name].items():
        found_face, found_uv = p.uv_from_direction(np.array([direction], float))
        assert found_face[0] == face, direction
        np.testing.assert_allclose(found_uv[0], [u, v], atol=1e-15, err_msg=str(direction))


@EACH
def test_no_face_is_mirrored(p: Parameterization) -> None:
    face, uv = places(p, 3000)
    signs = np.sign(np.linalg.det(np.stack(jacobian(p, face, uv), 1)))
    for each in range(p.face_count):
        assert set(signs[face == each]) == {HANDEDNESS[p.name][each]}


def test_names_and_numbers_are_unique_and_found() -> None:
    assert sorted(p.kind for p in PARAMETERIZATIONS.values()) == list(range(7))
    for name, p in PARAMETERIZATIONS.items():
        assert parameterization(name) is p and repr(p) == name
        assert p == type(p)() and hash(p) == hash(type(p)())
    with pytest.raises(RefletError, match=r"cube.*sphere_map"):
        parameterization("sphere_map")


# --- sampling rate and solid angles


@EACH
def test_sampling_rate_is_texels_a_steradian(p: Parameterization) -> None:
    face, uv = places(p, 3000)
    smooth = away_from_folds(p, uv)
    along_u, along_v, d = (each[smooth] for each in jacobian(p, face, uv))
    steradians = np.linalg.norm(np.cross(along_u, along_v), axis=-1) / p.aspect
    np.testing.assert_allclose(p.sampling_rate(d) * steradians, 1.0, rtol=1e-6)  # differences err by 1e-10/|∂d|


@EACH
def test_axis_rates_are_singular_values(p: Parameterization) -> None:
    face, uv = places(p, 3000)
    smooth = away_from_folds(p, uv)
    along_u, along_v, d = (each[smooth] for each in jacobian(p, face, uv))
    radians_a_texel = np.linalg.svd(np.stack([along_u / p.aspect, along_v], -1), compute_uv=False)
    least, most = p.axis_rates(d)
    # Differences err by 1e-10/|∂d|; at 1e-3 from the sphere map's rim, where d bends as its root, by 1e-6.
    np.testing.assert_allclose(least, 1.0 / radians_a_texel[:, 0], rtol=2e-6)
    np.testing.assert_allclose(most, 1.0 / radians_a_texel[:, 1], rtol=2e-6)
    np.testing.assert_allclose(least * most, p.sampling_rate(d), rtol=1e-12)  # closed forms both


@EACH
@pytest.mark.parametrize("size", [1, 2, 3, 7, 16, 33, 128])
def test_solid_angles_add_up_to_the_sphere(p: Parameterization, size: int) -> None:
    solid_angle = p.texel_solid_angle(size)
    assert solid_angle.shape == p.shape(size) and solid_angle.min() >= 0.0
    # closed forms, summed in float64: rounding
    assert solid_angle.sum() == pytest.approx(4 * np.pi, rel=1e-13)


@EACH
def test_solid_angles_are_integrals_of_the_sampling_rate(p: Parameterization) -> None:
    """∫dA/rate over each texel, by Gauss-Legendre quadrature where nothing bends or ends within the texel."""
    size, points = 6, 16
    node, weight = np.polynomial.legendre.leggauss(points)
    faces, rows, columns = p.shape(size)
    fine = 0.5 + 0.5 * node
    v = ((np.arange(rows)[:, None] + fine) / rows).ravel()
    u = ((np.arange(columns)[:, None] + fine) / columns).ravel()
    face, v, u = np.meshgrid(np.arange(faces), v, u, indexing="ij")
    d, valid = p.direction_from_uv(face, np.stack([u, v], -1))
    shape = (faces, rows, points, columns, points)
    integral = (
        np.einsum("fracb,a,b->frc", (1.0 / p.sampling_rate(d)).reshape(shape), weight, weight) / (2.0 * size) ** 2
    )
    smooth = valid.reshape(shape).all((2, 4))
    if p.name == "octahedral":  # the diagonals are edges of the octahedron
        row, column = np.indices((size, size))
        smooth &= (np.abs(row + column - 5) != 3) & (np.abs(row - column) != 3)
    assert smooth.sum() > 0.4 * smooth.size
    # All integrands are smooth: rounding.
    np.testing.assert_allclose(p.texel_solid_angle(size)[smooth], integral[smooth], rtol=1e-9)


@EACH
@pytest.mark.parametrize("size", [3, 6])
def test_solid_angles_are_those_of_a_fine_quadrature(p: Parameterization, size: int) -> None:
    """Everywhere, rims and folds too."""
    fine = 64  # points along a texel's edge
    d, valid = p.texel_directions(size * fine)

    def texels(values: np.ndarray) -> np.ndarray:
        return values.reshape(p.face_count, size, fine, -1, fine).mean((2, 4))

    counted = texels(valid / p.sampling_rate(d)) / size**2
    share = texels(valid.astype(float))
    solid_angle = p.texel_solid_angle(size)
    # On the octahedron's edges the rate has a crease: half a point's width of the change along it, 1e-3 at most.
    np.testing.assert_allclose(solid_angle[share == 1.0], counted[share == 1.0], rtol=1e-3)
    # Rims cut some 2·64 of 64² cells, of which about their root, 11, are miscounted: 3e-3 of a texel.
    assert np.abs(solid_angle - counted).max() < 6e-3 * (1.0 / p.sampling_rate(d)).max() / size**2


@pytest.mark.parametrize("name", ROUND)
def test_texels_outside_the_disc_see_nothing(name: str) -> None:
    solid_angle = PARAMETERIZATIONS[name].texel_solid_angle(64)[0]
    nearest = np.maximum(np.abs(2.0 * np.arange(64) + 1.0 - 64) - 1.0, 0.0) / 64
    outside = nearest**2 + nearest[:, None] ** 2 >= 1.0
    assert outside.sum() > 4 * 64 and not solid_angle[outside].any()
    # Every other one holds some of the disc; the least corners a few 1e-6 of a texel, near the rounding of the sums.
    assert (solid_angle[~outside] > 0.0).all()


# --- compiled twins


@EACH
def test_compiled_functions_are_the_same(p: Parameterization) -> None:
    d = directions(1000)
    face, uv = p.uv_from_direction(d)
    compiled = np.array([point_of(p.kind, *each) for each in d])
    np.testing.assert_array_equal(compiled[:, 0], face)
    np.testing.assert_allclose(compiled[:, 1:], uv, atol=1e-12)  # float64 in another order
    rate = [rate_at(p.kind, *each) for each in unit(d)]
    np.testing.assert_allclose(rate, p.sampling_rate(unit(d)), rtol=1e-12)
    rng = np.random.default_rng(4)
    face, uv = rng.integers(0, p.face_count, 1000), rng.random((1000, 2))  # outside discs too
    uv[:9] = [(u, v) for u in (0.0, 0.5, 1.0) for v in (0.0, 0.5, 1.0)]
    compiled = np.array([direction_at(p.kind, int(f), *each) for f, each in zip(face, uv, strict=True)])
    np.testing.assert_allclose(compiled, p.direction_from_uv(face, uv)[0], atol=1e-12)
