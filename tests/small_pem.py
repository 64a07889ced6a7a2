"""A small PEM made by hand, with everything in it that a PEM can hold: for tests of files and viewers.

Two touching mirror balls hang in a textured room with a bright ceiling. The maps are smooth functions of direction, not
inferred ones; they differ from sample to sample and from level to level, so that any mix-up shows.
"""

from dataclasses import fields, is_dataclass

import numpy as np

from reflet.envmap.env_map import EnvMap
from reflet.envmap.geometry import Box, Ellipsoid
from reflet.envmap.parameterizations.cube import AXES, CUBE
from reflet.envmap.parameterizations.parameterization import Parameterization
from reflet.envmap.relief import Relief
from reflet.pem.pem import Layer, ParameterizedEnvironmentMap
from reflet.scene.material import CLAMPS, EnvironmentLight, Material, Texture
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.scene import Part, ReflectiveObject, Scene
from reflet.scene.surfaces.irradiance import IrradianceMap
from reflet.scene.views.parameter_space import Axis, Orbit, ParameterSpace

ROOM = 2.0
BIG, KNOB = ((0.0, 0.0, 0.0), 0.5), ((0.0, 0.62, 0.0), 0.14)


def small_pem(
    *,
    views: int = 3,
    size: int = 16,
    with_environment: bool = True,
    with_room: bool = True,
    parameterization: Parameterization = CUBE,
    shells: int = 1,
    with_base: bool = True,
) -> ParameterizedEnvironmentMap:
    """The PEM. Without its room, which is closed, the environment light is seen. Of several ``shells`` the nearer ones
    are reliefs, half transparent."""
    checks = np.indices((8, 8)).sum(0) % 2
    tiles = Texture(
        np.stack([200 - 90 * checks, 150 - 60 * checks, 110 + 80 * checks, 255 + 0 * checks], -1).astype("u1")
    )
    bumps = np.full((4, 4, 4), (128, 128, 255, 255), "u1")
    bumps[::2, ::2, 0] = 140
    mirror = Material("mirror", base_color=(0.65, 0.6, 0.5), metallic=1.0, perceptual_roughness=0.0)
    bumpy = Material("bumpy", (0.7, 0.7, 0.7), 1.0, 0.1, normal_texture=Texture(bumps, wraps=CLAMPS), normal_scale=0.5)
    wall = Material("wall", metallic=0.0, base_color_texture_srgb=tiles)
    lamp = Material("lamp", base_color=(0.8, 0.8, 0.8), metallic=0.0, emission=(3.0, 2.9, 2.7), double_sided=True)
    parts = (
        Part("ball", _ball(*BIG), mirror, reflective=True),
        Part("knob", _ball(*KNOB), bumpy, reflective=True),
        Part("room", _walls((0, 1, 3, 4, 5)), wall),
        Part("lamp", _walls((2,)), lamp),
    )
    if not with_room:
        parts = parts[:2]
    environment = EnvironmentLight(np.linspace(0, 1e5, 4 * 8 * 3, dtype=np.float32).reshape(4, 8, 3))
    scene = Scene(parts, (ReflectiveObject("balls", (0, 1)),), environment if with_environment else None)
    box = Box((-ROOM,) * 3, (ROOM,) * 3, (0.0, 0.1, 0.0))
    layers = (
        *_shells(shells, box, size, parameterization),
        Layer("ball", "local", (0,), Ellipsoid(BIG[0], (0.51, 0.52, 0.51), BIG[0]), size // 2, parameterization),
        Layer("knob", "local", (1,), Ellipsoid(KNOB[0], (0.15, 0.15, 0.15), KNOB[0]), size // 2, parameterization),
    )
    azimuths = tuple(60.0 + 2.0 * view for view in range(views))
    space = ParameterSpace((Axis("azimuth_deg", azimuths),), Orbit((0.0, 0.1, 0.0), 60.0, 22.0, 2.0, image_size=128))
    on_hull = np.zeros(scene.triangle_offsets[-1], bool)
    on_hull[: scene.triangle_offsets[1] // 2] = True  # not the true hull: any flags do
    return ParameterizedEnvironmentMap(
        scene=scene,
        irradiance=_irradiance(scene),
        space=space,
        layers=layers,
        maps=[tuple(_map(layer, view) for layer in layers) for view in range(views)],
        on_hull=on_hull,
        lod_bias=-1.0,
        sample_count=16,
        statistics={"seconds": 1.5, "samples": [{"iterations": [view, 5]} for view in range(views)]},
        base=tuple(_map(layer, 7) for layer in layers[:shells]) if with_base else (),
        fade_deg=10.0,
    )


def _shells(count: int, box: Box, size: int, parameterization: Parameterization) -> list[Layer]:
    """The distant layers, nearest first."""
    ends = [0.0, *(0.8 + 0.3 * number for number in range(count - 1)), np.inf]
    rows = np.arange(6 * 64).reshape(6, 8, 8)
    reliefs = [Relief((1.0 + number + 0.3 * np.sin(rows)).astype(np.float16), box.lower, box.upper, box.origin)
               for number in range(count - 1)]  # fmt: skip
    geometries = [*reversed(reliefs), box]
    return [
        Layer(
            "balls" if count == 1 else f"balls {number}",
            "distant",
            (0, 1),
            geometry,
            size,
            parameterization,
            begin,
            end,
        )
        for number, (geometry, begin, end) in enumerate(zip(geometries, ends[:-1], ends[1:], strict=True))
    ]


def _ball(centre: tuple[float, float, float], radius: float, columns: int = 24, rows: int = 12) -> Mesh:
    """A lat-long sphere with exact normals, texture coordinates, and tangents along growing u."""
    v, u = np.meshgrid(np.linspace(0, 1, rows + 1), np.linspace(0, 1, columns + 1), indexing="ij")
    theta, phi = np.pi * v, 2 * np.pi * u
    normals = np.stack([np.sin(theta) * np.cos(phi), np.cos(theta), -np.sin(theta) * np.sin(phi)], -1).reshape(-1, 3)
    tangents = np.stack([-np.sin(phi), 0 * phi, -np.cos(phi), 0 * phi + 1], -1).reshape(-1, 4)
    number = np.arange((rows + 1) * (columns + 1)).reshape(rows + 1, columns + 1)
    a, b, c, d = number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]
    lower, upper = np.stack([a, b, c], -1)[:-1], np.stack([a, c, d], -1)[1:]  # without the degenerate ones at the poles
    return Mesh(
        positions=(np.asarray(centre) + radius * normals).astype(np.float32),
        normals=normals.astype(np.float32),
        triangles=np.concatenate([lower.reshape(-1, 3), upper.reshape(-1, 3)]).astype(np.uint32),
        uv=np.stack([u, v], -1).reshape(-1, 2).astype(np.float32),
        tangents=tangents.astype(np.float32),
    )


def _walls(faces: tuple[int, ...]) -> Mesh:
    """Faces of the room, seen from inside: s × t of the face table points inwards."""
    corners = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
    axes = AXES[list(faces)]
    positions = ROOM * (axes[:, None, 0] + np.einsum("kc,fcx->fkx", corners, axes[:, 1:]))
    first = 4 * np.arange(len(faces))[:, None, None]
    return Mesh(
        positions=positions.reshape(-1, 3).astype(np.float32),
        normals=np.repeat(-axes[:, 0], 4, 0).astype(np.float32),
        triangles=(first + np.array([(0, 1, 2), (0, 2, 3)])).reshape(-1, 3).astype(np.uint32),
        uv=np.tile((corners + 1.0) * 0.5, (len(faces), 1)).astype(np.float32),
    )


def _irradiance(scene: Scene) -> IrradianceMap:
    """None on the mirrors; on the walls a grid of resolution 4 with a smooth shade that differs from wall to wall."""
    resolution = np.zeros(scene.triangle_offsets[-1], np.uint32)
    resolution[scene.triangle_offsets[2] :] = 4
    sides = np.concatenate([np.full(len(p.mesh.triangles), 1 + p.material.double_sided) for p in scene.parts])
    counts = np.where(resolution > 0, sides * (resolution + 1) * (resolution + 2) // 2, 0)
    offset = np.concatenate([[0], np.cumsum(counts)[:-1]]).astype(np.uint32)
    x = np.arange(counts.sum())[:, None] * np.array([0.11, 0.13, 0.17])
    return IrradianceMap(resolution, offset, (0.6 + 0.3 * np.sin(x)).astype(np.float32))


def _map(layer: Layer, view: int) -> EnvMap:
    chain = layer.chain
    levels = []
    for mip_level, size in enumerate(chain.level_sizes):
        d = chain.parameterization.texel_directions(size)[0].reshape(-1, 3)
        colour = 0.6 + 0.5 * np.sin(d * (3.0, 4.0, 5.0) + 0.3 * view + 0.2 * mip_level)
        if layer.channels == 4:
            alpha = np.clip(1.5 * d[:, 1:2] + 0.2 * d[:, :1], 0.0, 1.0)
            colour = np.concatenate([alpha * colour, alpha], 1)
        levels.append(colour)
    return EnvMap(chain, np.concatenate(levels).astype(np.float32), layer.geometry)


def same(a, b) -> bool:
    """Exact equality through records, tuples and arrays."""
    if is_dataclass(a):
        return type(a) is type(b) and all(same(getattr(a, f.name), getattr(b, f.name)) for f in fields(a) if f.compare)
    if isinstance(a, tuple):
        return len(a) == len(b) and all(map(same, a, b))
    if isinstance(a, np.ndarray):
        return a.dtype == b.dtype and np.array_equal(a, b)
    return bool(a == b)
