"""Seams of all parameterizations: neighbours beyond edges and rims, and what the texture filter shows there."""

import numpy as np
import pytest
from samples_of_maps import EACH, unit

from reflet.envmap.mip_chain import MipChain
from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS
from reflet.envmap.parameterizations.parameterization import NONE, Parameterization
from reflet.envmap.texture_filter import sample


def around(p: Parameterization, size: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The places just outside all faces' edges, corners left out: (outside, the texel beside it, its neighbour), each
    as rows of face, row, column."""
    faces, rows, columns = p.shape(size)
    outside, beside = [], []
    for face in range(faces):
        for row in range(rows):
            outside += [(face, row, -1), (face, row, columns)]
            beside += [(face, row, 0), (face, row, columns - 1)]
        for column in range(columns):
            outside += [(face, -1, column), (face, rows, column)]
            beside += [(face, 0, column), (face, rows - 1, column)]
    out, by = np.array(outside), np.array(beside)
    return out, by, np.stack(p.across_seams(*out.T, size), -1)


@EACH
@pytest.mark.parametrize("size", [1, 2, 5, 16])
def test_every_place_around_a_face_has_a_neighbour(p: Parameterization, size: int) -> None:
    faces, rows, columns = p.shape(size)
    padded = np.stack(np.meshgrid(np.arange(faces), np.arange(-1, rows + 1), np.arange(-1, columns + 1), indexing="ij"))
    face, row, column = p.across_seams(*padded, size)
    inner = (slice(None), slice(1, -1), slice(1, -1))
    for found, asked in zip((face, row, column), padded, strict=True):
        np.testing.assert_array_equal(found[inner], asked[inner])
    assert (face == NONE).sum() == (24 if p.name == "cube" else 0)  # four corners of six faces
    there = face != NONE
    assert face[there].min() >= 0 and face.max() < faces
    assert row[there].min() >= 0 and row[there].max() < rows
    assert column[there].min() >= 0 and column[there].max() < columns


@EACH
@pytest.mark.parametrize("size", [4, 32])
def test_neighbours_over_seams_are_neighbours_on_the_sphere(p: Parameterization, size: int) -> None:
    d, _ = p.texel_directions(size)
    seen = p.texel_solid_angle(size) > 0.0
    down = np.linalg.norm(np.diff(d, axis=1), axis=-1)[seen[:, 1:] & seen[:, :-1]]
    right = np.linalg.norm(np.diff(d, axis=2), axis=-1)[seen[:, :, 1:] & seen[:, :, :-1]]
    _, beside, neighbour = around(p, size)
    used = seen[tuple(beside.T)]
    step = np.linalg.norm(d[tuple(beside[used].T)] - d[tuple(neighbour[used].T)], axis=-1)
    # Texels at a seam are mirror images of each other: as far apart as neighbours inside, up to rounding. At the rim of
    # a disc the neighbour is the nearest texel: half a diagonal farther at most.
    farther = np.sqrt(0.5) if p.is_round else 1e-12
    assert step.max() <= max(down.max(), right.max()) * (1.0 + farther)


@EACH
@pytest.mark.parametrize("size", [1, 2, 5, 16])
def test_neighbours_over_seams_are_mutual(p: Parameterization, size: int) -> None:
    _, beside, neighbour = around(p, size)
    if p.is_round:
        # only where the disc touches the border are the texels over the rim themselves at a border
        touching = np.abs(2 * beside[:, 1:] + 1 - size).min(1) <= 1
        beside, neighbour = beside[touching], neighbour[touching]
    pairs = [(tuple(a), tuple(b)) for a, b in zip(beside.tolist(), neighbour.tolist(), strict=True)]
    assert len(pairs) >= 4 and {(b, a) for a, b in pairs} == set(pairs)


@pytest.mark.parametrize("name", ["dual_paraboloid", "angular"])
@pytest.mark.parametrize("size", [4, 32])
def test_neighbours_over_a_rim_are_nearest_to_where_the_map_goes_on(name: str, size: int) -> None:
    p = PARAMETERIZATIONS[name]
    outside, _, neighbour = around(p, size)
    on, _ = p.direction_from_uv(outside[:, 0], (outside[:, :0:-1] + 0.5) / size)
    d = p.texel_directions(size)[0][tuple(neighbour.T)]
    radians_a_texel = 1.0 / (p.axis_rates(on)[0] * size)
    # Half a diagonal of the texel there; it grows by a size's share of itself on the way.
    assert (np.linalg.norm(on - d, axis=-1) < np.sqrt(0.5) * radians_a_texel * (1.0 + 1.0 / size)).all()


def seam(p: Parameterization) -> np.ndarray:
    """Directions on all seams: what lies along the edges of the faces, or the rims of their discs."""
    along = np.linspace(0.0, 1.0, 501)
    if p.is_round:
        uv = 0.5 + 0.5 * np.stack([np.cos(2 * np.pi * along), np.sin(2 * np.pi * along)], -1)
    else:
        ends = np.zeros_like(along)
        uv = np.concatenate([np.stack(pair, -1) for end in (ends, ends + 1.0) for pair in ((along, end), (end, along))])
    return np.concatenate([p.direction_from_uv(np.full(len(uv), face), uv)[0] for face in range(p.face_count)])


@pytest.mark.parametrize("name", ["cube", "latlong", "octahedral", "equal_area_octahedral"])
@pytest.mark.parametrize("lod", [0.0, 1.0, 2.4, 4.0])
def test_any_texels_are_shown_continuously_over_seams(name: str, lod: float) -> None:
    chain = MipChain(16, PARAMETERIZATIONS[name])
    texels = np.random.default_rng(2).random((chain.texel_count, 1))
    on = seam(chain.parameterization)
    if name == "latlong":  # a pole's row shows one direction many times
        on = on[np.abs(on[:, 1]) < 0.999]
    step = 1e-7 * np.random.default_rng(3).standard_normal(on.shape)
    one, other = (sample(chain, texels, on + sign * step, np.full(len(on), lod)) for sign in (1, -1))
    # Both sides blend the same texels half and half. What remains is the step of 1e-7 to 4e-7 times up to 16·π texels a
    # radian times differences of up to 1. Equal-area: texels a radian grow as 1/sqrt there where the map's octants meet
    # at a corner, -y: sqrt(1e-7)·16.
    assert np.abs(one - other).max() < (5e-3 if name == "equal_area_octahedral" else 4e-5)


@EACH
def test_smooth_radiance_is_shown_smoothly_over_seams(p: Parameterization) -> None:
    def radiance(d: np.ndarray) -> np.ndarray:
        x, y, z = np.moveaxis(unit(d), -1, 0)
        return (x + 2.0 * y + 3.0 * z + x * y - y * z)[..., None]

    on = seam(p)
    step = 1e-7 * np.random.default_rng(3).standard_normal(on.shape)
    errors, jumps = [], []
    for size in (32, 128):
        chain = MipChain(size, p)
        texels = np.zeros((chain.texel_count, 1))
        chain.level(texels, 0)[...] = radiance(p.texel_directions(size)[0])
        one, other = (sample(chain, texels, on + sign * step, np.zeros(len(on))) for sign in (1, -1))
        jumps.append(np.abs(one - other).max())
        errors.append(np.abs(one - radiance(on)).max())
    if p.name == "gazing_ball":
        # The outermost texels span 2·acos(1 - 2·sqrt(2)/size) radians at most; half of that from their middle, times a
        # gradient of 4.
        for size, error in zip((32, 128), errors, strict=True):
            assert error < 4.0 * np.arccos(1.0 - 2.0 * np.sqrt(2.0) / size)
        assert jumps[1] < 0.75 * jumps[0]  # the root of the texel's width: one half
    else:
        # To second order where texel rows go straight on (lat-long: h²/8·|f''| with h = π/32 and |f''| < 8); to first
        # order where the map has a crease or takes the nearest texel, as the texels over it lie beside the continued
        # grid: by half a texel of up to sqrt(3)·2/32 radians, times |f'| < 5.
        assert errors[0] < (0.01 if p.name == "latlong" else 0.27)
        assert errors[1] < errors[0] / (12.0 if p.name == "latlong" else 3.0)
        # Only where a disc touches its face's border do lookups of the two sides read texels of two grids.
        assert jumps[1] < (0.27 / 4.0 if p.is_round else 1e-4)
