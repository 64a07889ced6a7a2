"""All drawings, by name."""

from dataclasses import replace

from reflet.errors import RefletError
from reflet.npr.drawing import Drawing, Overprint
from reflet.npr.gooch import Gooch
from reflet.npr.hatching import Hatching
from reflet.npr.silhouette import Silhouette
from reflet.npr.window import Window

DRAWINGS: dict[str, Window | Gooch | Silhouette | Hatching] = {
    "window": Window(),
    "gooch": Gooch(),
    "silhouette": Silhouette(),
    "hatching": Hatching(),
}
SIZE = 256  # rows of a face: see `drawing` for what they serve


def is_drawing(text: str) -> bool:
    """Whether ``text`` begins like the name of a drawing."""
    return text.partition("+")[0].partition(":")[0] in DRAWINGS


def drawing(text: str, seed: int = 1) -> Drawing:
    """The drawing that ``text`` names, or several printed over one another, such as ``gooch+silhouette:3``.

    What comes after a colon is the width of lines in pixels. ``seed`` chooses how the hand strays. Raises RefletError
    for what is unknown or out of range.
    """
    drawn = tuple(_one(each, seed) for each in text.split("+"))
    return drawn[0] if len(drawn) == 1 else Overprint(drawn)


def _one(text: str, seed: int) -> Drawing:
    name, colon, value = text.partition(":")
    if name not in DRAWINGS:
        raise RefletError(f"Drawings are {', '.join(DRAWINGS)}, or several such as gooch+silhouette; {text!r} is none.")
    plain = DRAWINGS[name]
    if isinstance(plain, Window | Hatching):
        plain = replace(plain, seed=seed)
    if not colon:
        return plain
    if isinstance(plain, Gooch):
        raise RefletError(f"The drawing gooch has no lines, and {text!r} came; write gooch alone.")
    try:
        width = float(value)
    except ValueError as error:
        raise RefletError(f"After the colon comes a width in pixels, such as {name}:2, not {text!r}.") from error
    return replace(plain, width=width)
