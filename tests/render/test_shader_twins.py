"""WGSL functions against their NumPy twins."""

import numpy as np
import pytest
from compute import run

from reflet.envmap.geometry import Box, Ellipsoid, Hemisphere, InfiniteSphere, Sphere, pack
from reflet.envmap.lod import lod_from_neighbours
from reflet.envmap.mip_chain import MipChain
from reflet.envmap.parameterizations.cube import texel_directions
from reflet.envmap.relief import Relief, inverse_chebyshev
from reflet.envmap.shapes import FAR_AWAY
from reflet.report.measures import tone_map

GEOMETRIES = [
    InfiniteSphere(),
    Sphere((0.1, 0.2, 0.0), (2.0, 2.0, 2.0), (0.0, 0.1, 0.2)),
    Ellipsoid((0.1, 0.2, 0.0), (2.0, 1.5, 3.0), (0.0, 0.1, 0.2)),
    Box((-2.0, -1.0, -1.5), (1.5, 2.0, 2.5), (0.2, 0.1, 0.0)),
    Hemisphere((0.0, -0.5, 0.0), (3.0, 3.0, 3.0), -0.5, (0.0, 0.2, 0.0)),
]


@pytest.fixture(name="rays")
def _rays() -> tuple[np.ndarray, np.ndarray]:
    random = np.random.default_rng(3)
    r = random.normal(size=(2000, 3)).astype(np.float32)
    r /= np.linalg.norm(r, axis=-1, keepdims=True)
    r[:3] = np.eye(3)  # rays along the axes: slabs that are never met
    return random.uniform(-0.4, 0.4, (2000, 3)).astype(np.float32), r


@pytest.mark.parametrize("geometry", GEOMETRIES, ids=lambda g: g.kind)
def test_lookup_direction(geometry, rays) -> None:  # type: ignore[no-untyped-def]
    p, r = rays
    code = """
    #import geometry
    let g = Geometry(vec4f(in2[0], in2[1], in2[2], in2[3]), vec4f(in2[4], in2[5], in2[6], in2[7]),
                     vec4f(in2[8], in2[9], in2[10], in2[11]));
    let d = lookup_direction(g.kind_a.x, g, vec3f(in0[3*i], in0[3*i+1], in0[3*i+2]),
                             vec3f(in1[3*i], in1[3*i+1], in1[3*i+2]));
    out[3*i] = d.x; out[3*i+1] = d.y; out[3*i+2] = d.z;
    """
    shader = run(code, [p, r, pack(geometry)[None]], 3)
    reference = geometry.lookup_direction(p.astype(float), r.astype(float))
    # Coordinates up to 5 in float32, a square root and a division: some ten roundings of 3e-7.
    np.testing.assert_allclose(shader, reference, atol=4e-6)


def test_sides_that_are_not_there_are_finite_numbers(rays) -> None:  # type: ignore[no-untyped-def]
    """Rays that leave a box where it is open are as at infinity, also along the axes and where they are squared."""
    p, r = rays
    r[3:6] = -np.eye(3)
    box = Box((-FAR_AWAY, -0.5, -1.5), (FAR_AWAY,) * 3, (0.2, 0.1, 0.0))
    code = """
    #import map_lookup
    #import geometry
    let g = Geometry(vec4f(in2[0], in2[1], in2[2], in2[3]), vec4f(in2[4], in2[5], in2[6], in2[7]),
                     vec4f(in2[8], in2[9], in2[10], in2[11]));
    let d = lookup_direction(g.kind_a.x, g, vec3f(in0[3*i], in0[3*i+1], in0[3*i+2]),
                             vec3f(in1[3*i], in1[3*i+1], in1[3*i+2]));
    let n = normalize(d);
    out[5*i] = n.x; out[5*i+1] = n.y; out[5*i+2] = n.z;
    out[5*i+3] = map_lod(OCTAHEDRAL, d, d * 1.5, d, 64.0, 0.0, 6.0);
    out[5*i+4] = map_lod(CUBE, d, d * 1.5, d, 64.0, 0.0, 6.0);
    """
    shader = run(code, [p, r, pack(box)[None]], 5)
    expected = box.lookup_direction(p.astype(float), r.astype(float))
    expected /= np.linalg.norm(expected, axis=-1, keepdims=True)
    np.testing.assert_allclose(shader[:, :3], expected, atol=1e-6)  # some ten roundings of float32
    open_to = ((r[:, 1] > -1e-6) & (r[:, 2] > -1e-6)).nonzero()[0]
    np.testing.assert_allclose(shader[open_to, :3], r[open_to], atol=1e-6)
    assert len(open_to) > 300 and (shader[:, 3:] == 0.0).all()  # neighbours in the same direction


