"""Files for Filament as its own tool, cmgen, makes them: prefiltered cubes with irradiance, and skyboxes, in KTX 1.

**Orientation.** Cubes are looked up along the world's directions, as ours are. A lat-long picture has +z in its middle,
where ours has +x; so pictures are turned by a quarter (`quarter_turned`) and show where cmgen would show them.

**Irradiance** is irradiance/π by nine polynomials of the normal (`polynomial_coefficients`), as text under the key
"sh". cmgen by default damps its bands against ringing, by 4 % and 15 %; ours are whole (`irradiance_sh` says why), and
Filament's shader cuts off what is negative.
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from jaxtyping import Float

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.latlong import LatLong
from reflet.envmap.resampling.resample import resample
from reflet.files.atomic import atomic_write
from reflet.files.textures.env_texture import texture_from_levels
from reflet.files.textures.ktx1 import write_ktx1_texture
from reflet.reflectance.prefilter.irradiance_sh import polynomial_coefficients

_NAMES = ("L00", "L1-1", "L10", "L11", "L2-2", "L2-1", "L20", "L21", "L22")


def quarter_turned(image: EnvImage) -> EnvImage:
    """A lat-long map turned about the vertical such that what was at +x is at +z; other maps as they are."""
    if image.parameterization != LatLong():
        return image
    even = resample(image, LatLong(), image.size + image.size % 2)
    return EnvImage(even.parameterization, np.roll(even.texels, even.size // 2, axis=2))


def write_filament_cube(
    path: Path, levels: Sequence[EnvImage], irradiance: Float[np.ndarray, "9 3"] | None = None
) -> None:
    """Writes a cube's levels as R11G11B10F, with the harmonics of irradiance/π if given (`irradiance_harmonics`).

    Raises RefletError where the file cannot be written.
    """
    texture = texture_from_levels(levels, "r11g11b10f")
    if irradiance is not None:
        rows = "".join(f"{r:.6g} {g:.6g} {b:.6g}\n" for r, g, b in polynomial_coefficients(irradiance))
        texture.metadata["sh"] = rows.encode()
    write_ktx1_texture(path, texture, filament=True)


def write_harmonics_text(path: Path, irradiance: Float[np.ndarray, "9 3"]) -> None:
    """Writes cmgen's sh.txt. Raises RefletError where the file cannot be written."""
    rows = zip(polynomial_coefficients(irradiance), _NAMES, strict=True)
    text = "".join(
        f"({r:18.15f}, {g:18.15f}, {b:18.15f}); // {n}, irradiance, pre-scaled base\n" for (r, g, b), n in rows
    )
    atomic_write(path, text.encode())
