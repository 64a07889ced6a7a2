"""A scene's light as a bake can hold it: its maps, and what draws them, are half floats."""

import warnings
from dataclasses import replace

import numpy as np

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.latlong import LatLong
from reflet.envmap.resampling.spread_light import HALF_MAX, held, percent
from reflet.errors import RefletError, RefletWarning
from reflet.scene.material import EnvironmentLight
from reflet.scene.scene import Scene


def with_holdable_light(scene: Scene) -> Scene:
    """The scene with light of its environment that is too bright for half floats spread (`spread_light`).

    Tracing, playback and comparisons see the same environment then. Parts that glow brighter than that are kept, for
    what they light is right; a RefletWarning says what share of their light mirrors miss. Raises RefletError for an
    environment with radiance that is negative or not finite.
    """
    for part in scene.parts:
        glow = np.asarray(part.material.emission, np.float64)
        if glow.max() > HALF_MAX:
            missed = np.maximum(glow - HALF_MAX, 0.0).sum() / glow.sum()
            warnings.warn(
                f"{part.name} glows brighter than mirrors can show ({HALF_MAX:.0f}): up to {percent(float(missed))} of "
                "its light is missing in them. Dim it, and all other lights with it.",
                RefletWarning,
                stacklevel=3,
            )
    if scene.environment is None:
        return scene
    radiance = scene.environment.radiance
    if not (np.isfinite(radiance).all() and radiance.min() >= 0.0):
        raise RefletError(
            "The environment holds radiance that is negative, infinite or not a number; mend its file by "
            "reflet convert IN OUT --repair."
        )
    (image,) = held([EnvImage(LatLong(), radiance[None])], HALF_MAX, "a bake")
    return replace(scene, environment=EnvironmentLight(image.texels[0]))
