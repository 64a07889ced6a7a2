"""The sRGB transfer function [IEC 61966-2-1]: how PNG, JPEG and glTF's colours encode linear light."""

import numpy as np
from jaxtyping import Float


def linear_from_srgb(encoded: Float[np.ndarray, "*batch"]) -> Float[np.ndarray, "*batch"]:
    """Linear values of codes from 0 to 1."""
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)


def srgb_from_linear(linear: Float[np.ndarray, "*batch"]) -> Float[np.ndarray, "*batch"]:
    """Codes of linear values from 0 to 1, of which 1 is 1."""
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * np.maximum(linear, 0.0) ** (1.0 / 2.4) - 0.055)
