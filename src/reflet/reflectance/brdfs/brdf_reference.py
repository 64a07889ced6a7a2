"""Environments reflected by whole BRDFs, by brute force: what maps of lobes are held against."""

import numpy as np
from jaxtyping import Float

from reflet.envmap.env_image import EnvImage
from reflet.reflectance.brdfs.brdf import Brdf
from reflet.reflectance.brdfs.quadrature import check_radiance


def reflected_reference(
    image: EnvImage, brdf: Brdf, normal: Float[np.ndarray, "n 3"], wo: Float[np.ndarray, "n 3"]
) -> Float[np.ndarray, "n channels"]:
    """Radiance towards ``wo``: Σ f·max(n·ω, 0)·Ω·L over all texels, in float64; 0 where n·v ≤ 0.

    Implements [Heidrich00, eq. 14], not normalized. Like `quadrature`, it knows nothing between texel centres. Raises
    RefletError for radiance that is negative or not finite. Memory: some 100 bytes a texel.
    """
    check_radiance(image)
    solid_angle = image.parameterization.texel_solid_angle(image.size).ravel()
    seen = solid_angle > 0.0
    direction = image.parameterization.texel_directions(image.size)[0].reshape(-1, 3)[seen]
    light = image.texels.reshape(-1, image.texels.shape[-1])[seen] * solid_angle[seen, None]
    total = np.zeros((len(normal), light.shape[1]))
    for i, (n, v) in enumerate(zip(normal, wo, strict=True)):
        n_dot_l, n_dot_v = direction @ n, float(n @ v)
        above = n_dot_l > 1e-6
        if n_dot_v <= 1e-6:
            continue
        cosine = n_dot_l[above]
        sines = np.sqrt(np.maximum((1.0 - cosine**2) * (1.0 - n_dot_v**2), 1e-30))
        cos_delta_phi = np.clip((direction[above] @ v - cosine * n_dot_v) / sines, -1.0, 1.0)
        values = brdf.evaluate(cosine, np.array([n_dot_v]), cos_delta_phi)
        total[i] = np.einsum("lc,l,lc->c", values, cosine, light[above])
    return total
