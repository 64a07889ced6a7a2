"""How far a picture is from its reference, as seen on a display.

All measures compare tone-mapped pictures, ``sRGB(1 - exp(-exposure·radiance))`` in [0, 1], on the pixels of a mask (the
object); a pixel outside the mask counts as black in both pictures, so that the background plays no part. Everything is
computed in float64, but FLIP, whose package works in float32.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, UInt8

from reflet.errors import RefletError

EXPOSURE = 1.6
SSIM_WINDOW = 7  # scikit-image's default: a uniform window of 7×7 pixels
PIXELS_PER_DEGREE = 67.0  # FLIP's default: a 0.7 m wide 4K monitor seen from 0.7 m

Picture = Float[np.ndarray, "height width 3"]
Mask = Bool[np.ndarray, "height width"]
Pictures = Float[np.ndarray, "*views height width 3"]
Masks = Bool[np.ndarray, "*views height width"]
Crop = Float[np.ndarray, "rows columns 3"]


def tone_map(radiance: Float[np.ndarray, "*batch"], exposure: float = EXPOSURE) -> Float[np.ndarray, "*batch"]:
    """Display value in [0, 1] of linear radiance: the sRGB curve of ``1 - exp(-exposure·radiance)``, in float64.

    Negative radiance shows as black.
    """
    linear = -np.expm1(-exposure * np.maximum(np.asarray(radiance, np.float64), 0.0))
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def picture_srgb(radiance: Float[np.ndarray, "*batch"], exposure: float = EXPOSURE) -> UInt8[np.ndarray, "*batch"]:
    """The tone-mapped picture in 8 bits, as it is written into a PNG."""
    return np.round(255.0 * tone_map(radiance, exposure)).astype(np.uint8)


@dataclass(frozen=True)
class SquaredError:
    """Squared errors pooled over pixels, channels and views: their ``total``, and the number of ``values``.

    Add two with ``+`` to pool them.
    """

    total: float = 0.0
    values: int = 0

    def __add__(self, other: "SquaredError") -> "SquaredError":
        return SquaredError(self.total + other.total, self.values + other.values)

    @property
    def psnr(self) -> float:
        """Peak signal-to-noise ratio in dB for values in [0, 1]; infinite where nothing differs."""
        if not self.values:
            raise RefletError("A PSNR needs at least one pixel; the mask is empty.")
        return float(-10.0 * np.log10(self.total / self.values)) if self.total > 0.0 else float("inf")


def squared_error(reference: Pictures, image: Pictures, mask: Masks, exposure: float = EXPOSURE) -> SquaredError:
    """The display-mapped pictures' squared error over the mask's pixels, ready to be pooled with other views'."""
    difference = tone_map(image[mask], exposure) - tone_map(reference[mask], exposure)
    return SquaredError(float(np.sum(difference * difference)), difference.size)


def display_psnr(reference: Pictures, image: Pictures, mask: Masks, exposure: float = EXPOSURE) -> float:
    """Display PSNR in dB: that of the tone-mapped pictures (data range 1) over the mask's pixels.

    Squared errors are pooled over all views given. Infinite for equal pictures; an empty mask raises `RefletError`.
    """
    return squared_error(reference, image, mask, exposure).psnr


def ssim_map(reference: Picture, image: Picture, mask: Mask, exposure: float = EXPOSURE) -> Crop:
    """Structural similarity of the tone-mapped pictures (data range 1, uniform 7×7 window), per pixel and channel.

    The map has the extent of `bounding_box` of the mask.
    """
    a, b = _display_crops(reference, image, mask, exposure)
    from skimage.metrics import structural_similarity  # here, for bakes need none of it: 0.3 s

    _, similarity = structural_similarity(a, b, win_size=SSIM_WINDOW, data_range=1.0, channel_axis=-1, full=True)
    return similarity


def ssim(reference: Picture, image: Picture, mask: Mask, exposure: float = EXPOSURE) -> float:
    """Mean structural similarity over the mask's pixels: 1 for equal pictures, see `ssim_map`."""
    rows, columns = bounding_box(mask)
    return float(ssim_map(reference, image, mask, exposure)[mask[rows, columns]].mean())


def flip_map(
    reference: Picture, image: Picture, mask: Mask, exposure: float = EXPOSURE
) -> Float[np.ndarray, "rows columns"]:
    """FLIP error in [0, 1] of the tone-mapped pictures, at 67 pixels a degree; extent: `bounding_box` of the mask."""
    a, b = _display_crops(reference, image, mask, exposure)
    import flip_evaluator  # likewise

    error, _, _ = flip_evaluator.evaluate(
        a.astype(np.float32),
        b.astype(np.float32),
        "LDR",
        applyMagma=False,
        computeMeanError=False,
        parameters={"ppd": PIXELS_PER_DEGREE},
    )
    return np.asarray(error, np.float64)[..., 0]


def flip(reference: Picture, image: Picture, mask: Mask, exposure: float = EXPOSURE) -> float:
    """Mean FLIP error over the mask's pixels: 0 for equal pictures, see `flip_map`."""
    rows, columns = bounding_box(mask)
    return float(flip_map(reference, image, mask, exposure)[mask[rows, columns]].mean())


def bounding_box(mask: Mask, margin: int = 8) -> tuple[slice, slice]:
    """Rows and columns that hold the mask's pixels and ``margin`` more on each side, within the picture.

    With 8 pixels more, windows and filters of the measures meet the same black beyond the mask as in the full picture:
    half an SSIM window is 3 pixels, FLIP's widest filter at 67 pixels a degree has a standard deviation of 2.
    """
    if not mask.any():
        raise RefletError("No pixel of the picture shows the object; move the camera or choose another target.")
    rows, columns = np.flatnonzero(mask.any(1)), np.flatnonzero(mask.any(0))
    return (
        slice(max(int(rows[0]) - margin, 0), int(rows[-1]) + 1 + margin),
        slice(max(int(columns[0]) - margin, 0), int(columns[-1]) + 1 + margin),
    )


def _display_crops(reference: Picture, image: Picture, mask: Mask, exposure: float) -> tuple[Crop, Crop]:
    """Both pictures tone-mapped within the mask's bounding box, black outside the mask."""
    box = bounding_box(mask)
    inside = mask[box][..., None]
    return (
        np.where(inside, tone_map(reference[box], exposure), 0.0),
        np.where(inside, tone_map(image[box], exposure), 0.0),
    )
