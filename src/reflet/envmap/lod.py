"""The one LOD policy: how coarse a mip level a lookup reads (CONVENTIONS.md, "LOD")."""

import numpy as np
from jaxtyping import Float

from reflet.envmap.cube import AXES, face_from_direction
from reflet.envmap.mip_chain import MipChain

_SMALLEST_RHO = 1e-6  # keeps the logarithm finite where neighbours coincide


def lod_from_neighbours(
    chain: MipChain, direction: Float[np.ndarray, "3 n 3"], lod_bias: float
) -> Float[np.ndarray, "n"]:
    """LOD of lookups in [0, level_count - 1] from three directions each, of any length.

    The first is the lookup itself, the others those of its neighbours to the right and down. All are projected on the
    face that the first meets; rho is the larger distance, in texels of the finest level. A neighbour behind the face
    plane counts as infinitely far.
    """
    face, s, t = face_from_direction(direction[0])
    rho = np.zeros(face.shape)
    for neighbour in direction[1:]:
        major, a, b = np.moveaxis(np.einsum("nkj,nj->nk", AXES[face], neighbour), -1, 0)
        ahead = major > 0.0
        safe = np.where(ahead, major, 1.0)
        distance = np.hypot(a / safe - s, b / safe - t)
        rho = np.maximum(rho, np.where(ahead, distance, np.inf))
    rho = np.maximum(rho * (0.5 * chain.size), _SMALLEST_RHO)
    return np.clip(np.log2(rho) + lod_bias, 0.0, chain.level_count - 1.0)
