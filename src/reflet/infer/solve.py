"""Least-squares texels by preconditioned conjugate gradient."""

from collections.abc import Collection
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from jaxtyping import Bool, Float
from numba import njit, prange

from reflet.infer.product import Gatherer, squared_columns
from reflet.infer.records import Rows, Solution

_RIDGE = 1e-6  # keeps what the penalty does not hold, such as the coarsest level, at its prior


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


class Penalty(Protocol):
    """What a change d of the texels costs: a quadratic form ‖G·d‖²."""

    def gradient(self, d: Float[np.ndarray, "channels texels"]) -> Float[np.ndarray, "channels texels"]:
        """Gᵀ·G·d, half the gradient, in float32."""
        ...

    def diagonal(self) -> Float[np.ndarray, "texels"]:
        """Of Gᵀ·G, or nearly."""
        ...


def solve(
    rows: Collection[Rows],
    prior: Float[np.ndarray, "texels channels"],
    upper: Float[np.ndarray, "channels"],
    penalty: Penalty,
    settings: SolverSettings = SolverSettings(),
    *,
    lower: float = 0.0,
) -> Solution:
    """Texels x that minimize Σ weights·(A·x - target)² + regularization·‖G·(x - prior)‖², ``lower`` ≤ x ≤ ``upper``.

    Implements the inference of [Hakura01, sec. 4, "EM Inference"]: all texels at once, by conjugate gradient.
    Starts at the prior. The sum goes over all blocks of ``rows``, which may be read from disk whenever they are asked
    for; weights count beside the mean of those that are positive. Each channel is a system of its own with a Jacobi
    preconditioner; a round stops at ``tolerance`` times its first residual. Texels that a round drove out of their
    bounds are put back; the next one holds those at a bound that the gradient would drive out again. Memory: about
    fourteen vectors of all texels and channels in float32, and one block of rows.
    """
    system = _System(rows, len(prior), penalty, settings.regularization)
    planar_prior = np.ascontiguousarray(prior.T, dtype=np.float32)
    change = np.zeros_like(planar_prior)
    limit = upper.astype(np.float32)[:, None]
    iterations = 0
    for most in settings.rounds:
        residual, _ = system.residual(planar_prior, change)
        x = planar_prior + change
        free = ~(((x <= lower) & (residual < 0.0)) | ((x >= limit) & (residual > 0.0)))
        iterations += _conjugate_gradient(system, residual, change, free, most, settings.tolerance)
        change = np.clip(planar_prior + change, np.float32(lower), limit) - planar_prior
    return Solution(
        np.ascontiguousarray((planar_prior + change).T),
        iterations,
        system.relative_residual(planar_prior, change),
        system.seen_share,
    )


class _System:
    """The normal equations Aᵀ·W·A + λ·Gᵀ·G + ridge, with λ and the ridge beside rows of mean weight 1."""

    def __init__(self, rows: Collection[Rows], texels: int, penalty: Penalty, regularization: float) -> None:
        self.rows, self.penalty = rows, penalty
        squares, total, count, self.target_norm = np.zeros(texels, np.float32), 0.0, 0, 0.0
        for block in rows:
            squared_columns(block, squares)
            total += float(block.weights.sum(dtype=np.float64))
            count += int(np.count_nonzero(block.weights))
            self.target_norm += float((block.weights[:, None] * block.target**2).sum(dtype=np.float64))
        mean = total / count if count else 1.0
        self.regularization, self.ridge = np.float32(regularization * mean), np.float32(_RIDGE * mean)
        self.preconditioner = 1.0 / (squares + self.regularization * penalty.diagonal() + self.ridge)
        self.seen_share = float(np.count_nonzero(squares) / texels)

    def apply(self, x: Float[np.ndarray, "channels texels"]) -> Float[np.ndarray, "channels texels"]:
        """The matrix of the normal equations times x."""
        gatherer = Gatherer(x.T)
        for block in self.rows:
            gatherer.add(block)
        return self._with_penalty(gatherer, x)

    def residual(
        self, prior: Float[np.ndarray, "channels texels"], change: Float[np.ndarray, "channels texels"]
    ) -> tuple[Float[np.ndarray, "channels texels"], float]:
        """Right-hand side minus left-hand side at x = prior + change, and Σ weights·(A·x - target)²."""
        gatherer = Gatherer((prior + change).T)
        squares = sum(gatherer.add(block, minus_target=True) for block in self.rows)
        return -self._with_penalty(gatherer, change), squares

    def relative_residual(
        self, prior: Float[np.ndarray, "channels texels"], change: Float[np.ndarray, "channels texels"]
    ) -> float:
        """‖target - A·x‖ / ‖target‖ with the rows' weights; 0 where there is nothing to match."""
        return float(np.sqrt(self.residual(prior, change)[1] / self.target_norm)) if self.target_norm else 0.0

    def _with_penalty(
        self, gatherer: Gatherer, change: Float[np.ndarray, "channels texels"]
    ) -> Float[np.ndarray, "channels texels"]:
        out = gatherer.planar_sum()
        out += self.regularization * self.penalty.gradient(change)
        out += self.ridge * change
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
