"""Least squares: known maps are found again, and scipy finds the same."""

from itertools import pairwise

import numpy as np
import pytest
import scipy.sparse
import scipy.sparse.linalg
from synthetic import Picture, as_scipy

from reflet.envmap.geometry import Box
from reflet.envmap.mip_chain import MipChain
from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS
from reflet.envmap.resampling.mip_reduction import prolong
from reflet.infer.product import multiply
from reflet.infer.records import RenderingMatrix, Rows
from reflet.infer.regularization import MipPenalty
from reflet.infer.rendering_matrix import rendering_matrix
from reflet.infer.solve import SolverSettings, solve

ROOM = Box((-2.0, -0.3, -2.0), (2.0, 2.0, 1.0), (0.0, 0.1, 0.0))
NO_LIMIT = np.full(3, 1e6)


def details_matrix(chain: MipChain) -> np.ndarray:
    """G, from the reference of prolongation."""
    identity = np.eye(chain.texel_count)
    g = np.zeros_like(identity)
    for level in range(chain.level_count - 1):
        span = slice(chain.offsets[level], chain.offsets[level + 1])
        g[span] = identity[span] - prolong(chain, identity, level).reshape(-1, chain.texel_count)
    return g


def problem(picture: Picture, size: int, lod_bias: float = -1.0) -> tuple[MipChain, RenderingMatrix, np.ndarray]:
    """A map's chain, the matrix of a picture, and random texels."""
    chain = MipChain(size)
    matrix = rendering_matrix(picture.gbuffer, chain, ROOM, lod_bias)
    return chain, matrix, np.random.default_rng(0).random((chain.texel_count, 3)).astype(np.float32)


def rows(matrix: RenderingMatrix, target: np.ndarray, weights: np.ndarray | None = None) -> list[Rows]:
    """One block of rows, of weight 1 if not told."""
    weights = np.ones(len(target)) if weights is None else weights
    return [Rows(matrix, target.astype(np.float32), weights.astype(np.float32))]


def cut(whole: Rows, first: int, end: int) -> Rows:
    """Some rows of a block."""
    starts = whole.matrix.starts[first : end + 1]
    span = slice(starts[0], starts[-1])
    matrix = RenderingMatrix(
        starts - starts[0], whole.matrix.columns[span], whole.matrix.weights[span], whole.matrix.texel_count
    )
    return Rows(matrix, whole.target[first:end], whole.weights[first:end])


