"""Pictures in a terminal: a character cell shows two pixels, one above the other."""

import numpy as np
from jaxtyping import Bool, Float
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
    factor = max(int(np.ceil(sheet.shape[1] / columns)), 1)
    sums = [_sums(sheet[row : row + factor], shown[row : row + factor], factor) for row in range(0, len(sheet), factor)]
    weight = np.stack(sums)[..., 3:]
    radiance = np.stack(sums)[..., :3] / np.maximum(weight, 1e-9)
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


def _sums(
    rows: Float[np.ndarray, "rows width channels"], shown: Bool[np.ndarray, "rows width"], factor: int
) -> Float[np.ndarray, "columns 4"]:
    """Radiance and number of the pixels shown in each square of ``factor`` columns; those over the edge count as 0."""
    colors = np.where(shown[..., None], rows[..., :3], 0.0).sum(0, dtype=np.float64)
    line = np.concatenate([np.broadcast_to(colors, (len(shown[0]), 3)), shown.sum(0)[:, None]], -1)
    return np.add.reduceat(line, np.arange(0, len(line), factor))
