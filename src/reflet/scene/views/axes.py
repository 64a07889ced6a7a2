"""Axes of a parameter space as people write them: NAME=FROM:TO:COUNT."""

from math import isfinite

from reflet.errors import RefletError
from reflet.scene.views.parameter_space import VIEW_AXES, Axis

MOST_SAMPLES = 100_000  # along one axis
_TURN_DEG = 360.0
_EXAMPLE = "azimuth_deg=0:360:36"


def axis_from_text(text: str) -> Axis:
    """The axis of evenly spaced coordinates that is written so, first and last among them.

    An azimuth from somewhere to a whole turn further is closed: its last coordinate is the first one, and not counted
    twice. Raises RefletError, in one sentence, for other names than `VIEW_AXES`, and for coordinates that are none.
    """
    name, _, numbers = text.partition("=")
    if name not in VIEW_AXES:
        raise RefletError(f"There is no axis {name!r}; there are {', '.join(VIEW_AXES)}, such as in {_EXAMPLE}.")
    try:
        first, last, count = (
            kind(number) for kind, number in zip((float, float, int), numbers.split(":"), strict=True)
        )
    except ValueError:
        raise RefletError(
            f"An axis has a first and last coordinate and how many there are, such as {_EXAMPLE}, not {text!r}."
        ) from None
    if not (isfinite(first) and isfinite(last) and 1 <= count <= MOST_SAMPLES) or (count > 1) != (last > first):
        raise RefletError(
            f"The axis {text} has no coordinates: it needs 1 to {MOST_SAMPLES}, one alone from and to the same number, "
            "others from a smaller to a greater one."
        )
    turn = name == "azimuth_deg" and count > 1 and abs(last - first - _TURN_DEG) < 1e-6
    if name == "azimuth_deg" and last - first > _TURN_DEG and not turn:
        raise RefletError(f"The axis {text} is more than a turn; give azimuths from one to at most 360° further.")
    if name == "elevation_deg" and not -90.0 <= first <= last <= 90.0:
        raise RefletError(f"The axis {text} leaves the heavens; give elevations from -90° to 90°.")
    if name == "distance" and first <= 0.0:
        raise RefletError(f"The axis {text} begins in the middle of the object; give distances above 0 m.")
    step = (last - first) / max(count if turn else count - 1, 1)
    values = tuple(first + number * step for number in range(count))
    return Axis(name, values, _TURN_DEG if turn else None)
