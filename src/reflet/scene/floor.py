"""A floor beneath a model, on which the environment is projected, and which takes the model's shadow.

As web viewers project it: the environment was photographed from ``height`` above the ground, in the middle of the
model, so that a point of the floor shows what lies in the direction from there to it. The floor is a part like any
other, a disc that does not reflect. Under an environment at infinity a free floor gets the same light everywhere, E:
with the albedo that its picture needs it shows the picture exactly where nothing shades it, and less where the model
does. Where it would need a greater albedo than `MOST_ALBEDO`, lamps light the ground that the environment does not
show: there the albedo is the less, the more it would need, and the rest is emission, which nothing shades. Towards its
rim the floor is blended with the environment behind it.
"""

from dataclasses import dataclass, replace
from io import BytesIO

import numpy as np
from jaxtyping import Float, Float64
from PIL import Image

from reflet.envmap.parameterizations.latlong import LatLong
from reflet.errors import RefletError
from reflet.files.pictures.png import decode_picture
from reflet.files.srgb import srgb_from_linear
from reflet.scene.material import CLAMPS, EnvironmentLight, Material, Texture
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.scene import Part, Scene

MOST_ALBEDO = 0.8  # of fresh snow
RADIUS = 10.0  # times the height: at the rim the ground is seen 6° below the horizon
FADE = 0.5  # of the radius: from here on it is blended with what is behind
BELOW = 1e-4  # of the model's size: how far below the model the floor lies, so that no two surfaces are one
RINGS, FADING_RINGS, SECTORS = 40, 8, 96
MOST_ROWS = 1024  # of the environment and of its picture on the floor
_QUALITY = 92  # of JPEG


@dataclass(frozen=True)
class Floor:
    """``height`` in metres from which the environment was photographed, by default the diagonal of the box around the
    model; ``radius`` in metres of the floor, by default `RADIUS` heights."""

    height: float | None = None
    radius: float | None = None


def with_floor(scene: Scene, floor: Floor) -> Scene:
    """The scene with a floor at its lowest point. Raises RefletError, in one sentence, where there is no environment,
    and for sizes that are not above 0 or do not reach beyond the model."""
    if scene.environment is None:
        raise RefletError("A floor shows the environment, and there is none; add --environment FILE.")
    boxes = [(part.mesh.positions.min(axis=0), part.mesh.positions.max(axis=0)) for part in scene.parts]
    lower, upper = np.min([low for low, _ in boxes], axis=0), np.max([high for _, high in boxes], axis=0)
    extent = upper.astype(np.float64) - lower
    size = float(np.linalg.norm(extent))
    height = size if floor.height is None else floor.height
    radius = RADIUS * height if floor.radius is None else floor.radius
    for what, length in (("height", height), ("radius", radius)):
        if not (np.isfinite(length) and length > 0.0):
            raise RefletError(f"The floor's {what} is {length:g} m; it has to be above 0.")
    reach = float(np.hypot(extent[0], extent[2])) / 2.0
    if FADE * radius < reach:
        raise RefletError(
            f"A floor of {radius:g} m around the model fades from {FADE * radius:g} m on, where the model itself is, "
            f"which reaches {reach:g} m; give --floor-radius {2.5 * reach / FADE:.2g} or more."
        )
    middle = np.array([(lower[0] + upper[0]) / 2.0, lower[1] - BELOW * size, (lower[2] + upper[2]) / 2.0])
    name, taken = "floor", {part.name.lower() for part in scene.parts}
    while name in taken:
        name += "_2"
    part = Part(name, _disc(middle, height, radius), _material(scene.environment, height, radius, name))
    return replace(scene, parts=(*scene.parts, part), floor=len(scene.parts))


def _disc(middle: Float[np.ndarray, "3"], height: float, radius: float) -> Mesh:
    """Rings of even steps in the angle below ``height``, which texture coordinates follow; alpha falls to 0 at the
    rim."""
    inner = height * np.tan(np.linspace(0.0, np.arctan(FADE * radius / height), RINGS + 1))
    rings = np.concatenate([inner, np.linspace(FADE * radius, radius, FADING_RINGS + 1)[1:]])[1:]
    turn = 2.0 * np.pi * np.arange(SECTORS) / SECTORS
    around = np.stack([np.cos(turn), np.sin(turn)], -1)
    flat = np.concatenate([np.zeros((1, 2)), (rings[:, None, None] * around).reshape(-1, 2)])
    distance = np.linalg.norm(flat, axis=-1)
    reach = np.arctan(distance / height) / np.arctan(radius / height)
    uv = 0.5 + 0.5 * flat / np.maximum(distance, 1e-30)[:, None] * reach[:, None]
    share = np.clip((distance / radius - 1.0) / (FADE - 1.0), 0.0, 1.0)
    share[-SECTORS:] = 0.0
    colors = np.ones((len(flat), 4))
    colors[:, 3] = share * share * (3.0 - 2.0 * share)
    k, s = np.meshgrid(np.arange(len(rings) - 1), np.arange(SECTORS), indexing="ij")
    a, b = 1 + k * SECTORS + s, 1 + k * SECTORS + (s + 1) % SECTORS
    c, d = a + SECTORS, b + SECTORS
    hub = np.stack([np.zeros(SECTORS, int), b[0], a[0]], -1)  # x × z points down: the other way around is up
    triangles = np.concatenate([hub, np.stack([a, b, d], -1).reshape(-1, 3), np.stack([a, d, c], -1).reshape(-1, 3)])
    positions = middle + np.stack([flat[:, 0], np.zeros(len(flat)), flat[:, 1]], -1)
    return Mesh(
        positions=positions.astype(np.float32),
        normals=np.tile(np.array([0.0, 1.0, 0.0], np.float32), (len(flat), 1)),
        triangles=triangles.astype(np.uint32),
        uv=uv.astype(np.float32),
        colors=colors.astype(np.float32),
    )


