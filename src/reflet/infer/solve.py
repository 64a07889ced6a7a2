"""Least-squares texels by preconditioned conjugate gradient."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float
from numba import njit, prange

from reflet.envmap.mip_chain import MipChain
from reflet.infer.product import multiply_planar, transpose
from reflet.infer.records import RenderingMatrix, Solution
from reflet.infer.regularization import penalty_diagonal, penalty_gradient

_RIDGE = 1e-6  # keeps the coarsest level, which the penalty does not hold, at its prior


@dataclass(frozen=True)
class SolverSettings:
    """How far a solve goes. ``regularization`` is the weight of the penalty beside rows of mean weight 1.

    ``rounds`` holds the most iterations of each round; between rounds texels are put back into their bounds. Few
    iterations are a regularization of their own: maps solved to the end show their own viewpoint no better and all
    others worse.
    """

    regularization: float = 0.02
    rounds: tuple[int, ...] = (6, 4, 4, 4)
    tolerance: float = 1e-3


def solve(
    matrix: RenderingMatrix,
    target: Float[np.ndarray, "rows channels"],
    weights: Float[np.ndarray, "rows channels"],
    prior: Float[np.ndarray, "texels channels"],
    upper: Float[np.ndarray, "channels"],
    chain: MipChain,
    settings: SolverSettings = SolverSettings(),
) -> Solution:
    """Texels x that minimize Σ weights·(A·x - target)² + regularization·‖G·(x - prior)‖², with 0 ≤ x ≤ ``upper``.

    Implements the inference of [Hakura01, sec. 4, "EM Inference"]: all mip levels at once, by conjugate gradient.
    Starts at the prior. Each channel is a system of its own with a Jacobi preconditioner; a round stops at
    ``tolerance`` times its first residual. Texels that a round drove out of their bounds are put back; the next one
    holds those at a bound that the gradient would drive out again. Memory: about nine vectors of all texels and
    channels in float32.
    """
    system = _System(matrix, weights, chain, settings.regularization)
    planar_target = np.ascontiguousarray(target.T, dtype=np.float32)
    planar_prior = np.ascontiguousarray(prior.T, dtype=np.float32)
    change = np.zeros_like(planar_prior)
    limit = upper.astype(np.float32)[:, None]
    iterations = 0
    for most in settings.rounds:
        residual = system.residual(planar_target, planar_prior, change)
        x = planar_prior + change
        free = ~(((x <= 0.0) & (residual < 0.0)) | ((x >= limit) & (residual > 0.0)))
        iterations += _conjugate_gradient(system, residual, change, free, most, settings.tolerance)
        change = np.clip(planar_prior + change, 0.0, limit) - planar_prior
    x = planar_prior + change
    return Solution(
        np.ascontiguousarray(x.T),
        iterations,
        system.relative_residual(planar_target, x),
        float(np.count_nonzero(np.diff(system.transposed.starts)) / chain.texel_count),
    )


class _System:
    """The normal equations Aᵀ·W·A + λ·Gᵀ·G + ridge."""

    def __init__(
        self, matrix: RenderingMatrix, weights: Float[np.ndarray, "rows channels"], chain: MipChain, penalty: float
    ) -> None:
        self.matrix, self.transposed, self.chain = matrix, transpose(matrix), chain
        self.weights = np.ascontiguousarray(weights.T, dtype=np.float32)
        self.penalty = np.float32(penalty)
        t = self.transposed
        squares = np.empty((len(self.weights), matrix.texel_count), np.float32)
        multiply_planar(t.starts, t.columns, t.weights**2, self.weights, squares)
        self.preconditioner = 1.0 / (squares + self.penalty * penalty_diagonal(chain) + np.float32(_RIDGE))

    def apply(self, x: Float[np.ndarray, "channels texels"]) -> Float[np.ndarray, "channels texels"]:
        """The matrix of the normal equations times x."""
        return self._gradient(self._rows(x) * self.weights, x)

    def residual(
        self,
        target: Float[np.ndarray, "channels rows"],
        prior: Float[np.ndarray, "channels texels"],
        change: Float[np.ndarray, "channels texels"],
    ) -> Float[np.ndarray, "channels texels"]:
        """Right-hand side minus left-hand side at x = prior + change."""
        return -self._gradient((self._rows(prior + change) - target) * self.weights, change)

    def relative_residual(
        self, target: Float[np.ndarray, "channels rows"], x: Float[np.ndarray, "channels texels"]
    ) -> float:
        """‖target - A·x‖ / ‖target‖ with the rows' weights; 0 where there is nothing to match."""
        norm = float((self.weights * target**2).sum(dtype=np.float64))
        return (
            float(np.sqrt((self.weights * (self._rows(x) - target) ** 2).sum(dtype=np.float64) / norm)) if norm else 0.0
        )

    def _rows(self, x: Float[np.ndarray, "channels texels"]) -> Float[np.ndarray, "channels rows"]:
        out = np.empty(self.weights.shape, np.float32)
        multiply_planar(self.matrix.starts, self.matrix.columns, self.matrix.weights, x, out)
        return out

    def _gradient(
        self, rows: Float[np.ndarray, "channels rows"], change: Float[np.ndarray, "channels texels"]
    ) -> Float[np.ndarray, "channels texels"]:
        out = np.empty((len(rows), self.chain.texel_count), np.float32)
        multiply_planar(self.transposed.starts, self.transposed.columns, self.transposed.weights, rows, out)
        out += self.penalty * penalty_gradient(self.chain, change)
        out += np.float32(_RIDGE) * change
        return out