def test_blocks_of_rows_are_one_problem(sphere_picture: Picture) -> None:
    """However rows are cut into blocks: to float32's rounding, which sums in another order."""
    chain, matrix, texels = problem(sphere_picture, 16)
    target = multiply(matrix, texels)
    (whole,) = rows(matrix, target, 0.5 + np.random.default_rng(3).random(len(target)))
    ends = [0, 5, len(target) // 3, len(target)]
    blocks = [cut(whole, first, end) for first, end in pairwise(ends)]
    prior = np.full_like(texels, 0.4)
    one, many = (solve(each, prior, NO_LIMIT, MipPenalty(chain)) for each in ([whole], blocks))
    assert np.abs(one.texels - many.texels).max() < 1e-4
    assert many.relative_residual == pytest.approx(one.relative_residual, rel=1e-3)
    assert many.seen_share == one.seen_share


@pytest.mark.parametrize("name", PARAMETERIZATIONS)
@pytest.mark.parametrize("size", [1, 2, 16])
def test_the_penalty_is_that_of_its_matrix(size: int, name: str) -> None:
    chain = MipChain(size, PARAMETERIZATIONS[name])
    g = details_matrix(chain)
    d = np.random.default_rng(1).standard_normal((2, chain.texel_count)).astype(np.float32)
    assert np.abs(MipPenalty(chain).gradient(d) - d @ (g.T @ g)).max() < 3e-6  # float32 sums of some tens of terms
    # Texels at edges gather from a few texels more or less than the interior's sixteen; a texel that is its own
    # neighbour gathers all there is (4 instead of 25/16). Preconditioners need no more.
    exact, found = np.diag(g.T @ g), MipPenalty(chain).diagonal()
    assert (found >= 0.39 * exact).all() and (found <= 1.4 * exact).all()


@pytest.mark.parametrize("name", PARAMETERIZATIONS)
def test_a_change_by_a_constant_costs_nothing(name: str) -> None:
    chain = MipChain(32, PARAMETERIZATIONS[name])
    assert np.abs(MipPenalty(chain).gradient(np.full((1, chain.texel_count), 0.5, np.float32))).max() < 1e-6


def test_equals_scipys_solution(sphere_picture: Picture) -> None:
    chain, matrix, texels = problem(sphere_picture, 8)
    target = multiply(matrix, texels)
    weights = 0.5 + np.random.default_rng(2).random(len(target))
    prior = np.full_like(texels, 0.4)
    settings = SolverSettings(regularization=0.1, rounds=(400,), tolerance=1e-7)
    found = solve(rows(matrix, target, weights), prior, NO_LIMIT, MipPenalty(chain), settings).texels
    a, g = as_scipy(matrix), scipy.sparse.csr_matrix(details_matrix(chain))
    for c in range(3):
        normal = a.T @ scipy.sparse.diags(weights) @ a + weights.mean() * (
            0.1 * g.T @ g + 1e-6 * scipy.sparse.eye(chain.texel_count)
        )
        right = a.T @ (weights * (target[:, c] - a @ prior[:, c]))
        expected = prior[:, c] + scipy.sparse.linalg.spsolve(normal.tocsc(), right)
        # Where only the ridge of 1e-6 decides, float32 cannot tell; what is shown must agree to float32's residual.
        assert np.abs(a @ (found[:, c] - expected)).max() < 1e-4


def test_what_was_shown_is_shown_again(sphere_picture: Picture) -> None:
    """A·x̂ = A·x for a known map, though texels outnumber what the picture sees."""
    chain, matrix, texels = problem(sphere_picture, 8)
    target = multiply(matrix, texels)
    settings = SolverSettings(regularization=0.0, rounds=(400,), tolerance=1e-9)
    solution = solve(rows(matrix, target), np.zeros_like(texels), NO_LIMIT, MipPenalty(chain), settings)
    # float32 sums of some tens of terms: 1e-6, times the square root of a condition of about 1e4.
    assert solution.relative_residual < 1e-4
    assert np.abs(multiply(matrix, solution.texels) - target).max() < 1e-3


def test_an_over_determined_map_is_found_itself(sphere_picture: Picture) -> None:
    """Texels of a small map that the picture sees well come out as they were, without a prior."""
    chain, matrix, texels = problem(sphere_picture, 8, lod_bias=-2.0)
    target = multiply(matrix, texels)
    settings = SolverSettings(regularization=0.0, rounds=(2000,), tolerance=1e-9)
    found = solve(rows(matrix, target), np.zeros_like(texels), NO_LIMIT, MipPenalty(chain), settings).texels
    a = as_scipy(matrix).toarray()
    seen = np.flatnonzero(a.any(0))
    values, vectors = np.linalg.eigh(a[:, seen].T @ a[:, seen])
    # Determined: (next to) no part in directions that float32 cannot resolve beside the largest eigenvalue.
    vague = np.sqrt((vectors[:, values < 1e-4 * values[-1]] ** 2).sum(1))
    sure = seen[vague < 1e-2]
    assert len(sure) > 100
    assert np.abs(found - texels)[sure].max() < 0.02  # 1e-2 of unseen directions whose texels are off by up to 1


@pytest.mark.parametrize(
    ("prior", "settings"), [(0.7, SolverSettings()), (0.2, SolverSettings(rounds=(400,), tolerance=1e-6))]
)
def test_a_constant_scene_gives_a_constant_map(sphere_picture: Picture, prior: float, settings: SolverSettings) -> None:
    """Within the white furnace's 0.05 %: from the right prior at once, from a wrong one when solved to the end."""
    chain, matrix, texels = problem(sphere_picture, 32)
    target = np.full((len(matrix.starts) - 1, 3), 0.7)
    priors = np.full_like(texels, prior)
    solution = solve(rows(matrix, target), priors, NO_LIMIT, MipPenalty(chain), settings)
    assert np.abs(multiply(matrix, solution.texels) / 0.7 - 1.0).max() < 0.0005


def test_texels_that_nothing_sees_keep_their_prior(sphere_picture: Picture) -> None:
    chain, matrix, texels = problem(sphere_picture, 16)
    target = multiply(matrix, texels)
    solution = solve(rows(matrix, target), texels, NO_LIMIT, MipPenalty(chain))
    assert np.abs(solution.texels - texels).max() < 1e-5  # nothing to change: float32 residuals only
    seen = np.bincount(matrix.columns, minlength=chain.texel_count) > 0
    assert solution.seen_share == seen.mean()
    assert 0.2 < solution.seen_share < 1.0


def test_unseen_texels_follow_their_coarser_neighbourhood(sphere_picture: Picture) -> None:
    """If all that is seen turns out 0.3 brighter than the prior, so does the rest."""
    chain, matrix, texels = problem(sphere_picture, 16)
    target = multiply(matrix, texels + 0.3)
    settings = SolverSettings(rounds=(300,), tolerance=1e-6)
    solution = solve(rows(matrix, target), texels, NO_LIMIT, MipPenalty(chain), settings)
    assert np.abs(solution.texels - texels - 0.3).max() < 0.01  # the ridge pulls by 1e-6 against 1e-4 a coarse texel


def test_texels_stay_within_bounds_and_the_others_make_up_for_it(sphere_picture: Picture) -> None:
    """Spots of light make least squares ring: solved within bounds they show more than if merely clipped."""
    chain, matrix, texels = problem(sphere_picture, 16)
    light = np.where(np.arange(chain.texel_count)[:, None] % 37 == 0, 40.0, 0.0) * np.ones((1, 3), np.float32)
    target = np.minimum(multiply(matrix, light.astype(np.float32)), 8.0)
    dark, limit = np.zeros_like(texels), np.full(3, 10.0)
    clipped = solve(rows(matrix, target), dark, limit, MipPenalty(chain), SolverSettings(rounds=(40,)))
    bounded = solve(rows(matrix, target), dark, limit, MipPenalty(chain), SolverSettings(rounds=(10, 10, 10, 10)))
    for solution in (clipped, bounded):
        assert solution.texels.min() >= 0.0
        assert solution.texels.max() <= 10.0
    assert bounded.relative_residual < 0.95 * clipped.relative_residual  # equal if rounds did nothing


def test_an_empty_picture_gives_the_prior() -> None:
    chain = MipChain(4)
    nothing = RenderingMatrix(np.zeros(1, np.int32), np.zeros(0, np.int32), np.zeros(0, np.float32), chain.texel_count)
    prior = np.full((chain.texel_count, 3), 0.25, np.float32)
    solution = solve(rows(nothing, np.zeros((0, 3))), prior, NO_LIMIT, MipPenalty(chain))
    assert np.array_equal(solution.texels, prior)
    assert solution.seen_share == 0.0
