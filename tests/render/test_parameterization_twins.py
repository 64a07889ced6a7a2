"""Parameterizations, their LOD and their texture filter in WGSL, against the NumPy they are twins of."""

import numpy as np
import pytest
from compute import run

from reflet.envmap.lod import lod_from_neighbours
from reflet.envmap.mip_chain import MipChain
from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS
from reflet.envmap.parameterizations.parameterization import NONE, Parameterization
from reflet.envmap.texture_filter import sample

EACH = pytest.mark.parametrize("p", PARAMETERIZATIONS.values(), ids=str)
D = "vec3f(in0[3*i], in0[3*i+1], in0[3*i+2])"


def unit(direction: np.ndarray) -> np.ndarray:
    return direction / np.linalg.norm(direction, axis=-1, keepdims=True)


def directions() -> np.ndarray:
    """float32 directions of any length: all over the sphere, and close to all axes, edges, diagonals and corners."""
    rng = np.random.default_rng(0)
    special = np.array(
        [(x, y, z) for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1) if (x, y, z) != (0, 0, 0)]
    )
    near = special[rng.integers(0, 26, 3000)] * rng.uniform(0.1, 10.0, (3000, 1))
    near += rng.standard_normal((3000, 3)) * 10.0 ** rng.uniform(-6, -1, (3000, 1))
    return np.concatenate([special, near, rng.standard_normal((3000, 3))]).astype(np.float32)


@EACH
def test_map_point(p: Parameterization) -> None:
    d = directions()
    code = f"""
    #import parameterization
    let at = map_point({p.kind}u, {D});
    out[3*i] = f32(at.face); out[3*i+1] = at.uv.x; out[3*i+2] = at.uv.y;
    """
    shader = run(code, [d], 3)
    face, uv = p.uv_from_direction(d.astype(float))
    # Where faces or ends of the map meet, rounding may choose the other; then the two are one direction. Some three
    # roundings of 6e-8 of numbers near 1; on the sphere map's rim an angle is their root.
    there = p.direction_from_uv(shader[:, 0].astype(int), shader[:, 1:].astype(float))[0]
    near_rim = (p.name == "gazing_ball") & (unit(d.astype(float))[:, 2] < -0.9)
    assert (np.abs(there - unit(d.astype(float))).max(1) < np.where(near_rim, 2e-3, 3e-6)).all()
    same = (shader[:, 0] == face) & (np.abs(shader[:, 1:] - uv).max(1) < 0.1)
    assert same.mean() > 0.95
    assert np.abs(shader[:, 1:] - uv)[same].max() < 3e-7


@EACH
def test_map_direction(p: Parameterization) -> None:
    rng = np.random.default_rng(1)
    uv = rng.random((4000, 2)).astype(np.float32)  # outside discs too
    uv[:25] = [(u, v) for u in (0.0, 0.25, 0.5, 0.75, 1.0) for v in (0.0, 0.25, 0.5, 0.75, 1.0)]
    face = rng.integers(0, p.face_count, (4000, 1))
    code = f"""
    #import parameterization
    let d = map_direction({p.kind}u, u32(in1[i]), vec2f(in0[2*i], in0[2*i+1]));
    out[3*i] = d.x; out[3*i+1] = d.y; out[3*i+2] = d.z;
    """
    shader = run(code, [uv, face], 3)
    reference = p.direction_from_uv(face[:, 0], uv.astype(float))[0]
    # Angles up to 2π in float32 err by 5e-7; so do sine and cosine on this adapter (2e-7, some hardware 1e-6). On the
    # sphere map's rim 1 - r² errs by 1e-7, and its root by 4e-4.
    near_rim = (p.name == "gazing_ball") & (reference[:, 2] < -0.9)
    assert (np.abs(shader - reference).max(1) < np.where(near_rim, 1e-3, 2e-6)).all()


@EACH
def test_sampling_rate(p: Parameterization) -> None:
    d = unit(directions()).astype(np.float32)
    code = f"""
    #import parameterization
    out[i] = sampling_rate({p.kind}u, {D});
    """
    # Some ten roundings of 6e-8.
    np.testing.assert_allclose(run(code, [d], 1)[:, 0], p.sampling_rate(d.astype(float)), rtol=1e-6)


