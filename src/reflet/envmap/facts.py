"""What an env image holds, in a few numbers that do not depend on its parameterization."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from reflet.envmap.env_image import EnvImage

Vec3 = tuple[float, float, float]

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])  # of linear Rec. 709
BRIGHTEST_SHARE = 1e-4  # of all directions


@dataclass(frozen=True)
class EnvImageFacts:
    """Totals over all directions. Luminance decides what is bright; alpha, where there is one, plays no part."""

    least: float  # over texels and channels
    greatest: float
    power: tuple[float, ...]  # ∫ L dω by channel: radiance times steradian
    mean: tuple[float, ...]  # power / 4π: mean radiance
    flux_of_brightest: float  # share of the power that comes from the brightest 0.01 % of all directions
    brightest: Vec3  # direction of the brightest texel
    brightest_radiance: tuple[float, ...]
    dominant: Vec3  # direction of the mean ∫ L d dω: spherical harmonics of order 1
    directedness: float  # |∫ L d dω| / ∫ L dω: 0 where light comes evenly from all sides, 1 where from one direction


def facts(image: EnvImage) -> EnvImageFacts:
    """The facts of an image with 1, 3 or 4 channels, over the texels that directions lead to.

    Texels are weighted by their solid angle. Where everything is black, directions are +y and shares 0.
    """
    parameterization, size = image.parameterization, image.size
    direction, _ = parameterization.texel_directions(size)
    solid_angle = parameterization.texel_solid_angle(size)
    seen = solid_angle > 0.0
    omega = solid_angle[seen]
    radiance = image.texels[seen][:, : 3 if image.texels.shape[-1] >= 3 else 1].astype(np.float64)
    luminance = radiance @ LUMINANCE if radiance.shape[1] == 3 else radiance[:, 0]
    power = omega @ radiance
    flux = omega * luminance
    total = float(flux.sum())
    brightest = int(np.argmax(luminance))
    towards = flux @ direction[seen]
    length = float(np.linalg.norm(towards))
    return EnvImageFacts(
        least=float(radiance.min()),
        greatest=float(radiance.max()),
        power=tuple(power.tolist()),
        mean=tuple((power / (4.0 * np.pi)).tolist()),
        flux_of_brightest=_brightest_flux(luminance, omega) / total if total > 0.0 else 0.0,
        brightest=_vec3(direction[seen][brightest]) if total > 0.0 else (0.0, 1.0, 0.0),
        brightest_radiance=tuple(radiance[brightest].tolist()),
        dominant=_vec3(towards / length) if length > 0.0 else (0.0, 1.0, 0.0),
        directedness=length / total if total > 0.0 else 0.0,
    )


def _brightest_flux(luminance: Float[np.ndarray, "n"], omega: Float[np.ndarray, "n"]) -> float:
    """Flux of the brightest texels that together fill the share of all directions, the last one in part."""
    order = np.argsort(luminance)[::-1]
    filled = np.concatenate([[0.0], np.cumsum(omega[order])])
    flux = np.concatenate([[0.0], np.cumsum(luminance[order] * omega[order])])
    return float(np.interp(BRIGHTEST_SHARE * 4.0 * np.pi, filled, flux))


def share_of_light(image: EnvImage, at_least: float) -> float:
    """Which part of ∫ luminance dω comes from texels with a colour of at least so much; 0 where all is black.

    Works row by row; colours are taken as finite.
    """
    if not (image.texels[..., :3] >= at_least).any():
        return 0.0
    solid_angle = image.parameterization.texel_solid_angle(image.size)
    part = total = 0.0
    for weight, colors in zip(solid_angle.reshape(-1, solid_angle.shape[2]), _rows(image), strict=True):
        flux = weight * (colors @ LUMINANCE)
        total += float(flux.sum())
        part += float(flux[(colors >= at_least).any(-1)].sum())
    return part / total if total > 0.0 else 0.0


def _rows(image: EnvImage) -> Float[np.ndarray, "rows columns 3"]:
    faces, rows, columns, channels = image.texels.shape
    return image.texels.reshape(faces * rows, columns, channels)[..., :3]


def azimuth_and_elevation(direction: Vec3) -> tuple[float, float]:
    """Degrees: azimuth 0 is +x, 90 is -z, in [0, 360), as a camera's on an orbit; elevation 90 is +y."""
    x, y, z = direction
    return float(np.degrees(np.arctan2(-z, x)) % 360.0), float(np.degrees(np.arctan2(y, np.hypot(x, z))))


def _vec3(values: Float[np.ndarray, "3"]) -> Vec3:
    x, y, z = values.tolist()
    return x, y, z
