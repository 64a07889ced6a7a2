"""Chance for drawn strokes: the same for the same seed, on every machine and at every size of a map."""

import numpy as np
from jaxtyping import Float, Int

Keys = Int[np.ndarray, "*batch"]
_TERMS = 5


def chance(seed: int, *keys: Keys | int) -> Float[np.ndarray, "*batch"]:
    """A number in [0, 1) for each tuple of whole numbers, evenly spread, unrelated between neighbours.

    The mixing steps are those of SplitMix64 [Steele14].
    """
    state: np.ndarray = np.asarray(seed, np.uint64)
    with np.errstate(over="ignore"):
        for key in keys:
            state = (np.asarray(key).astype(np.int64).view(np.uint64) + state) * np.uint64(0x9E3779B97F4A7C15)
            state = (state ^ (state >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
            state = (state ^ (state >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
            state = state ^ (state >> np.uint64(31))
    return np.asarray((state >> np.uint64(11)) * 2.0**-53)


def tremor(seed: int, key: Keys | int, turns: Float[np.ndarray, "*batch"]) -> Float[np.ndarray, "*batch"]:
    """How a hand strays from its line: smooth, mean 0, about ±1, with a period of 1 in ``turns``."""
    total = np.zeros(np.shape(turns))
    for k in range(_TERMS):
        total = total + np.cos(2.0 * np.pi * ((k + 1) * turns + chance(seed, key, k))) / (k + 1.5)
    return total
