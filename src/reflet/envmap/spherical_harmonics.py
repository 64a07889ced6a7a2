"""Real spherical harmonics of functions over directions.

Coefficients are ordered by band l and order m: index l² + l + m. The polar axis is z, signs are those of the
polynomials, without the Condon-Shortley phase: Y₁ is 0.488603·(y, z, x) [Ramamoorthi01, eq. 3].
"""

import numpy as np
from jaxtyping import Float

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.parameterization import Directions, Parameterization

_ROWS = 1 << 18  # texels at a time, about: bounds the memory


def spherical_harmonics(direction: Directions, band_count: int) -> Float[np.ndarray, "*batch harmonics"]:
    """The band_count² real harmonics of bands 0 to band_count - 1 in unit directions, orthonormal over the sphere.

    Y_lm = K_lm·P_l|m|(z)·(sin^|m| θ·cos mφ, or sin |m|φ for m < 0). P_mm = (2m - 1)!!, P_(m+1)m = (2m + 1)·z·P_mm,
    (l - m)·P_lm = (2l - 1)·z·P_(l-1)m - (l + m - 1)·P_(l-2)m; K² = (2l + 1)/4π·(l - m)!/(l + m)!, twice that for m ≠ 0.
    Here P stands for Legendre's function over sin^m θ, a polynomial; sin^m θ·(cos mφ, sin mφ) = Re, Im (x + iy)^m.
    """
    x, y, z = np.moveaxis(direction, -1, 0)
    out = np.empty((*direction.shape[:-1], band_count**2))
    cosine, sine = np.ones_like(x), np.zeros_like(x)
    start = np.sqrt(0.25 / np.pi)  # K_mm·(2m - 1)!!, at first of m = 0
    for m in range(band_count):
        # P times K: the recursion in l with K taken in.
        before, now = np.zeros_like(x), np.full_like(x, start)
        for l in range(m, band_count):
            out[..., l * l + l + m] = now * cosine
            if m > 0:
                out[..., l * l + l - m] = now * sine
            step = np.sqrt((4.0 * (l + 1) ** 2 - 1.0) / ((l + 1) ** 2 - m**2))
            back = np.sqrt((l**2 - m**2) / (4.0 * l**2 - 1.0)) if l > 0 else 0.0
            before, now = now, step * (z * now - back * before)
        # K_(m+1)(m+1)·(2m + 1)!! over K_mm·(2m - 1)!!: sqrt((2m + 3)/(2m + 2)), times sqrt(2) from m = 0 to 1.
        start *= np.sqrt((2.0 * m + 3.0) / (2.0 * m + 2.0) * (2.0 if m == 0 else 1.0))
        cosine, sine = x * cosine - y * sine, x * sine + y * cosine
    return out


def project(image: EnvImage, band_count: int = 3) -> Float[np.ndarray, "harmonics channels"]:
    """Coefficients ∫ L·Y dω of an image, each texel of one radiance all over its valid part.

    The harmonics' mean over a texel is by 2×2 Gauss points, weighted by solid angle.
    """
    parameterization, size = image.parameterization, image.size
    faces, rows, columns = parameterization.shape(size)
    solid_angle = parameterization.texel_solid_angle(size)
    step = max(_ROWS // columns, 1)
    total = np.zeros((band_count**2, image.texels.shape[3]))
    for face in range(faces):
        for first in range(0, rows, step):
            chosen = slice(first, min(first + step, rows))
            flux = image.texels[face, chosen] * solid_angle[face, chosen, :, None]
            harmonics = _texel_means(parameterization, size, face, np.arange(rows)[chosen], band_count)
            total += np.einsum("rch,rck->hk", harmonics, flux, optimize=True)
    return total


def _texel_means(
    parameterization: Parameterization, size: int, face: int, row: np.ndarray, band_count: int
) -> Float[np.ndarray, "rows columns harmonics"]:
    """Means of the harmonics over the valid parts of texels; 0 where there are none."""
    _, rows, columns = parameterization.shape(size)
    total, weights = np.zeros(1), np.zeros(1)
    for down in (-1.0, 1.0):
        for right in (-1.0, 1.0):
            v, u = np.meshgrid(
                (row + 0.5 + down * np.sqrt(1.0 / 12.0)) / rows,
                (np.arange(columns) + 0.5 + right * np.sqrt(1.0 / 12.0)) / columns,
                indexing="ij",
            )
            direction, valid = parameterization.direction_from_uv(np.full(u.shape, face), np.stack([u, v], -1))
            # where the rim leaves no point, any will do
            weight = np.where(valid, 1.0, 1e-12) / parameterization.sampling_rate(direction)
            total = total + weight[..., None] * spherical_harmonics(direction, band_count)
            weights = weights + weight
    return total / weights[..., None]


def radiance_from_harmonics(
    coefficients: Float[np.ndarray, "harmonics channels"], direction: Directions
) -> Float[np.ndarray, "*batch channels"]:
    """The function of these coefficients in unit directions: Σ c·Y. Its ringing may go below 0."""
    band_count = int(np.sqrt(len(coefficients)))
    return np.asarray(spherical_harmonics(direction, band_count) @ coefficients)
