"""Layers put together again. Imports nothing heavy."""

import numpy as np
from jaxtyping import Float32

from reflet.trace.layers import SegmentedLayers

Radiance = Float32[np.ndarray, "height width 3"]


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


def object_radiance(layers: SegmentedLayers) -> tuple[Radiance, Float32[np.ndarray, "height width"]]:
    """Radiance of the object alone, mean over what covers each pixel, and that coverage."""
    return _mean_over_parts(layers, layers.diffuse + layers.combined)


def object_under_distant(layers: SegmentedLayers, distant: Radiance) -> Radiance:
    """The object with its traced local layer over a distant layer that comes from maps."""
    seen = distant.reshape(-1, 3)[layers.pixel]
    values = layers.diffuse + layers.fresnel * (layers.local + (1.0 - layers.alpha[:, None]) * seen)
    return _mean_over_parts(layers, values)[0]


def _mean_over_parts(
    layers: SegmentedLayers, values: Float32[np.ndarray, "rows 3"]
) -> tuple[Radiance, Float32[np.ndarray, "height width"]]:
    """Per pixel, the mean of the rows' values by coverage, and the sum of the coverages."""
    height, width = layers.surroundings.shape[:2]
    coverage = np.bincount(layers.pixel, layers.coverage, height * width)
    sums = [np.bincount(layers.pixel, layers.coverage * values[:, channel], height * width) for channel in range(3)]
    radiance = np.stack(sums, -1) / np.maximum(coverage, 1e-9)[:, None]
    return (
        radiance.astype(np.float32).reshape(height, width, 3),
        coverage.astype(np.float32).reshape(height, width),
    )
