"""Where GGX's lobe points and how wide it is, for lookups in maps that are filtered as if seen along their normal.

The split sum takes n = v = r, and looks up along the mirrored direction r with the material's own roughness. But away
from the normal the lobe of D·V·n·l leans towards n: masking and n·l cut off what is near the horizon. At alpha = 1,
D = 1/π and D·V·n·l = n·l/(2π·(n·l + n·v)) does not know r at all. So we match a moment of the lobe. With
s = sin²(γ/2), γ from a direction c to l, c is where the mean of s^q is least, and the map's kernel to take is the one
with the same mean, ∫ k·s^q ds/∫ k ds. Samples and weights are those of `dfg`.

**q** = (1 + perceptual_roughness)/2. With q = 1 this is the first moment, c the mean direction and 1 - 2s the mean
cosine: right for the roughest surfaces, where all there is to see is how light is shared out over the hemisphere. But
GGX's tails are so long that the narrower the lobe, the more of the mean of s comes from light far away from it, and
the lobe that is seen gets too wide. With q = 1/2, the mean chord, tails count no more than what is in the middle.
"""

from functools import cache

import numpy as np
from jaxtyping import Float

from reflet.reflectance.brdfs.dfg import half_vector_samples
from reflet.reflectance.brdfs.ggx import GgxKernel

SAMPLES = 1024
_ALPHAS = np.geomspace(1e-5, 1.0, 129)
_STEPS = 8  # towards the least mean: what is left is hundredths of the lobe's width at grazing angles, less elsewhere
_LEAST = 1e-12  # of s


def moment(alpha: float) -> float:
    """q of the module."""
    return 0.5 + 0.5 * float(np.sqrt(alpha))


def ggx_lobe(n_dot_v: Float[np.ndarray, "views"], alpha: float, samples: int = SAMPLES) -> Float[np.ndarray, "views 2"]:
    """(lean, widening) for n·v in (0, 1) and alpha in [0, 1].

    A map of `GgxKernel` is to be looked up along normalize(mix(r, n, lean)), at widening times the
    perceptual_roughness. Lobes wider than that of alpha = 1 count as that.
    """
    q = moment(alpha)
    light, _, weight = half_vector_samples(n_dot_v, alpha, samples)
    weight = weight / weight.sum(-1, keepdims=True)
    sin_v = np.sqrt(1.0 - n_dot_v * n_dot_v)
    axis = np.stack([-sin_v, n_dot_v], -1)
    # Where the gradient of the mean vanishes, c is along the mean of s^(q - 1)·l: Weiszfeld's iteration, with longer
    # steps the smaller q is.
    for _ in range(_STEPS):
        pull = weight * _s(light, axis) ** (q - 1.0)
        towards = _unit((pull[..., None] * light).sum(-2))
        axis = _unit(axis + (towards - axis) / q)
    # With angles θ from n to r and φ from n to c, mix(r, n, lean) points along φ for
    # lean = sin(θ - φ)/(sin(θ - φ) + sin φ).
    sine, cosine = -axis[:, 0], axis[:, 1]
    beyond = sin_v * cosine - n_dot_v * sine
    lean = beyond / (beyond + sine)
    mean = (weight * _s(light, axis) ** q).sum(-1)
    s, share = _kernels()
    wide = np.exp(np.interp(np.log(np.maximum(mean, _LEAST)), np.log(share @ s**q), np.log(_ALPHAS)))
    return np.stack([lean, np.sqrt(wide / max(alpha, _ALPHAS[0]))], -1)


def _unit(vector: Float[np.ndarray, "views 2"]) -> Float[np.ndarray, "views 2"]:
    return np.asarray(vector / np.linalg.norm(vector, axis=-1, keepdims=True))


def _s(
    light: Float[np.ndarray, "views samples 2"], axis: Float[np.ndarray, "views 2"]
) -> Float[np.ndarray, "views samples"]:
    return np.maximum(0.5 - 0.5 * np.einsum("vsk,vk->vs", light, axis), _LEAST)


@cache
def _kernels() -> tuple[Float[np.ndarray, "points"], Float[np.ndarray, "alphas points"]]:
    """Midpoints in x with s = x⁴/2, half of them where s < 1/32, and what `GgxKernel`s have there, with sum 1."""
    x = (np.arange(1 << 13) + 0.5) / (1 << 13)
    s = 0.5 * x**4
    density = np.stack([GgxKernel(float(alpha)).density(s) for alpha in _ALPHAS]) * x**3
    return s, density / density.sum(-1, keepdims=True)
