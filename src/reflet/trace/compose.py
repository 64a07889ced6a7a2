"""Layers put together again. Imports nothing heavy."""

import numpy as np
from jaxtyping import Float32

from reflet.trace.layers import SegmentedLayers


def compose(layers: SegmentedLayers) -> Float32[np.ndarray, "height width 3"]:
    """The ordinary picture: surroundings, diffuse light, and reflections combined sample by sample."""
    image = layers.surroundings.reshape(-1, 3).astype(np.float64)
    np.add.at(image, layers.pixel, layers.coverage[:, None].astype(np.float64) * (layers.diffuse + layers.combined))
    return image.astype(np.float32).reshape(layers.surroundings.shape)


def object_coverage(layers: SegmentedLayers) -> Float32[np.ndarray, "height width"]:
    """Share of each pixel's samples that see a reflective part."""
    height, width = layers.surroundings.shape[:2]
    share = np.bincount(layers.pixel, layers.coverage, height * width)
    return share.astype(np.float32).reshape(height, width)
