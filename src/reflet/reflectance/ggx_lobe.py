"""Where GGX's lobe points and how wide it is, for lookups in maps that are filtered as if seen along their normal.

The split sum takes n = v = r, and looks up along the mirrored direction r with the material's own roughness. But away
from the normal the lobe of D·V·n·l leans towards n: masking and n·l cut off what is near the horizon. At alpha = 1,
D = 1/π and D·V·n·l = n·l/(2π·(n·l + n·v)) does not know r at all. So we match the lobe's first moment, the mean of l:
its direction says where to look, and its length, the mean cosine to that direction, which of the map's kernels is as
wide. Samples and weights are those of `dfg`.

The kernel's own mean cosine is 1 - ∫ k·2s ds/∫ k ds, s = sin²(θ/2).
"""

from functools import cache

import numpy as np
from jaxtyping import Float

from reflet.reflectance.dfg import half_vector_samples
from reflet.reflectance.ggx import GgxKernel

SAMPLES = 1024
_ALPHAS = np.geomspace(1e-5, 1.0, 129)


def ggx_lobe(n_dot_v: Float[np.ndarray, "views"], alpha: float, samples: int = SAMPLES) -> Float[np.ndarray, "views 2"]:
    """(lean, widening) for n·v in (0, 1) and alpha in [0, 1].

    A map of `GgxKernel` is to be looked up along normalize(mix(r, n, lean)), at widening times the
    perceptual_roughness. Lobes wider than that of alpha = 1 count as that.
    """
    direction, _, weight = half_vector_samples(n_dot_v, alpha, samples)
    mean = (weight[..., None] * direction).sum(-2) / weight.sum(-1)[:, None]
    length = np.linalg.norm(mean, axis=-1)
    # With angles θ from n to r and φ from n to the mean, mix(r, n, lean) points along φ for
    # lean = sin(θ - φ)/(sin(θ - φ) + sin φ).
    sine, cosine = -mean[:, 0] / length, mean[:, 1] / length
    beyond = np.sqrt(1.0 - n_dot_v * n_dot_v) * cosine - n_dot_v * sine
    lean = beyond / (beyond + sine)
    widths = _spreads()
    wide = np.exp(np.interp(np.log(np.maximum(1.0 - length, 1e-12)), np.log(widths), np.log(_ALPHAS)))
    return np.stack([lean, np.sqrt(wide / max(alpha, _ALPHAS[0]))], -1)


@cache
def _spreads() -> Float[np.ndarray, "alphas"]:
    """1 - the mean cosine of `GgxKernel`s, by midpoints in x with s = x⁴/2: half of them where s < 1/32."""
    x = (np.arange(1 << 13) + 0.5) / (1 << 13)
    s = 0.5 * x**4
    density = np.stack([GgxKernel(float(alpha)).density(s) for alpha in _ALPHAS]) * x**3
    return np.asarray((density * 2.0 * s).sum(-1) / density.sum(-1))