def _conjugate_gradient(
    system: _System,
    residual: Float[np.ndarray, "channels texels"],
    change: Float[np.ndarray, "channels texels"],
    free: Bool[np.ndarray, "channels texels"],
    most: int,
    tolerance: float,
) -> int:
    """Improves ``change`` in place over the texels that are free; returns the number of iterations."""
    residual *= free
    preconditioner = system.preconditioner * free
    direction = preconditioner * residual
    energy = _dot(residual, direction)
    goal = tolerance**2 * energy
    for iteration in range(most):
        if (energy <= goal).all():
            return iteration
        image = system.apply(direction)
        step = energy / np.maximum(_dot(direction, image), 1e-30)
        _step(change, residual, direction, image, free, step.astype(np.float32))
        previous, energy = energy, _dot_weighted(residual, preconditioner)
        _turn(direction, residual, preconditioner, (energy / np.maximum(previous, 1e-30)).astype(np.float32))
    return most


_BLOCKS = 64


@njit(parallel=True, cache=True)
def _dot(a, b):  # type: ignore[no-untyped-def]
    partial = np.zeros((a.shape[0], _BLOCKS))
    n = a.shape[1]
    for task in prange(a.shape[0] * _BLOCKS):
        c, block = task // _BLOCKS, task % _BLOCKS
        total = 0.0
        for i in range(block * n // _BLOCKS, (block + 1) * n // _BLOCKS):
            total += a[c, i] * b[c, i]
        partial[c, block] = total
    return partial.sum(1)


@njit(parallel=True, cache=True)
def _dot_weighted(a, w):  # type: ignore[no-untyped-def]
    partial = np.zeros((a.shape[0], _BLOCKS))
    n = a.shape[1]
    for task in prange(a.shape[0] * _BLOCKS):
        c, block = task // _BLOCKS, task % _BLOCKS
        total = 0.0
        for i in range(block * n // _BLOCKS, (block + 1) * n // _BLOCKS):
            total += a[c, i] * a[c, i] * w[c, i]
        partial[c, block] = total
    return partial.sum(1)


@njit(parallel=True, cache=True)
def _step(change, residual, direction, image, free, step):  # type: ignore[no-untyped-def]
    n = change.shape[1]
    for task in prange(change.shape[0] * _BLOCKS):
        c, block = task // _BLOCKS, task % _BLOCKS
        for i in range(block * n // _BLOCKS, (block + 1) * n // _BLOCKS):
            change[c, i] += step[c] * direction[c, i]
            residual[c, i] -= step[c] * image[c, i] * free[c, i]


@njit(parallel=True, cache=True)
def _turn(direction, residual, preconditioner, keep):  # type: ignore[no-untyped-def]
    n = direction.shape[1]
    for task in prange(direction.shape[0] * _BLOCKS):
        c, block = task // _BLOCKS, task % _BLOCKS
        for i in range(block * n // _BLOCKS, (block + 1) * n // _BLOCKS):
            direction[c, i] = preconditioner[c, i] * residual[c, i] + keep[c] * direction[c, i]
