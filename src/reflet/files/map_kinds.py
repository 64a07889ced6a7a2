"""What is said of files whose kind of map is not known, or is another than was said."""

from collections.abc import Sequence

from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.parameterizations.parameterization import Parameterization


def unknown_kind(path: object, what: str, fitting: Sequence[str], may_be_strip: bool = False) -> str:
    """The sentence for a file that is ``what`` ("8×8 pixels") and may hold maps of the ``fitting`` names, or none.

    Or it may be a picture of the whole way around, a strip without top and bottom.
    """
    if fitting:
        return (
            f"{path} is {what}, which does not tell what kind of map it is; say {' or '.join(fitting)} (--from NAME)."
        )
    if may_be_strip:
        return (
            f"{path} is {what}, which is no map of any kind; if it shows the whole way around, but not the top and the "
            "bottom, say latlong (--from latlong): it is put in the middle, black above and below."
        )
    return f"{path} is {what}, which is no map of any kind; lat-long is 2:1, cubes are 6:1, 1:6, 4:3 or 3:4."


def expected_shape(laid_out: Parameterization) -> str:
    """What a map of this kind looks like in a file."""
    if laid_out == CUBE:
        return "a cube is a strip of six squares (6:1, 1:6), a cross (4:3, 3:4) or a cube texture"
    if laid_out.face_count == 2:
        return "it is two squares beside each other (2:1), one below the other, or two layers"
    if laid_out.aspect == 2:
        return "it is twice as wide as high, or wider; cut off what is too much, or leave one of two views"
    return "it is square"
