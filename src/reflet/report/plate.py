"""Plates: pictures in rows and columns under their titles, as one picture."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import UInt8
from matplotlib.font_manager import findfont
from PIL import Image, ImageDraw, ImageFont

INK, PAPER = "#1d1d1f", "#ffffff"
_GAP, _TITLE, _SIZE = 6, 30, 15  # pixels: between pictures, of a row of titles, of letters

Picture = UInt8[np.ndarray, "_ _ 3"]


def plate(
    pictures: Sequence[Sequence[Picture]], columns: Sequence[str] = (), rows: Sequence[str] = ()
) -> UInt8[np.ndarray, "sheet_height sheet_width 3"]:
    """sRGB pictures, row by row, with titles above columns and above rows; either may be missing.

    Pictures of one row have one height, those of one column one width.
    """
    heights, widths = [row[0].shape[0] for row in pictures], [each.shape[1] for each in pictures[0]]
    head, lead = _TITLE * bool(columns), _TITLE * bool(rows)
    height = head + sum(heights) + (lead + _GAP) * len(heights) - _GAP
    sheet = Image.new("RGB", (sum(widths) + _GAP * (len(widths) - 1), height), PAPER)
    draw = ImageDraw.Draw(sheet)
    font = ImageFont.truetype(findfont("DejaVu Sans"), _SIZE)
    lefts = np.cumsum([0] + [width + _GAP for width in widths])
    for title, left, width in zip(columns, lefts, widths, strict=False):
        draw.text((left + width / 2, head / 2), title, INK, font, "mm")
    top = head
    for k, row in enumerate(pictures):
        if rows:
            draw.text((2, top + lead / 2), rows[k], INK, font, "lm")
        top += lead
        for left, picture in zip(lefts, row, strict=False):
            sheet.paste(Image.fromarray(picture), (int(left), top))
        top += heights[k] + _GAP
    return np.asarray(sheet)
