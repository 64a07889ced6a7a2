"""The prior of inference: an object's static env map, laid out as the map that is inferred."""

import numpy as np
from jaxtyping import Float, Float32

from reflet.envmap.env_image import EnvImage
from reflet.envmap.lod import roughness_of_level
from reflet.envmap.mip_chain import MipChain
from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.resampling.mip_reduction import halved
from reflet.envmap.texture_filter import sample
from reflet.reflectance.brdfs.ggx import GgxKernel
from reflet.reflectance.prefilter.prefilter import Prefilter

_MIRRORING = 0.5  # of a level's roughness: smoother surfaces see it as it is
_NEARER = 1  # levels finer than the mean one that a lobe reads, where what it sees is far away
_AT_ONCE = 1 << 16  # lookups: bounds the memory to some tens of MB


def lobe_levels(
    cube: MipChain, texels: Float32[np.ndarray, "texels channels"], least_roughness: float, most_roughness: float = 1.0
) -> Float32[np.ndarray, "texels channels"]:
    """A static cube for rough surfaces: each mip level is what level 0 holds, filtered with GGX of the roughness whose
    lookups read it (`roughness_of_level`); premultiplied radiance and alpha alike.

    Levels that only narrower lobes than those of ``least_roughness`` read stay as they are, and all do where it is so
    small that level 0 is as good as a mirror's. What reads levels of wider lobes than those of ``most_roughness`` are
    not lobes, but pixels that see much: such levels are means of the finer ones.
    """
    roughness = [roughness_of_level(level, cube.size) for level in range(cube.level_count)]
    if mirrors(cube, least_roughness):
        return texels
    read = max(int(np.searchsorted(roughness, least_roughness, side="right")) - 1, 0)
    first = max(read - _NEARER, min(read, 1))  # level 0 costs as much as all others, and few lookups would read it
    out, prefilter = texels.copy(), Prefilter(EnvImage(CUBE, cube.level(texels, 0)))
    for level in range(first, cube.level_count):
        if level > first and roughness[level - 1] >= most_roughness:
            cube.level(out, level)[:] = halved(CUBE, cube.level(out, level - 1))
            continue
        kernel = GgxKernel((roughness[level] if level else min(roughness[0], least_roughness)) ** 2)
        cube.level(out, level)[:] = prefilter.map(kernel, CUBE, cube.level_sizes[level]).texels
    return out


def mirrors(cube: MipChain, perceptual_roughness: float) -> bool:
    """Whether lobes of a roughness see level 0 of a cube as mirrors do."""
    return perceptual_roughness < _MIRRORING * roughness_of_level(0, cube.size)


def prior_texels(
    cube: MipChain,
    texels: Float32[np.ndarray, "cube_texels channels"],
    chain: MipChain,
    map_from_world: Float[np.ndarray, "3 3"],
) -> Float32[np.ndarray, "texels channels"]:
    """A static env map, a cube with all its mip levels, as a map of ``chain``, whose frame ``map_from_world`` gives.

    Each texel of each level is a trilinear lookup in its own direction, at the LOD where the cube's texels see the same
    solid angle: four times as much a level. Cubes of one size are handed through.
    """
    if chain == cube:
        return texels
    out = np.empty((chain.texel_count, texels.shape[1]), np.float32)
    for mip_level, size in enumerate(chain.level_sizes):
        in_map, _ = chain.parameterization.texel_directions(size)
        in_map = in_map.reshape(-1, 3)
        level = chain.level(out, mip_level).reshape(-1, texels.shape[1])
        for start in range(0, len(in_map), _AT_ONCE):
            some = slice(start, start + _AT_ONCE)
            direction = in_map[some] @ map_from_world  # its transpose, from the left
            finer = cube.parameterization.sampling_rate(direction) * cube.size**2
            coarser = chain.parameterization.sampling_rate(in_map[some]) * size**2
            lod = np.clip(0.5 * np.log2(finer / coarser), 0.0, cube.level_count - 1.0)
            level[some] = sample(cube, texels, direction, lod)
    return out
