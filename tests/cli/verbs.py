"""Running verbs within this process, and skies for them."""

from pathlib import Path

import numpy as np
import pytest

from reflet.cli.main import main
from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS

LATLONG, CUBE = PARAMETERIZATIONS["latlong"], PARAMETERIZATIONS["cube"]


def reflet(*arguments: str | Path) -> int:
    """Exit status of one command, run within this process."""
    with pytest.raises(SystemExit) as stop:
        main([str(argument) for argument in arguments])
    return stop.value.code or 0


def refused(capsys: pytest.CaptureFixture[str], *arguments: str | Path) -> str:
    """The one sentence that a command is refused with."""
    assert reflet(*arguments) == 2
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1 and lines[0].startswith("reflet: ") and "Traceback" not in lines[0]
    return lines[0]


def sky(direction: np.ndarray) -> np.ndarray:
    x, y, z = np.moveaxis(direction, -1, 0)
    return np.stack([1 + 0.5 * x, 1 + 0.5 * y, 1 + 0.5 * z], -1).astype(np.float32)


def sky_image(name: str, size: int) -> EnvImage:
    to = PARAMETERIZATIONS[name]
    return EnvImage(to, sky(to.texel_directions(size)[0]))