def _material(light: EnvironmentLight, height: float, radius: float, name: str) -> Material:
    radiance = light.radiance.astype(np.float64)
    while len(radiance) > MOST_ROWS:
        radiance = (radiance[0::2] + radiance[1::2])[: len(radiance) // 2]
        radiance = 0.25 * (radiance[:, 0::2] + radiance[:, 1::2])
    picture = _projected(radiance, np.arctan(radius / height))
    free = irradiance_over_pi(radiance)
    wanted = picture / np.maximum(free, 1e-12)
    albedo = np.minimum(wanted, MOST_ALBEDO**2 / np.maximum(wanted, MOST_ALBEDO))
    base_color, base_color_texture = _textured(albedo)
    emission, emission_texture = _textured(np.maximum(picture - albedo * free, 0.0), least=1.0 / 255.0)
    return Material(
        name=name, base_color=base_color, metallic=0.0, specular=0.0, emission=emission, alpha_mode="blend",
        base_color_texture_srgb=base_color_texture, emission_texture_srgb=emission_texture,
    )  # fmt: skip


def irradiance_over_pi(radiance: Float[np.ndarray, "height width 3"]) -> Float64[np.ndarray, "3"]:
    """Of a free floor, which sees the upper half of a lat-long picture."""
    rows = len(radiance)
    edges = np.cos(np.linspace(0.0, np.pi, rows + 1))  # ∫ cos·dω over a row is π·(cos² above - cos² below)
    weight = np.maximum(edges[:-1], 0.0) ** 2 - np.maximum(edges[1:], 0.0) ** 2
    return np.asarray(np.einsum("r,rc->c", weight, radiance.mean(axis=1, dtype=np.float64)))


def _projected(radiance: Float[np.ndarray, "height width 3"], widest: float) -> Float64[np.ndarray, "size size 3"]:
    """The environment from straight down, in the middle, to ``widest`` radians from there along the rim: as many pixels
    as see it no coarser than its rows do. Corners repeat the rim."""
    size = int(np.clip(np.ceil(2.0 * widest / np.pi * len(radiance)), 16, MOST_ROWS))
    at = (2.0 * np.arange(size) + 1.0) / size - 1.0
    x, z = np.meshgrid(at, at)
    distance = np.hypot(x, z)
    theta = np.minimum(distance, 1.0) * widest
    sine = np.sin(theta) / np.maximum(distance, 1e-30)
    direction = np.stack([x * sine, -np.cos(theta), z * sine], -1)
    _, uv = LatLong().uv_from_direction(direction.reshape(-1, 3))
    rows, columns = radiance.shape[:2]
    across, down = uv[:, 0] * columns - 0.5, np.clip(uv[:, 1] * rows - 0.5, 0.0, rows - 1.0)
    left, top = np.floor(across).astype(int), np.minimum(np.floor(down).astype(int), max(rows - 2, 0))
    right, below = (left + 1) % columns, np.minimum(top + 1, rows - 1)
    s, t = (across - left)[:, None], (down - top)[:, None]
    left %= columns
    upper = radiance[top, left] * (1.0 - s) + radiance[top, right] * s
    lower = radiance[below, left] * (1.0 - s) + radiance[below, right] * s
    return np.asarray(upper * (1.0 - t) + lower * t).reshape(size, size, 3)


def _textured(
    colors: Float[np.ndarray, "size size 3"], least: float = 0.0
) -> tuple[tuple[float, float, float], Texture | None]:
    """A factor and an sRGB picture, none where nothing is above ``least``."""
    factor = colors.max(axis=(0, 1))
    if factor.max() <= least:
        return (0.0, 0.0, 0.0), None
    linear = colors / np.maximum(factor, 1e-12)
    srgb = srgb_from_linear(linear)
    file = BytesIO()
    Image.fromarray(np.rint(255.0 * srgb).astype(np.uint8)).save(file, "JPEG", quality=_QUALITY, subsampling=0)
    encoded = file.getvalue()
    red, green, blue = factor.tolist()
    return (red, green, blue), Texture(decode_picture(encoded, "the floor"), CLAMPS, 0, encoded)