def rough_relief() -> Relief:
    """A room around a table's edge: walls, a floor nearer by, and gaps between them."""
    direction = texel_directions(64)
    walls = 1.0 / np.abs(direction).max(-1) * 2.0
    with np.errstate(divide="ignore"):
        floor = np.where(direction[..., 1] < -0.6, -0.5 / direction[..., 1], np.inf)
    q = inverse_chebyshev(np.minimum(walls, floor)).astype(np.float16)
    return Relief(q, (-2.0, -1.0, -1.5), (1.5, 2.0, 2.5), (0.2, 0.1, 0.0))


def test_relief(rays) -> None:  # type: ignore[no-untyped-def]
    p, r = rays
    relief = rough_relief()
    code = """
    #import relief
    let g = Geometry(vec4f(in2[0], in2[1], in2[2], in2[3]), vec4f(in2[4], in2[5], in2[6], in2[7]),
                     vec4f(in2[8], in2[9], in2[10], in2[11]));
    out[i] = inverse_hit(g, reliefs, 1, linear, vec3f(in0[3*i], in0[3*i+1], in0[3*i+2]),
                         vec3f(in1[3*i], in1[3*i+1], in1[3*i+2]));
    """
    nothing = np.zeros_like(relief.inverse_distance)
    shader = run(code, [p, r, pack(relief)[None]], 1, reliefs=[nothing, relief.inverse_distance])[:, 0]
    error = np.abs(shader - relief.inverse_hit(p.astype(float), r.astype(float)))
    # Ten roundings of float32 in numbers up to 3, magnified where the relief is steep and by each step of the search.
    assert np.percentile(error, 50) < 1e-6
    assert np.percentile(error, 95) < 1e-4
    # A search that rounding sends to the other side of a gap ends there: rare, but no shader can help it.
    assert np.mean(error > 1e-2) < 0.002


def test_cube_lod() -> None:
    random = np.random.default_rng(4)
    d = random.normal(size=(4000, 3))
    neighbours = d + random.normal(size=(2, 4000, 3)) * 10.0 ** random.uniform(-4, 0.5, (1, 4000, 1))
    directions = np.stack([d, *neighbours]).astype(np.float32)
    code = """
    #import cube_lod
    out[i] = cube_lod(vec3f(in0[3*i], in0[3*i+1], in0[3*i+2]), vec3f(in1[3*i], in1[3*i+1], in1[3*i+2]),
                      vec3f(in2[3*i], in2[3*i+1], in2[3*i+2]), 256.0, -1.5, 8.0);
    """
    shader = run(code, list(directions), 1)[:, 0]
    reference = lod_from_neighbours(MipChain(256), directions.astype(float), -1.5)
    # The difference of two (s, t) near 1 that lie 1e-4 apart: 1e-7/1e-4·log2(e), with room for projections beyond 1.
    assert np.abs(shader - reference).max() < 5e-3
    assert np.median(np.abs(shader - reference)) < 1e-5
    assert (reference == 8.0).any() and (reference == 0.0).any()


def test_tone_mapping_is_the_projects_measure() -> None:
    radiance = np.random.default_rng(5).uniform(0, 3, (500, 3)).astype(np.float32)
    code = """
    #import tone
    let c = tone_mapped(1.6 * vec3f(in0[3*i], in0[3*i+1], in0[3*i+2]), TONE_EXPONENTIAL);
    out[3*i] = c.x; out[3*i+1] = c.y; out[3*i+2] = c.z;
    """
    # pow() is only good to some 1e-6 on graphics devices.
    np.testing.assert_allclose(run(code, [radiance], 3), tone_map(radiance), atol=1e-5)


def test_precise_numbers_keep_48_bits() -> None:
    random = np.random.default_rng(6)
    a, b = random.normal(size=(2, 1000, 3)).astype(np.float32)
    # a b - c d with nearly equal products: float32 alone would have no digit right.
    c = np.nextafter(a, np.float32(2))
    code = """
    #import precise
    let a = vec3f(in0[3*i], in0[3*i+1], in0[3*i+2]);
    let b = vec3f(in1[3*i], in1[3*i+1], in1[3*i+2]);
    let c = vec3f(in2[3*i], in2[3*i+1], in2[3*i+2]);
    let none = vec3f(0.0);
    let d = precise_difference(precise_product(Precise(a, none), Precise(b, none)),
                               precise_product(Precise(c, none), Precise(b, none)));
    out[3*i] = d.value.x; out[3*i+1] = d.value.y; out[3*i+2] = d.value.z;
    """
    exact = a.astype(float) * b - c.astype(float) * b
    np.testing.assert_allclose(run(code, [a, b, c], 3), exact, rtol=1e-6)  # of the difference itself: 24 bits
    assert np.abs((a * b - c * b) / exact - 1).max() > 0.1
