"""Pictures in a terminal: a character cell shows two pixels, one above the other."""

import numpy as np
from jaxtyping import Float
from rich.color import Color
from rich.style import Style
from rich.text import Text

from reflet.envmap.env_image import EnvImage
from reflet.envmap.facts import LUMINANCE
from reflet.report.flat_sheet import flat_sheet
from reflet.report.measures import EXPOSURE, picture_srgb

UPPER_HALF, LOWER_HALF = "▀", "▄"
MIDDLE_GREY = 0.18  # what the median luminance is brought to, so that dark and bright environments show alike


def terminal_picture(image: EnvImage, columns: int) -> Text:
    """The image laid flat and tone-mapped, at most ``columns`` characters wide, a line of text for two rows of pixels.

    Exposure is such that the median luminance over what is shown becomes a middle grey. The text carries 24-bit
    colours, which the console brings down to what a terminal has; what no direction leads to is left blank.
    """
    sheet, shown = flat_sheet(image)
    radiance = sheet[..., :3] if sheet.shape[-1] >= 3 else np.repeat(sheet[..., :1], 3, -1)
    factor = max(int(np.ceil(sheet.shape[1] / columns)), 1)
    weight = _blocks(shown[..., None].astype(np.float64), factor)
    radiance = _blocks(np.where(shown[..., None], radiance, 0.0), factor) / np.maximum(weight, 1e-9)
    visible = weight[..., 0] > 0.5 * factor**2
    median = float(np.median(radiance[visible] @ LUMINANCE))
    pixels = picture_srgb(radiance, EXPOSURE * MIDDLE_GREY / median if median > 0.0 else EXPOSURE)
    if len(pixels) % 2:
        pixels, visible = np.pad(pixels, ((0, 1), (0, 0), (0, 0))), np.pad(visible, ((0, 1), (0, 0)))
    text = Text(no_wrap=True)
    for row in range(0, len(pixels), 2):
        for column in range(pixels.shape[1]):
            upper, lower = (
                Color.from_rgb(*pixels[r, column].tolist()) if visible[r, column] else None for r in (row, row + 1)
            )
            if upper is not None:
                text.append(UPPER_HALF, Style(color=upper, bgcolor=lower))
            else:
                text.append(LOWER_HALF if lower is not None else " ", Style(color=lower))
        text.append("\n")
    return text


def _blocks(
    pixels: Float[np.ndarray, "height width channels"], factor: int
) -> Float[np.ndarray, "rows columns channels"]:
    """Sums over squares of ``factor``² pixels; those over the edge count as 0."""
    height, width, channels = pixels.shape
    padded = np.pad(pixels, ((0, -height % factor), (0, -width % factor), (0, 0)))
    rows, columns = padded.shape[0] // factor, padded.shape[1] // factor
    return padded.reshape(rows, factor, columns, factor, channels).sum((1, 3), dtype=np.float64)
