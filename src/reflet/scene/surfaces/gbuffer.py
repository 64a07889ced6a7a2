"""The G-buffer: what a shader knows where it looks a map up."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float32, Int32, UInt32


@dataclass(frozen=True)
class Lookups:
    """Weighted lookups of one kind, each for the sub-sample ``sample`` it contributes to.

    ``position`` and ``direction`` hold three rays each: the sample's own mirrored ray, and those a quarter of a pixel
    to the right and down on the same triangle's plane, from which the LOD follows. Directions are unit vectors, of
    rough surfaces along their lobe's peak. ``spread`` is the lobe's (`reflet.envmap.lod.lobe_spread`), 0 of mirrors:
    the LOD is the larger one of both.
    """

    sample: Int32[np.ndarray, "lookups"]
    weight: Float32[np.ndarray, "lookups"]
    position: Float32[np.ndarray, "3 lookups 3"]
    direction: Float32[np.ndarray, "3 lookups 3"]
    spread: Float32[np.ndarray, "lookups"]


@dataclass(frozen=True)
class GBuffer:
    """Rows (pixel × part) of a picture, the sub-samples they average, and each sub-sample's lookups.

    A row's value is the mean over its sub-samples. ``row_of_sample`` is increasing; ``triangle`` numbers the scene's
    triangles, ``roughness`` is the perceptual one there, 0 of mirrors, ``mirrored`` the unit mirrored ray, which does
    not lean as a lobe's peak does. Today every sub-sample has one lookup of weight 1; second bounces and filter taps
    will add more.
    """

    row_pixel: Int32[np.ndarray, "rows"]
    row_part: Int32[np.ndarray, "rows"]
    row_of_sample: Int32[np.ndarray, "samples"]
    triangle: UInt32[np.ndarray, "samples"]
    roughness: Float32[np.ndarray, "samples"]
    mirrored: Float32[np.ndarray, "samples 3"]
    lookups: tuple[Lookups, ...]
