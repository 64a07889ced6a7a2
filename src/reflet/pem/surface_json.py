"""A surface layer in JSON: half floats, or whole numbers, radiance on a logarithmic scale of either sign.

Radiance is kept to a relative 1/32 (half a step), and to as much of its mean magnitude where it is smaller: a tenth of
the noise that it was traced with. Red and blue are stored by their codes' differences from green's.
"""

from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float16, Float32, Int16

from reflet.envmap.resampling.spread_light import HALF_MAX
from reflet.pem.arrays import BufferWriter, read_array
from reflet.pem.deflate import Encoding
from reflet.scene.surfaces.surface_layer import SIDES, SurfaceLayer

_STEP = 1.0 / 16.0  # of the logarithms
_ALPHA_STEPS = 128.0


def surface_to_json(surface: SurfaceLayer, buffer: BufferWriter, *, coded: bool) -> dict[str, Any]:
    """Resolutions, offsets, sites and their maps, described; they go into ``buffer``."""
    encoding: Encoding | None = "delta" if coded else None
    out: dict[str, Any] = {
        "side": surface.side,
        "resolution": buffer.add(surface.resolution, encoding),
        "offset": buffer.add(surface.offset, encoding),
        "site": buffer.add(surface.site, encoding),
    }
    if not coded:
        return out | {"light": buffer.add(surface.light.view(np.uint16))}
    light = surface.light.astype(np.float32)
    toe = max(float(np.abs(light[..., :3]).mean(dtype=np.float64)) if light.size else 0.0, 1e-30)
    return out | {"light": {**buffer.add(_codes(light, toe), "delta"), "toe": toe, "step": _STEP}}


def surface_from_json(stored: dict[str, Any], folder: Path, triangles: int) -> SurfaceLayer:
    """The layer that `surface_to_json` described, its arrays read from ``folder``. Raises ValueError where they do not
    belong together."""
    resolution, offset, site = (read_array(folder, stored[name]) for name in ("resolution", "offset", "site"))
    light = read_array(folder, stored["light"])
    if "toe" in stored["light"]:
        light = _light(light, float(stored["light"]["toe"]), float(stored["light"]["step"]))
    else:
        light = light.view(np.float16)
    if stored["side"] not in SIDES or light.shape[1:] != (stored["side"] ** 2, 4):
        raise ValueError(f"maps on surfaces have {SIDES} texels a side, not {stored['side']} in {light.shape}")
    samples = resolution.astype(np.int64) + 1
    ends = offset + np.where(resolution > 0, samples * (samples + 1) // 2, 0)
    if len(resolution) != triangles or ends.max(initial=0) > len(site) or site.max(initial=0) >= max(len(light), 1):
        raise ValueError("its maps on surfaces are those of another scene")
    return SurfaceLayer(resolution, offset, site, light)


def _codes(light: Float32[np.ndarray, "sites texels 4"], toe: float) -> Int16[np.ndarray, "4 texels sites"]:
    """Green, red and blue by their distance from it, alpha; sites, of which neighbours are alike, run fastest."""
    magnitude = np.log1p(np.abs(light[..., :3]) / np.float32(toe))
    red, green, blue = np.moveaxis(np.rint(np.copysign(magnitude, light[..., :3]) / np.float32(_STEP)), -1, 0)
    alpha = np.rint(light[..., 3] * np.float32(_ALPHA_STEPS))
    return np.stack([green, red - green, blue - green, alpha]).transpose(0, 2, 1).astype(np.int16)


def _light(
    codes: Int16[np.ndarray, "4 texels sites"], toe: float, step: float
) -> Float16[np.ndarray, "sites texels 4"]:
    green, red, blue, alpha = codes.transpose(0, 2, 1).astype(np.float64)
    logarithms = step * np.stack([green + red, green, green + blue], -1)
    radiance = np.copysign(toe * np.expm1(np.clip(np.abs(logarithms), 0.0, 80.0)), logarithms)
    both = np.concatenate([radiance, alpha[..., None] / _ALPHA_STEPS], -1)
    return np.clip(both, -HALF_MAX, HALF_MAX).astype(np.float16)
