"""The shadow of a model on the ground, under an environment: how much of its light each place lacks.

Light of the environment is stood for by the same thousand directions at every place, drawn by its luminance and the
cosine, so that the shadow is as smooth as the light is even, without noise. It is found on a coarse grid first, and
finely where that is not even.
"""

from dataclasses import replace

import drjit as dr
import mitsuba as mi
import numpy as np
from jaxtyping import Bool, Float, Float32
from scipy.ndimage import maximum_filter, minimum_filter, zoom

from reflet.envmap.facts import LUMINANCE
from reflet.scene.material import COAT_F0, EnvironmentLight, Material
from reflet.scene.scene import Part, Scene
from reflet.trace.device_scene import DeviceScene
from reflet.trace.light.holes import blocked
from reflet.trace.sampling import LANES, R2
from reflet.trace.variant import use_variant

DIRECTIONS = 1024
COARSE = 4  # texels of the fine grid along a coarse one's
EVEN = 1.0 / 255.0  # less is no change


def floor_shadow(
    scene: Scene, corners: Float[np.ndarray, "rows columns 3"], within: Bool[np.ndarray, "size size"]
) -> Float32[np.ndarray, "size size"]:
    """The share, from 0 to 1, of the environment's light on the free ground that each texel lacks; exactly 0 where
    nothing stands before any of it, and where a texel is not ``within``.

    ``corners`` of the texels are places in the scene, one row and one column more than texels. Light counts by its
    luminance. What is blended lets its share through, and glass what it transmits, straight on. The same scene gives
    the same shadow. Sides are multiples of `COARSE`.
    """
    if scene.environment is None:
        raise ValueError("no environment")
    use_variant()
    device = DeviceScene(replace(scene, parts=tuple(map(_letting_through, scene.parts))))
    ways = _ways(scene.environment)
    size = len(within)
    if ways is None:
        return np.zeros((size, size), np.float32)
    few = corners[::COARSE, ::COARSE]
    some = np.asarray(within.reshape(size // COARSE, COARSE, -1, COARSE).any(axis=(1, 3)))
    coarse = _shadow(device, few, some, ways)
    uneven = maximum_filter(coarse, 3) - minimum_filter(coarse, 3) > EVEN
    shadow = zoom(coarse, COARSE, order=1, grid_mode=True, mode="nearest")
    fine = within & np.repeat(np.repeat(uneven, COARSE, 0), COARSE, 1)
    shadow[fine] = _shadow(device, corners, fine, ways)[fine]
    return np.where(within, shadow, np.float32(0.0))


def _letting_through(part: Part) -> Part:
    """Glass as something that is blended."""
    material, glass = part.material, part.material.refraction
    if glass is None:
        return part
    share = glass.transmission * float(np.dot(material.base_color, LUMINANCE)) * (1.0 - COAT_F0)
    clear = Material(alpha_mode="blend", alpha=1.0 - min(share, 1.0))
    return replace(part, material=clear, mesh=replace(part.mesh, colors=None))


def _ways(light: EnvironmentLight) -> Float32[np.ndarray, "directions 3"] | None:
    """Directions from above, each of which stands for as much light on the ground; None where that is dark."""
    radiance = light.radiance.astype(np.float64)
    rows, columns = radiance.shape[:2]
    edges = np.minimum(np.linspace(0.0, np.pi, rows + 1), 0.5 * np.pi)
    falls = np.sin(edges[1:]) ** 2 - np.sin(edges[:-1]) ** 2  # of a row, the integral of the cosine
    weight = (radiance @ LUMINANCE * falls[:, None]).ravel()
    below = np.concatenate([[0.0], np.cumsum(weight)])
    if not below[-1] > 0.0:
        return None
    number = np.arange(DIRECTIONS) + 0.5
    pixel = np.searchsorted(below, number / DIRECTIONS * below[-1], side="right") - 1
    row, column = np.divmod(np.minimum(pixel, len(weight) - 1), columns)
    down, across = (np.mod(number * step, 1.0) for step in R2)
    low, high = np.sin(edges[row]) ** 2, np.sin(edges[row + 1]) ** 2
    sine = np.sqrt(low + down * (high - low))
    phi = 2.0 * np.pi * ((column + across) / columns - 0.5)
    way = np.stack([sine * np.cos(phi), np.sqrt(1.0 - sine**2), sine * np.sin(phi)], -1)
    return way.astype(np.float32)


def _shadow(
    device: DeviceScene,
    corners: Float[np.ndarray, "rows columns 3"],
    wanted: Bool[np.ndarray, "size size"],
    ways: Float32[np.ndarray, "directions 3"],
) -> Float32[np.ndarray, "size size"]:
    """Each direction looks up from a place of its own within the texel."""
    out = np.zeros(wanted.shape, np.float32)
    row, column = np.nonzero(wanted)
    of_path = mi.Float(np.ascontiguousarray(ways).ravel())
    step = LANES // DIRECTIONS
    for start in range(0, len(row), step):
        r, c = row[start : start + step], column[start : start + step]
        origin = corners[r, c]
        table = np.concatenate([origin, corners[r, c + 1] - origin, corners[r + 1, c] - origin], -1)
        places = mi.Float(np.ascontiguousarray(table, np.float32).ravel())
        lane = dr.arange(mi.UInt32, len(r) * DIRECTIONS)
        texel, path = lane // DIRECTIONS, lane % DIRECTIONS
        at, right, down = (mi.Point3f(*(dr.gather(mi.Float, places, texel * 9 + 3 * k + axis) for axis in range(3)))
                           for k in range(3))  # fmt: skip
        s, t = (mi.Float(path) * step + 0.5 for step in R2)
        point = at + right * (s - dr.floor(s)) + down * (t - dr.floor(t))
        direction = mi.Vector3f(*(dr.gather(mi.Float, of_path, path * 3 + axis) for axis in range(3)))
        hidden = blocked(device, mi.Ray3f(point, direction), mi.Bool(True))
        out[r, c] = dr.block_sum(dr.select(hidden, mi.Float(1.0), 0.0), DIRECTIONS).numpy() / DIRECTIONS
    return out
