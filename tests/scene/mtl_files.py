"""A square whose material a test writes."""

import warnings
from pathlib import Path

from PIL import Image

from reflet.scene.readers.obj.read import read_obj
from reflet.scene.scene import Part

SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
FACE = "f 1/1 2/2 3/3 4/4\n"


def square(folder: Path, mtl: str) -> tuple[Part, list[str]]:
    """The square of material m, and the warnings."""
    (folder / "a.mtl").write_text(mtl)
    (folder / "a.obj").write_text(f"mtllib a.mtl\n{SQUARE}usemtl m\n{FACE}")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        (part,) = read_obj(folder / "a.obj")
    return part, [str(warning.message) for warning in caught]


def row(path: Path, *pixels: tuple[int, ...]) -> None:
    """A picture of one row, RGB or RGBA."""
    picture = Image.new("RGBA" if len(pixels[0]) == 4 else "RGB", (len(pixels), 1))
    picture.putdata(list(pixels))
    picture.save(path)
