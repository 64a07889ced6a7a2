"""Analytic env maps, and what a mirror sphere shows of them."""

from collections.abc import Callable

import numpy as np

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.parameterization import Parameterization
from reflet.scene.views.camera import Camera

Radiance = Callable[[np.ndarray], np.ndarray]

# Linear in the direction, every axis and sign told apart; between 0.1 and 0.9.
SLOPES = np.array([[0.3, 0.0, -0.1], [0.0, 0.25, 0.2], [0.1, -0.2, 0.2]])


def linear(direction: np.ndarray) -> np.ndarray:
    """Radiance of unit directions."""
    return 0.5 + direction @ SLOPES


def analytic_levels(
    parameterization: Parameterization, size: int, radiance: Radiance = linear, dtype: type = np.float32
) -> tuple[EnvImage, ...]:
    """Texels of every level hold the radiance at their centres."""
    sizes = [size >> level for level in range(size.bit_length())]
    directions = [parameterization.texel_directions(each)[0] for each in sizes]
    return tuple(EnvImage(parameterization, radiance(direction).astype(dtype)) for direction in directions)


def view_rays(camera: Camera) -> np.ndarray:
    """Unit rays through the pixels' centres, (height, width, 3)."""
    corner, dx, dy = camera.ray_basis()
    x, y = np.meshgrid(np.arange(camera.width) + 0.5, np.arange(camera.height) + 0.5)
    ray = corner + x[..., None] * dx + y[..., None] * dy
    return ray / np.linalg.norm(ray, axis=-1, keepdims=True)


def sphere_reflections(camera: Camera) -> tuple[np.ndarray, np.ndarray]:
    """Directions mirrored by the unit sphere, and the cosine of the angle to its normal; NaN beside it."""
    ray, eye = view_rays(camera), np.asarray(camera.position)
    b = ray @ eye
    with np.errstate(invalid="ignore"):
        t = -b - np.sqrt(b * b - eye @ eye + 1.0)
    n = eye + t[..., None] * ray
    cosine = -np.einsum("...i,...i->...", ray, n)
    return ray + 2.0 * cosine[..., None] * n, cosine
