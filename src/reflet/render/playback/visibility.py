"""What the rasterizer sees: the triangle of every sub-sample."""

import numpy as np

from reflet.render.playback.renderer import Renderer
from reflet.scene.surfaces.visibility import Visibility
from reflet.scene.views.camera import Camera


def rasterized_visibility(renderer: Renderer, camera: Camera, sample_count: int) -> Visibility:
    """The sub-samples of a picture that see reflective parts, found by drawing triangle numbers."""
    pixels, sub_samples, triangles = [], [], []
    for k in range(sample_count):
        seen = renderer.visible_triangles(camera, sample_count, k).ravel()
        sees = np.flatnonzero(seen)
        pixels.append(sees.astype(np.int32))
        sub_samples.append(np.full(len(sees), k, np.int32))
        triangles.append(seen[sees] - np.uint32(1))
    pixel, sub_sample, triangle = (np.concatenate(each) for each in (pixels, sub_samples, triangles))
    order = np.argsort(pixel, kind="stable")  # sub-samples of a pixel are in order already
    return Visibility(camera, sample_count, pixel[order], sub_sample[order], triangle[order])
