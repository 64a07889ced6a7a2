"""Camera rays of one picture on the device."""

import drjit as dr
import mitsuba as mi
import numpy as np
from jaxtyping import Int32

from reflet.scene.views.camera import Camera
from reflet.scene.views.sample_pattern import sample_positions
from reflet.trace.sampling import LANES, shifted_hammersley, shifted_multiples

# Fractions of 2³² that multiples of spread evenly, in the plane and in space: powers of 1/φ, φ³ = φ + 1 and φ⁴ = φ + 1.
PLANE = 3242174889, 2447445414
SPACE = 3518319155, 2882110345, 2360945575


class CameraRays:
    """Camera rays of one picture. All that changes from view to view is opaque, so that kernels are compiled once."""

    def __init__(self, camera: Camera, spp: int, seed: int | None = 0) -> None:
        """``spp`` antialiasing samples a pixel, shifted for each by ``seed``; if None, they lie as in playback."""
        self.camera, self.spp = camera, spp
        self.positions = None if seed is not None else mi.Point2f(*sample_positions(spp).T.astype(np.float32))
        self.eye = mi.Point3f(*(dr.opaque(mi.Float, float(c)) for c in camera.position))
        self.corner, self.dx, self.dy = (
            mi.Vector3f(*(dr.opaque(mi.Float, float(c)) for c in axis)) for axis in camera.ray_basis()
        )
        self.width = dr.opaque(mi.UInt32, camera.width)
        self.seed = dr.opaque(mi.UInt32, seed or 0)
        self.count = dr.opaque(mi.UInt32, spp)

    def direction(self, pixel, x, y):  # type: ignore[no-untyped-def]
        """Unit directions through points (x, y) of pixels, measured from each pixel's top left corner."""
        row = pixel // self.width
        x, y = mi.Float(pixel - row * self.width) + x, mi.Float(row) + y
        return dr.normalize(self.corner + x * self.dx + y * self.dy)

    def antialiased(self, pixels: Int32[np.ndarray, "pixels"]):  # type: ignore[no-untyped-def]
        """All samples of some pixels, pixel by pixel: their pixels, numbers in the pixel and unit directions."""
        pixel, sample = self._samples(pixels)
        if self.positions is not None:
            return pixel, sample, self.direction(pixel, *dr.gather(mi.Point2f, self.positions, sample))
        return pixel, sample, self.direction(pixel, *shifted_hammersley(sample, self.count, pixel, self.seed))

    def numbers(self, pixels: Int32[np.ndarray, "pixels"]) -> list["mi.Float"]:
        """Five uniform numbers in [0, 1) for all samples of some pixels; the first two and the last three are evenly
        spread over each pixel."""
        pixel, sample = self._samples(pixels)
        return [
            *shifted_multiples(sample, PLANE, pixel, self.seed),
            *shifted_multiples(sample, SPACE, pixel, self.seed),
        ]

    def _samples(self, pixels: Int32[np.ndarray, "pixels"]) -> tuple["mi.UInt32", "mi.UInt32"]:
        lane = dr.arange(mi.UInt32, len(pixels) * self.spp)
        slot = lane // self.count
        return dr.gather(mi.UInt32, mi.UInt32(pixels), slot), lane - slot * self.count

    def batches(self, pixels: Int32[np.ndarray, "pixels"]) -> list[Int32[np.ndarray, "batch"]]:
        """Pixels in groups whose samples are at most `LANES`."""
        step = max(LANES // self.spp, 1)
        return [pixels[start : start + step] for start in range(0, len(pixels), step)]
