"""A floor beneath a model, on which the environment is projected, and which takes the model's shadow.

As web viewers project it: the environment was photographed from ``height`` above the ground, in the middle of the
model, so that a point of the floor shows what lies in the direction from there to it. The floor is a part like any
other, a disc. Under an environment at infinity a free floor gets the same light everywhere, E: with the albedo that its
picture needs it shows the picture exactly where nothing shades it, and less where the model does. Where it would need a
greater albedo than `MOST_ALBEDO`, lamps light the ground that the environment does not show: there the albedo is the
less, the more it would need, and the rest is emission, which nothing shades. Towards its rim the floor is blended with
the environment behind it.

Three kinds: "matte"; "polished", which mirrors by a clear coat over the same, the whole of it as far as the model
reaches and none where the floor begins to fade: farther out, along the ground, it would mirror the sky over all that
the photograph shows; "shadow", of which nothing but the shadow is seen: black, by the share of the environment's light
that the model takes.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from io import BytesIO

import numpy as np
from jaxtyping import Bool, Float, Float32, Float64
from PIL import Image

from reflet.envmap.parameterizations.latlong import LatLong
from reflet.errors import RefletError
from reflet.files.pictures.png import decode_picture
from reflet.files.srgb import srgb_from_linear
from reflet.scene.floor_kinds import KINDS, RADIUS, ROUGHNESS, Floor
from reflet.scene.material import CLAMPS, EnvironmentLight, Material, Texture
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.roughness import TRACED_ROUGHNESS
from reflet.scene.scene import Part, ReflectiveObject, Scene

MOST_ALBEDO = 0.8  # of fresh snow
FADE = 0.5  # of the radius: from here on it is blended with what is behind
BELOW = 1e-4  # of the model's size: how far below the model the floor lies, so that no two surfaces are one
RINGS, FADING_RINGS, SECTORS = 40, 8, 96
MOST_ROWS = 1024  # of the environment and of its picture on the floor
SHADOW_SIZE = 1024  # texels along an edge: 0.3 % of the height each in the middle
COAT_SIZE = 256
COAT_STEPS = 6
_QUALITY = 92  # of JPEG

Shade = Callable[
    [Scene, Float[np.ndarray, "rows columns 3"], Bool[np.ndarray, "size size"]], Float32[np.ndarray, "size size"]
]


@dataclass(frozen=True)
class _Disc:
    """Where a floor lies, in metres; the model reaches ``reach`` from its middle."""

    middle: Float64[np.ndarray, "3"]
    height: float
    radius: float
    reach: float

    @property
    def widest(self) -> float:
        """Radians from straight down to the rim, as seen from the height."""
        return float(np.arctan(self.radius / self.height))

    def flat(self, uv: Float[np.ndarray, "*batch 2"]) -> Float64[np.ndarray, "*batch 2"]:
        """x and z from the middle, in metres, of texture coordinates: they follow the angle below the height. Beyond
        the rim places go on along it."""
        from_middle = 2.0 * uv.astype(np.float64) - 1.0
        share = np.linalg.norm(from_middle, axis=-1, keepdims=True)
        distance = self.height * np.tan(np.minimum(share, 1.0) * self.widest)
        return np.asarray(from_middle / np.maximum(share, 1e-30) * distance)


def with_floor(scene: Scene, floor: Floor, shade: Shade | None = None) -> Scene:
    """The scene with a floor at its lowest point. ``shade`` tells the shadow of a scene for a floor of which nothing
    else is seen (`reflet.trace.light.floor_shadow`). Raises RefletError, in one sentence, where there is no
    environment, for sizes that are not above 0 or do not reach beyond the model, and for a roughness that is not of a
    polished floor."""
    if scene.environment is None:
        raise RefletError("A floor shows the environment, and there is none; add --environment FILE.")
    disc = _placed(scene, floor)
    _check(floor)
    if floor.kind == "shadow":
        if shade is None:
            raise ValueError("a shadow is traced")
        material = _shadow(scene, disc, shade)
    else:
        material = _ground(scene.environment, disc)
    meshes, objects, polished = [_mesh(disc)], scene.objects, floor.kind == "polished"
    if polished:
        material = _polished(material, disc, ROUGHNESS if floor.roughness is None else floor.roughness)
        meshes = _rings(meshes[0], disc)
    names, taken = [], {part.name.lower() for part in scene.parts}
    for number in range(len(meshes)):
        name = "floor" if number == 0 else f"floor_ring_{number}"
        while name in taken:
            name += "_2"
        names.append(name)
    material = replace(material, name=names[0])
    parts = [Part(name, mesh, material, polished) for name, mesh in zip(names, meshes, strict=True)]
    numbers = tuple(range(len(scene.parts), len(scene.parts) + len(parts)))
    if polished:
        objects = (*objects, ReflectiveObject(names[0], numbers))
    return replace(scene, parts=(*scene.parts, *parts), objects=objects, floor=numbers)


def _check(floor: Floor) -> None:
    if floor.kind not in KINDS:
        raise RefletError(f"A floor is one of {', '.join(KINDS)}; {floor.kind} is none.")
    if floor.roughness is None:
        return
    if floor.kind != "polished":
        raise RefletError(f"A {floor.kind} floor mirrors nothing, it has no roughness; make it polished.")
    if not 0.0 <= floor.roughness <= TRACED_ROUGHNESS:
        raise RefletError(
            f"A polished floor's roughness lies between 0 and {TRACED_ROUGHNESS:g}, not at {floor.roughness:g}; take "
            "the matte floor for what is rougher."
        )


def _placed(scene: Scene, floor: Floor) -> _Disc:
    boxes = [(part.mesh.positions.min(axis=0), part.mesh.positions.max(axis=0)) for part in scene.parts]
    lower = np.min([low for low, _ in boxes], axis=0).astype(np.float64)
    upper = np.max([high for _, high in boxes], axis=0).astype(np.float64)
    extent = upper - lower
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
    return _Disc(middle, height, radius, reach)


def _mesh(disc: _Disc) -> Mesh:
    """Rings of even steps in the angle below the height, which texture coordinates follow; alpha falls to 0 at the
    rim."""
    height, radius = disc.height, disc.radius
    inner = height * np.tan(np.linspace(0.0, np.arctan(FADE * radius / height), RINGS + 1))
    rings = np.concatenate([inner, np.linspace(FADE * radius, radius, FADING_RINGS + 1)[1:]])[1:]
    turn = 2.0 * np.pi * np.arange(SECTORS) / SECTORS
    around = np.stack([np.cos(turn), np.sin(turn)], -1)
    flat = np.concatenate([np.zeros((1, 2)), (rings[:, None, None] * around).reshape(-1, 2)])
    distance = np.linalg.norm(flat, axis=-1)
    reach = np.arctan(distance / height) / disc.widest
    uv = 0.5 + 0.5 * flat / np.maximum(distance, 1e-30)[:, None] * reach[:, None]
    colors = np.ones((len(flat), 4))
    colors[:, 3] = _falling(distance, FADE * radius, radius)
    colors[-SECTORS:, 3] = 0.0
    k, s = np.meshgrid(np.arange(len(rings) - 1), np.arange(SECTORS), indexing="ij")
    a, b = 1 + k * SECTORS + s, 1 + k * SECTORS + (s + 1) % SECTORS
    c, d = a + SECTORS, b + SECTORS
    hub = np.stack([np.zeros(SECTORS, int), b[0], a[0]], -1)  # x × z points down: the other way around is up
    triangles = np.concatenate([hub, np.stack([a, b, d], -1).reshape(-1, 3), np.stack([a, d, c], -1).reshape(-1, 3)])
    positions = disc.middle + np.stack([flat[:, 0], np.zeros(len(flat)), flat[:, 1]], -1)
    return Mesh(
        positions=positions.astype(np.float32),
        normals=np.tile(np.array([0.0, 1.0, 0.0], np.float32), (len(flat), 1)),
        triangles=triangles.astype(np.uint32),
        uv=uv.astype(np.float32),
        colors=colors.astype(np.float32),
    )


def _rings(mesh: Mesh, disc: _Disc) -> list[Mesh]:
    """The disc cut where its coat's share passes steps: what rays meet on their ways has a coat of one share, the mean
    over its part."""
    middles = mesh.positions[mesh.triangles].mean(axis=1, dtype=np.float64) - disc.middle
    share = _falling(np.hypot(middles[:, 0], middles[:, 2]), disc.reach, FADE * disc.radius)
    step = np.ceil(COAT_STEPS * share)
    rings = []
    for each in np.unique(step)[::-1]:
        used, triangles = np.unique(mesh.triangles[step == each], return_inverse=True)
        triangles = triangles.reshape(-1, 3).astype(np.uint32)
        rings.append(mesh.picked(used, triangles))
    return rings


def _falling(distance: Float[np.ndarray, "*batch"], last: float, none: float) -> Float64[np.ndarray, "*batch"]:
    """1 up to a distance, 0 from another one on, smooth in between."""
    share = np.clip((distance - none) / (last - none), 0.0, 1.0)
    return np.asarray(share * share * (3.0 - 2.0 * share))


def _ground(light: EnvironmentLight, disc: _Disc) -> Material:
    radiance = light.radiance.astype(np.float64)
    while len(radiance) > MOST_ROWS:
        radiance = (radiance[0::2] + radiance[1::2])[: len(radiance) // 2]
        radiance = 0.25 * (radiance[:, 0::2] + radiance[:, 1::2])
    picture = _projected(radiance, disc.widest)
    free = irradiance_over_pi(radiance)
    wanted = picture / np.maximum(free, 1e-12)
    albedo = np.minimum(wanted, MOST_ALBEDO**2 / np.maximum(wanted, MOST_ALBEDO))
    base_color, base_color_texture = _textured(albedo)
    emission, emission_texture = _textured(np.maximum(picture - albedo * free, 0.0), least=1.0 / 255.0)
    return Material(
        base_color=base_color, metallic=0.0, specular=0.0, emission=emission, alpha_mode="blend",
        base_color_texture_srgb=base_color_texture, emission_texture_srgb=emission_texture,
    )  # fmt: skip


def _polished(material: Material, disc: _Disc, roughness: float) -> Material:
    """As smooth below its coat, which shows nothing of it: what is wider would be given maps on its surface."""
    at = (np.arange(COAT_SIZE) + 0.5) / COAT_SIZE
    distance = np.linalg.norm(disc.flat(np.stack(np.meshgrid(at, at), -1)), axis=-1)
    share = _falling(distance, disc.reach, FADE * disc.radius)
    pixels = np.repeat(np.rint(255.0 * share).astype(np.uint8)[..., None], 3, -1)
    return replace(
        material, perceptual_roughness=roughness, clearcoat=1.0, clearcoat_roughness=roughness,
        clearcoat_texture=_stored(Image.fromarray(pixels), "PNG"),
    )  # fmt: skip


def _shadow(scene: Scene, disc: _Disc, shade: Shade) -> Material:
    """Black: it sends no light on."""
    edges = np.arange(SHADOW_SIZE + 1) / SHADOW_SIZE
    flat = disc.flat(np.stack(np.meshgrid(edges, edges), -1))
    corners = disc.middle + np.stack([flat[..., 0], np.zeros(flat.shape[:2]), flat[..., 1]], -1)
    near = np.hypot(*np.meshgrid(*[edges[:-1] + 0.5 / SHADOW_SIZE - 0.5] * 2)) < 0.5 + 1.0 / SHADOW_SIZE
    alpha = np.rint(255.0 * shade(scene, corners, near)).astype(np.uint8)
    pixels = np.dstack([np.zeros((*alpha.shape, 3), np.uint8), alpha])
    return Material(
        base_color=(0.0, 0.0, 0.0), metallic=0.0, specular=0.0, alpha_mode="blend",
        base_color_texture_srgb=_stored(Image.fromarray(pixels), "PNG"),
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
    picture = Image.fromarray(np.rint(255.0 * srgb).astype(np.uint8))
    red, green, blue = factor.tolist()
    return (red, green, blue), _stored(picture, "JPEG", quality=_QUALITY, subsampling=0)


def _stored(picture: Image.Image, file_format: str, **options: int) -> Texture:
    file = BytesIO()
    picture.save(file, file_format, **options)
    encoded = file.getvalue()
    return Texture(decode_picture(encoded, "the floor"), CLAMPS, 0, encoded)
