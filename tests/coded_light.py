"""Light to be coded, for tests: smooth, with a sun and its glare, seen partly through."""

import numpy as np

from reflet.envmap.mip_chain import MipChain


def light(chain: MipChain, channels: int, sun: float = 4e4) -> np.ndarray:
    """Texels of a map, float32; the sun is one texel of each level, its glare falls from 50 to nothing about it."""
    levels = []
    for size in chain.level_sizes:
        d = chain.parameterization.texel_directions(size)[0].reshape(-1, 3)
        toward = d @ (0.48, 0.6, 0.64)
        colour = 0.4 + 0.35 * np.sin(d * (3.0, 4.0, 5.0)) + 50.0 * np.exp(60.0 * (toward[:, None] - 1.0))
        colour[toward.argmax()] = sun
        alpha = np.clip(1.5 * d[:, 1:2] + 0.2 * d[:, :1], 0.0, 1.0)
        levels.append(colour if channels == 3 else np.concatenate([alpha * colour, alpha], 1))
    return np.concatenate(levels).astype(np.float32)
