"""Irradiance in JSON: mesh colours as floats, or as whole numbers on a logarithmic scale in a few bits each.

Greens are kept to a relative 1/256 (half a step), reds and blues, by their distance from what green became, to 1/128:
less than half of one of the display's 256 steps, and well below traced noise, which costs most of the bits. Far below
the mean the scale becomes linear, down to an exact 0. Gradients are stored by their ratio to the luminance, to half a
step: 0.008 of small ones, a relative 1/32 of large ones, which normals 20° from the interpolated one count a third of.
"""

from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float32, Int16

from reflet.pem.arrays import BufferWriter, read_array
from reflet.pem.deflate import Encoding
from reflet.scene.surfaces.irradiance import IrradianceMap

_STEP, _TINT_STEP = 1.0 / 128.0, 1.0 / 64.0  # of the logarithms
_TOE = 2.0**-10  # of the mean: below it the scale is linear
_BEND_STEP, _BEND_TOE = 1.0 / 16.0, 1.0 / 4.0  # of ratios' logarithms, and where their scale becomes linear
_LUMINANCE = np.array([0.2126, 0.7152, 0.0722], np.float32)


def irradiance_to_json(irradiance: IrradianceMap, buffer: BufferWriter, *, coded: bool) -> dict[str, Any]:
    """Resolutions, offsets, colours and gradients, described; they go into ``buffer``."""
    encoding: Encoding | None = "delta" if coded else None
    out: dict[str, Any] = {
        "resolution": buffer.add(irradiance.resolution, encoding),
        "offset": buffer.add(irradiance.offset, encoding),
    }
    bent = bool(irradiance.gradient.any())
    if irradiance.visibility.size:
        out["visibility"] = buffer.add(irradiance.visibility, encoding)
    if not coded:
        gradient = {"gradient": buffer.add(irradiance.gradient)} if bent else {}
        return out | {"radiosity": buffer.add(irradiance.radiosity)} | gradient
    toe = max(float(irradiance.radiosity.mean(dtype=np.float64)) * _TOE, 1e-30) if irradiance.radiosity.size else 1.0
    codes = _codes(irradiance.radiosity, toe)
    out["radiosity"] = {**buffer.add(codes, "delta"), "toe": toe, "step": _STEP, "tintStep": _TINT_STEP}
    if bent:
        codes = _bend_codes(irradiance.gradient, irradiance.radiosity @ _LUMINANCE)
        out["gradient"] = {**buffer.add(codes, "delta"), "toe": _BEND_TOE, "step": _BEND_STEP}
    return out


def irradiance_from_json(stored: dict[str, Any], folder: Path) -> IrradianceMap:
    """The irradiance that `irradiance_to_json` described, its arrays read from ``folder``. Raises ValueError where they
    do not belong together."""
    radiosity = read_array(folder, stored["radiosity"])
    if "toe" in stored["radiosity"]:
        radiosity = _radiosity(radiosity, *(float(stored["radiosity"][name]) for name in ("toe", "step", "tintStep")))
    grids = read_array(folder, stored["resolution"]), read_array(folder, stored["offset"])
    visibility = {"visibility": read_array(folder, stored["visibility"])} if "visibility" in stored else {}
    if "gradient" not in stored:
        return IrradianceMap(*grids, radiosity, **visibility)
    gradient = read_array(folder, stored["gradient"])
    if "toe" in stored["gradient"]:
        scale = (float(stored["gradient"][name]) for name in ("toe", "step"))
        gradient = _gradient(gradient, radiosity @ _LUMINANCE, *scale)
    if gradient.shape != radiosity.shape:
        raise ValueError(f"it has irradiance of shape {radiosity.shape} and gradients of shape {gradient.shape}")
    return IrradianceMap(*grids, radiosity, gradient, **visibility)


def _codes(radiosity: Float32[np.ndarray, "samples 3"], toe: float) -> Int16[np.ndarray, "3 samples"]:
    """Green, then red and blue by their distance from what green became."""
    red, green, blue = np.log1p(radiosity.T.astype(np.float64) / toe)
    code = np.rint(green / _STEP)
    tints = [np.rint((other - code * _STEP) / _TINT_STEP) for other in (red, blue)]
    return np.clip([code, *tints], -(2**15), 2**15 - 1).astype(np.int16)


def _radiosity(
    codes: Int16[np.ndarray, "3 samples"], toe: float, step: float, tint_step: float
) -> Float32[np.ndarray, "samples 3"]:
    green = codes[0] * step
    logarithms = np.stack([green + codes[1] * tint_step, green, green + codes[2] * tint_step], axis=1)
    return (toe * np.expm1(np.clip(logarithms, 0.0, 80.0))).astype(np.float32)


def _bend_codes(
    gradient: Float32[np.ndarray, "samples 3"], luminance: Float32[np.ndarray, "samples"]
) -> Int16[np.ndarray, "3 samples"]:
    """Of ratios, 0 where there is no light."""
    ratio = gradient / np.maximum(luminance, 1e-30)[:, None]
    code = np.copysign(np.log1p(np.abs(ratio) / _BEND_TOE) / _BEND_STEP, gradient)
    return np.rint(np.clip(code, -(2**15), 2**15 - 1)).astype(np.int16).T


def _gradient(
    codes: Int16[np.ndarray, "3 samples"], luminance: Float32[np.ndarray, "samples"], toe: float, step: float
) -> Float32[np.ndarray, "samples 3"]:
    logarithms = codes.T * step
    ratio = np.copysign(toe * np.expm1(np.clip(np.abs(logarithms), 0.0, 80.0)), logarithms)
    return (ratio * luminance[:, None]).astype(np.float32)