@EACH
@pytest.mark.parametrize("size", [1, 2, 4, 64])
def test_across_seams(p: Parameterization, size: int) -> None:
    faces, rows, columns = p.shape(size)
    padded = np.meshgrid(np.arange(faces), np.arange(-1, rows + 1), np.arange(-1, columns + 1), indexing="ij")
    face, row, column = (each.ravel() for each in padded)
    code = f"""
    #import parameterization
    let texel = across_seams({p.kind}u, i32(in0[3*i]), vec2i(i32(in0[3*i+2]), i32(in0[3*i+1])), {size});
    out[3*i] = f32(texel.x); out[3*i+1] = f32(texel.y); out[3*i+2] = f32(texel.z);
    """
    shader = run(code, [np.stack([face, row, column], -1)], 3)
    face, row, column = p.across_seams(face, row, column, size)
    np.testing.assert_array_equal(shader[:, 2], face)
    there = face != NONE
    np.testing.assert_array_equal(shader[there, :2], np.stack([column, row], -1)[there])


@EACH
def test_map_lod(p: Parameterization) -> None:
    rng = np.random.default_rng(4)
    d = directions()
    neighbours = d * rng.uniform(0.5, 2.0, (2, len(d), 1)) + np.linalg.norm(d, axis=1, keepdims=True) * (
        rng.standard_normal((2, len(d), 3)) * 10.0 ** rng.uniform(-3, 0.5, (1, len(d), 1))
    )
    three = np.stack([d, *neighbours]).astype(np.float32)
    code = f"""
    #import map_lookup
    out[i] = map_lod({p.kind}u, {D}, vec3f(in1[3*i], in1[3*i+1], in1[3*i+2]), vec3f(in2[3*i], in2[3*i+1], in2[3*i+2]),
                     256.0, -1.5, 8.0);
    """
    error = np.abs(run(code, list(three), 1)[:, 0] - lod_from_neighbours(MipChain(256, p), three.astype(float), -1.5))
    # Chords of 1e-3 between unit vectors good to 1e-7: 1e-4·log2(e), for the least a few times that.
    assert error.max() < 5e-4
    assert np.median(error) < 1e-5


@EACH
def test_sample_map(p: Parameterization) -> None:
    """Any texels, all levels, the second of two maps in one array; seams and corners among the directions."""
    rng = np.random.default_rng(5)
    chain = MipChain(16, p)
    texels = rng.random((chain.texel_count, 4)).astype(np.float32)
    d = directions()
    lod = rng.uniform(0.0, chain.level_count - 1.0, len(d)).astype(np.float32)
    lod[::5] = np.round(lod[::5])
    levels = [
        np.concatenate([np.full_like(level, 9.0), level])
        for level in (chain.level(texels, k) for k in range(chain.level_count))
    ]
    code = f"""
    #import map_lookup
    let c = sample_map({p.kind}u, maps, {p.face_count}, {D}, in1[i]);
    out[4*i] = c.x; out[4*i+1] = c.y; out[4*i+2] = c.z; out[4*i+3] = c.w;
    """
    shader = run(code, [d, lod[:, None]], 4, levels)
    reference = sample(chain, texels, d.astype(float), lod.astype(float))
    error = np.abs(shader - reference).max(1)
    # Where the map shows one direction in many places (poles, the rims of discs) or in two (seams of which only smooth
    # texels are one: the rims of the two paraboloids), rounding chooses among them.
    x, y, z = np.abs(unit(d.astype(float))).T
    several = {
        "latlong": np.hypot(x, z) < 1e-5,
        "gazing_ball": (np.hypot(x, y) < 2e-3) & (d[:, 2] < 0),
        "angular": (np.hypot(x, y) < 1e-5) & (d[:, 2] > 0),
        "dual_paraboloid": z < 1e-6,
    }.get(p.name, np.zeros(len(d), bool))
    assert several.mean() < 0.25
    assert error[~several].max() < 1e-5  # 32 columns times uv good to 3e-7, times differences of up to 1
