"""What an env image holds, in a few numbers that do not depend on its parameterization."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from reflet.envmap.compiled_facts import scanned
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

    Texels are weighted by their solid angle. Memory beside the image is small: those of the brightest directions come
    from a histogram with bins 1/2048 wide. Where everything is black, directions are +y and shares 0.
    """
    solid_angle = image.parameterization.texel_solid_angle(image.size)
    weights = LUMINANCE if image.texels.shape[-1] >= 3 else np.ones(1)
    texels = image.texels if image.texels.dtype.itemsize >= 4 else image.texels.astype(np.float32)
    (least, greatest, place, *towards), power, by_luminance = scanned(
        texels, solid_angle, image.parameterization.kind, weights
    )
    total = float(power @ weights)
    length = float(np.linalg.norm(towards))
    face, row, column = np.unravel_index([int(place)], solid_angle.shape)
    _, rows, columns = solid_angle.shape
    uv = np.stack([(column + 0.5) / columns, (row + 0.5) / rows], -1)
    brightest, _ = image.parameterization.direction_from_uv(face, uv)
    return EnvImageFacts(
        least=float(least),
        greatest=float(greatest),
        power=tuple(power.tolist()),
        mean=tuple((power / (4.0 * np.pi)).tolist()),
        flux_of_brightest=_brightest_flux(by_luminance) / total if total > 0.0 else 0.0,
        brightest=_vec3(brightest[0]) if total > 0.0 else (0.0, 1.0, 0.0),
        brightest_radiance=tuple(image.texels[face[0], row[0], column[0], : len(weights)].tolist()),
        dominant=_vec3(np.array(towards) / length) if length > 0.0 else (0.0, 1.0, 0.0),
        directedness=length / total if total > 0.0 else 0.0,
    )


def _brightest_flux(by_luminance: Float[np.ndarray, "bins 2"]) -> float:
    """Flux of the brightest texels that together fill the share of all directions; of the last bin a part."""
    filled, flux = np.cumsum(by_luminance[::-1], 0).T
    return float(np.interp(BRIGHTEST_SHARE * 4.0 * np.pi, np.append(0.0, filled), np.append(0.0, flux)))


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
