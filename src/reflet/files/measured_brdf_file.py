"""Tables of isotropic BRDFs as .npz archives.

An archive holds four arrays: ``theta_i`` (n), ``theta_o`` (m) and ``delta_phi`` (k), ascending angles in radians, θ
from the normal in [0, π/2] and Δφ between the azimuths of light and viewer in [0, π]; and ``values`` (n, m, k) or
(n, m, k, 1 or 3), the BRDF per steradian, three channels being linear Rec. 709.
"""

import os
import zipfile

import numpy as np

from reflet.errors import RefletError
from reflet.files.atomic import atomic_path
from reflet.files.unreadable import unreadable
from reflet.reflectance.brdfs.measured_brdf import MeasuredBrdf

_ANGLES = ("theta_i", "theta_o", "delta_phi")


def read_measured_brdf(path: str | os.PathLike[str]) -> MeasuredBrdf:
    """The table of a .npz archive. Raises RefletError for files that are missing, damaged, or no such table."""
    try:
        with np.load(path, allow_pickle=False) as archive:
            if {"phi_i", "phi_o"} & set(archive):
                raise RefletError(
                    f"{path} is an anisotropic BRDF: its prefiltered maps would turn with the surface, five dimensions "
                    "in all; average it over the turns of light and viewer about the normal, by their delta_phi."
                )
            missing = [name for name in (*_ANGLES, "values") if name not in archive]
            if missing:
                raise RefletError(f"{path} holds no {', '.join(missing)}; a BRDF table needs all of its four arrays.")
            angles = [np.asarray(archive[name], np.float64).ravel() for name in _ANGLES]
            values = np.asarray(archive["values"], np.float64)
    except OSError as error:
        raise unreadable(path, error) from error
    except (ValueError, EOFError, zipfile.BadZipFile) as error:
        raise RefletError(f"{path} is no .npz archive of arrays, or damaged; check or copy it again.") from error
    return MeasuredBrdf(angles[0], angles[1], angles[2], values[..., None] if values.ndim == 3 else values)


def write_measured_brdf(path: str | os.PathLike[str], table: MeasuredBrdf) -> None:
    """Writes what `read_measured_brdf` reads, values in float32. Raises RefletError as `atomic_path` does."""
    with atomic_path(path) as temporary, temporary.open("wb") as file:
        np.savez_compressed(
            file,
            theta_i=table.theta_i,
            theta_o=table.theta_o,
            delta_phi=table.delta_phi,
            values=table.values.astype(np.float32),
        )
