"""The 3-D prefiltered map of Kautz and McCool: an environment filtered with a BRDF's lobes, by direction and n·v.

Each lobe has a slice for each of its view angles, a map prefiltered with the lobe's kernel there; the last dimension is
blended linearly in n·v. Slices are looked up in the direction of the lobe's own axis, blended alike; the diffuse lobe
needs one map, looked up in the normal's direction, and a table.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.parameterization import Parameterization
from reflet.envmap.resampling.resample import radiance_at
from reflet.reflectance.brdfs.lambert import DiffuseKernel
from reflet.reflectance.brdfs.tabulated_kernel import TabulatedKernel
from reflet.reflectance.lobes.lobes import THETA, Lobes
from reflet.reflectance.prefilter.prefilter import Prefilter

_DIFFUSE_SIZE = 32  # rows at most: a cosine lobe has no detail beyond


@dataclass(frozen=True)
class BrdfMap3d:
    """``slices[i]``: the maps of ``lobes.lobes[i]``, one for each of ``lobes.cos_theta_o``; ``diffuse``: irradiance/π.

    Maps have the environment's channels.
    """

    lobes: Lobes
    diffuse: EnvImage
    slices: tuple[tuple[EnvImage, ...], ...]


def brdf_map_3d(
    image: EnvImage,
    lobes: Lobes,
    to: Parameterization,
    size: int,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> BrdfMap3d:
    """The environment filtered with all lobes, in maps of ``size`` rows a face.

    Implements [Heidrich00, eq. 19]. Lobes of three channels filter red, green and blue each with its own kernel.
    ``progress`` hears of maps made, and of all. Raises RefletError for radiance that is negative or not finite.
    """
    environment = Prefilter(image)
    total = 1 + len(lobes.lobes) * len(lobes.cos_theta_o)
    progress(0, total)
    diffuse = environment.map(DiffuseKernel(), to, min(size, _DIFFUSE_SIZE))
    slices, done = [], 1
    for lobe in lobes.lobes:
        maps = []
        for densities in lobe.densities:
            progress(done, total)
            maps.append(_filtered(environment, densities, to, size))
            done += 1
        slices.append(tuple(maps))
    progress(total, total)
    return BrdfMap3d(lobes, diffuse, tuple(slices))


def rows_for(lobes: Lobes, to: Parameterization, at_most: int) -> int:
    """Rows a face, a power of two, such that two texels fit into every lobe's half width."""
    half_width = min((lobe.half_width for lobe in lobes.lobes), default=np.pi)
    size = 8
    while size < at_most and 2.0 * np.sqrt(4.0 * np.pi / np.prod(to.shape(size))) > half_width:
        size *= 2
    return min(size, at_most)


def _filtered(
    environment: Prefilter, densities: Float[np.ndarray, "thetas channels"], to: Parameterization, size: int
) -> EnvImage:
    channels = environment.image.texels.shape[-1]
    texels = np.zeros((*to.shape(size), channels), np.float32)
    of_channel = np.minimum(np.arange(channels), densities.shape[1] - 1)
    for kernel in np.unique(of_channel):
        if densities[:, kernel].max() > 0.0:
            chosen = of_channel == kernel
            filtered = environment.map(TabulatedKernel(THETA, densities[:, kernel]), to, size)
            texels[..., chosen] = filtered.texels[..., chosen]
    return EnvImage(to, texels)


def reflected_radiance(
    maps: BrdfMap3d, normal: Float[np.ndarray, "n 3"], wo: Float[np.ndarray, "n 3"]
) -> Float[np.ndarray, "n channels"]:
    """Radiance towards ``wo`` of surfaces with these unit normals, bilinear in each slice; 0 where n·v ≤ 0."""
    lobes = maps.lobes
    n_dot_v = np.einsum("nk,nk->n", normal, wo)
    at = np.interp(n_dot_v, lobes.cos_theta_o, np.arange(len(lobes.cos_theta_o)))
    below = np.minimum(at.astype(int), len(lobes.cos_theta_o) - 2)
    share = (at - below)[:, None]
    albedo = lobes.diffuse[below] * (1.0 - share) + lobes.diffuse[below + 1] * share
    total = albedo * radiance_at(maps.diffuse, normal)
    for lobe, slices in zip(lobes.lobes, maps.slices, strict=True):
        axis = lobe_axis(normal, wo, lobes.axis_angle(lobe, n_dot_v))
        for k in range(len(slices)):
            for chosen, weight in ((below == k, 1.0 - share), (below + 1 == k, share)):
                if chosen.any():
                    total[chosen] += weight[chosen] * radiance_at(slices[k], axis[chosen])
    return np.asarray(np.where(n_dot_v[:, None] > 0.0, total, 0.0))


def lobe_axis(
    normal: Float[np.ndarray, "n 3"], wo: Float[np.ndarray, "n 3"], axis_angle: Float[np.ndarray, "n"]
) -> Float[np.ndarray, "n 3"]:
    """Unit directions in the plane of incidence, at these angles from the normal towards the mirrored side."""
    away = np.einsum("nk,nk->n", normal, wo)[:, None] * normal - wo
    length = np.linalg.norm(away, axis=-1, keepdims=True)
    tangent = np.divide(away, length, out=np.zeros_like(away), where=length > 1e-9)
    axis = np.cos(axis_angle)[:, None] * normal + np.sin(axis_angle)[:, None] * tangent
    return np.asarray(axis / np.linalg.norm(axis, axis=-1, keepdims=True))
