"""Tables of refractive indices in the YAML form of refractiveindex.info: ``tabulated nk`` and ``tabulated n``."""

import os
import re
from pathlib import Path

import numpy as np

from reflet.errors import RefletError
from reflet.files.unreadable import unreadable
from reflet.reflectance.brdfs.spectral import SpectralIndex

# One table: its type, then lines "wavelength n [k]" (µm). The files use no other part of YAML that matters here.
_TABLE = re.compile(r"type: *tabulated (nk|n) *\r?\n *data: *[|>][-+]? *\r?\n((?: +[-+.\deE \t]+(?:\r?\n|$))+)")


def read_spectral_index(path: str | os.PathLike[str]) -> SpectralIndex:
    """n and k over the wavelength (nm) from a file's first table; k = 0 where the file has n alone.

    Raises RefletError for files that are missing, hold no such table, or do not span the visible wavelengths.
    """
    try:
        text = Path(path).read_text(encoding="utf-8")
    except OSError as error:
        raise unreadable(path, error) from error
    except UnicodeDecodeError as error:
        raise RefletError(f"{path} is no text; give a .yml table of refractive indices.") from error
    table = _TABLE.search(text)
    if table is None:
        raise RefletError(f"{path} holds no table of the type 'tabulated nk' or 'tabulated n'; give one that does.")
    columns = 1 + len(table[1])
    rows = [line.split() for line in table[2].splitlines() if line.strip()]
    try:
        numbers = np.array(rows, np.float64).reshape(-1, columns)
    except ValueError as error:
        raise RefletError(f"{path}: every line of the table needs {columns} numbers; repair it.") from error
    k = numbers[:, 2] if columns == 3 else np.zeros(len(numbers))
    return SpectralIndex(1000.0 * numbers[:, 0], numbers[:, 1], k)
