"""The one LOD policy: how coarse a mip level a lookup reads (CONVENTIONS.md, "LOD")."""

import numpy as np
from jaxtyping import Float

from reflet.envmap.mip_chain import MipChain
from reflet.envmap.parameterizations.cube import AXES, CUBE, face_from_direction
from reflet.envmap.parameterizations.parameterization import Parameterization

MOST_TILT = 1.0  # rad, of lobes' lookups
_SMALLEST_RHO = 1e-6  # keeps the logarithm finite where neighbours coincide
_FINEST_SAMPLES = 64


def lod_from_neighbours(
    chain: MipChain, direction: Float[np.ndarray, "3 n 3"], lod_bias: float
) -> Float[np.ndarray, "n"]:
    """LOD of lookups in [0, level_count - 1] from three directions each, of any length but zero.

    The first is the lookup itself, the others those of its neighbours to the right and down. rho is the distance to the
    farther of them, in texels of the finest level around the lookup.
    """
    if chain.parameterization == CUBE:
        rho = _distance_on_face(direction) * (0.5 * chain.size)
    else:
        rho = _distance_on_sphere(chain.parameterization, direction) * chain.size
    return np.clip(np.log2(np.maximum(rho, _SMALLEST_RHO)) + lod_bias, 0.0, chain.level_count - 1.0)


def lobe_spread(perceptual_roughness: Float[np.ndarray, "*batch"] | float) -> Float[np.ndarray, "*batch"]:
    """Sine of the angle by which a rough surface's lookup is tilted for its LOD: how far neighbours of one texel are.

    A third of the width of GGX's lobe at half its height, 4·asin √(α²(√2 - 1)/(1 - α²)), at most 1 rad; 0 of mirrors.
    Twin: `lobe_spread` of gloss.wgsl.
    """
    square = np.asarray(perceptual_roughness, np.float64) ** 4
    quarter = np.sqrt(square * (np.sqrt(2.0) - 1.0) / np.maximum(1.0 - square, 1e-6))
    return np.asarray(np.sin(4.0 / 3.0 * np.arcsin(np.minimum(quarter, np.sin(0.75 * MOST_TILT)))))


def roughness_of_level(mip_level: int, size: int) -> float:
    """The perceptual_roughness whose lookups read a level of cubes of ``size`` rows: of so wide a lobe, at that level's
    texels as they are in the mean. 0.12 for level 0 of 128 rows, never 1."""
    tilt = 0.5 * np.pi * 2.0**mip_level / size
    square = np.sin(min(0.75 * tilt, 0.5 * np.pi)) ** 2
    return float((square / (np.sqrt(2.0) - 1.0 + square)) ** 0.25)


def finer_lod_bias(lod_bias: float, sample_count: int, samples: int) -> float:
    """An LOD bias that is for ``sample_count`` samples a pixel, at ``samples``: half a level a doubling, as samples lie
    closer together, up to `_FINEST_SAMPLES`; finer levels than theirs show texels, which crawl as the camera moves."""
    return lod_bias - 0.5 * float(np.log2(min(samples, _FINEST_SAMPLES) / sample_count))


def _distance_on_face(direction: Float[np.ndarray, "3 n 3"]) -> Float[np.ndarray, "n"]:
    """In units of (s, t): all three are projected on the face that the first meets.

    A neighbour behind the face plane counts as infinitely far.
    """
    face, s, t = face_from_direction(direction[0])
    furthest = np.zeros(face.shape)
    for neighbour in direction[1:]:
        major, a, b = np.moveaxis(np.einsum("nkj,nj->nk", AXES[face], neighbour), -1, 0)
        ahead = major > 0.0
        safe = np.where(ahead, major, 1.0)
        distance = np.hypot(a / safe - s, b / safe - t)
        furthest = np.maximum(furthest, np.where(ahead, distance, np.inf))
    return furthest


def _distance_on_sphere(
    parameterization: Parameterization, direction: Float[np.ndarray, "3 n 3"]
) -> Float[np.ndarray, "n"]:
    """In texels of a map of size 1: the chord times the root of the texels a steradian there.

    Nothing of the map's layout comes in, so that the LOD has no seams; texels longer one way than the other count
    as square.
    """
    unit = direction / np.linalg.norm(direction, axis=-1, keepdims=True)
    chord = np.linalg.norm(unit[1:] - unit[0], axis=-1).max(0)
    return np.asarray(chord * np.sqrt(parameterization.sampling_rate(unit[0])))
