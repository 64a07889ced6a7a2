"""Lights without extent on the device: `shaders/highlights.wgsl` describes them."""

import numpy as np
from jaxtyping import UInt32

from reflet.scene.punctual_light import packed
from reflet.scene.scene import Scene
from reflet.scene.surfaces.irradiance import IrradianceMap


def lit(scene: Scene, irradiance: IrradianceMap) -> int:
    """How many lights rough parts show: none where it is not known which samples see them."""
    return len(scene.lights) if irradiance.visibility.size else 0


def light_words(scene: Scene, irradiance: IrradianceMap) -> UInt32[np.ndarray, "places 4"]:
    """Their number, the lights, and the share of each that is seen from the samples of mesh colours."""
    count = lit(scene, irradiance)
    lights = packed(scene.lights[:count]).reshape(-1, 4).view(np.uint32)
    seen = np.pad(irradiance.visibility.reshape(-1), (0, -irradiance.visibility.size % 16))
    return np.concatenate([np.array([[count, 0, 0, 0]], np.uint32), lights, seen.view(np.uint32).reshape(-1, 4)])
