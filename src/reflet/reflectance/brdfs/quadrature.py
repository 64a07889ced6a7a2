"""Prefiltering by brute force: the reference.

L(r) = ∫ k(θ)·L(ω) dω, with the environment as it is stored: texel j stands for its exact solid angle Ω_j in the
direction ω_j of its centre. The integral is the sum Σ_j k(r, ω_j)·Ω_j·L_j over *all* texels, in float64. For
normalized kernels it is divided by Σ_j k(r, ω_j)·Ω_j, which tends to 1 as texels shrink against the lobe: a constant
environment stays constant whatever the resolution, and most of the quadrature's error cancels.

The sum knows nothing between texel centres: it is a reference for lobes that are wide against the texels (some three
texels from the lobe's middle to its half height). Memory: some 300 MB whatever the sizes.
"""

import numpy as np
from jaxtyping import Float

from reflet.envmap.env_image import EnvImage
from reflet.errors import RefletError
from reflet.reflectance.brdfs.kernel import Kernel, sine_squared_of_half

_PAIRS = 1 << 22  # of source texels and directions at a time


def filtered_reference(
    image: EnvImage, kernel: Kernel, direction: Float[np.ndarray, "n 3"], normalized: bool = True
) -> Float[np.ndarray, "n channels"]:
    """The environment filtered with ``kernel`` around unit directions; radiance for normalized kernels.

    Implements [Heidrich00, eqs 15, 17, 19] with the kernels of `lambert`, `phong`, `ggx`, `charlie` and
    `tabulated_kernel`. ``normalized=False`` leaves the division out: for kernels that are not normalized, and to see
    the quadrature's own error. Raises RefletError for radiance that is negative or not finite.
    """
    check_radiance(image)
    solid_angle = image.parameterization.texel_solid_angle(image.size).ravel()
    seen = solid_angle > 0.0
    source = image.parameterization.texel_directions(image.size)[0].reshape(-1, 3)[seen]
    flux = image.texels.reshape(-1, image.texels.shape[-1])[seen] * solid_angle[seen, None]
    flux = np.concatenate([flux, solid_angle[seen, None]], -1)
    total = np.zeros((len(direction), flux.shape[1]))
    step_out = min(len(direction), 256)
    step_in = max(_PAIRS // max(step_out, 1), 1)
    for first in range(0, len(direction), step_out):
        out = slice(first, first + step_out)
        for start in range(0, len(source), step_in):
            inside = slice(start, start + step_in)
            total[out] += kernel.density(sine_squared_of_half(direction[out] @ source[inside].T)) @ flux[inside]
    return total[:, :-1] / total[:, -1:] if normalized else total[:, :-1]


def check_radiance(image: EnvImage) -> None:
    """Raises RefletError for radiance that is negative or not finite."""
    if not np.isfinite(image.texels).all():
        raise RefletError(
            "The environment holds radiance that is not finite (NaN or infinite); reflet convert --repair mends it."
        )
    if image.texels.min() < 0.0:
        raise RefletError(
            f"The environment holds negative radiance ({image.texels.min():g}); reflet convert --repair makes it 0."
        )
