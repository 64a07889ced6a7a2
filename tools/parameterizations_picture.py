"""The picture of all parameterizations: .venv/bin/python tools/parameterizations_picture.py GALLERY FILE

GALLERY is a folder that examples/parameterizations.py has written. A column for each parameterization: the map, and
mirrors that wear it.
"""

import sys
from pathlib import Path

from PIL import Image, ImageDraw, ImageFont

from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS
from reflet.files.atomic import atomic_path

CELL, GAP, TITLE = 220, 8, 40  # pixels
VIEWS = ("sphere-front", "sphere-aside", "torus-aside")


def picture(gallery: Path) -> Image.Image:
    """Names above, then maps, then mirrors."""
    rows = ("", *(f"-{view}" for view in VIEWS))
    size = (len(PARAMETERIZATIONS) * (CELL + GAP) - GAP, TITLE + len(rows) * (CELL + GAP) - GAP)
    sheet = Image.new("RGB", size, "white")
    draw, font = ImageDraw.Draw(sheet), ImageFont.load_default(19)
    for column, name in enumerate(PARAMETERIZATIONS):
        left = column * (CELL + GAP)
        words = {"latlong": "lat-long"}.get(name, name.replace("_", " "))
        draw.text((left + CELL / 2, TITLE / 2), words, fill="#1d1d1f", font=font, anchor="mm")
        for row, view in enumerate(rows):
            cell = Image.open(gallery / f"{name}{view}.png").convert("RGBA")
            cell.thumbnail((CELL, CELL), Image.Resampling.LANCZOS)
            top = TITLE + row * (CELL + GAP)
            sheet.paste(cell, (left + (CELL - cell.width) // 2, top + (CELL - cell.height) // 2), cell)
    return sheet


if __name__ == "__main__":
    with atomic_path(sys.argv[2]) as temporary:
        picture(Path(sys.argv[1])).save(temporary, format="PNG", optimize=True)
