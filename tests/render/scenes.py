"""Small scenes and PEMs for the renderer's tests, made by hand."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any, Literal

import numpy as np

from reflet.envmap.env_map import EnvMap
from reflet.envmap.geometry import Geometry, InfiniteSphere
from reflet.envmap.mip_chain import MipChain
from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.parameterizations.parameterization import Parameterization
from reflet.pem.pem import Layer, ParameterizedEnvironmentMap
from reflet.scene.material import Material
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.meshes.primitives import torus_mesh
from reflet.scene.scene import Part, ReflectiveObject, Scene
from reflet.scene.surfaces.hull import hull_triangles
from reflet.scene.surfaces.irradiance import IrradianceMap
from reflet.scene.views.parameter_space import Axis, Orbit, ParameterSpace

MIRROR = Material(base_color=(0.65, 0.65, 0.65), metallic=1.0, perceptual_roughness=0.0)


def torus() -> Mesh:
    """2304 triangles, its tube no thinner than what a picture of 64² pixels shows."""
    return torus_mesh(0.3, 0.12, around=48, sides=24)


def sphere(rings: int = 64, sides: int = 128, radius: float = 0.4) -> Mesh:
    """Around the origin, analytic normals; the triangles at the poles are left out where they have no area."""
    v, u = np.meshgrid(np.linspace(0, np.pi, rings + 1), np.arange(sides) * 2 * np.pi / sides, indexing="ij")
    normal = np.stack([np.sin(v) * np.cos(u), np.cos(v), np.sin(v) * np.sin(u)], -1).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(rings), np.arange(sides), indexing="ij")
    a, b = i * sides + j, i * sides + (j + 1) % sides
    c, d = a + sides, b + sides
    upper = np.stack([a, b, d], -1)[1:].reshape(-1, 3)
    lower = np.stack([a, d, c], -1)[:-1].reshape(-1, 3)
    return mesh(radius * normal, normal, np.concatenate([upper, lower]))


def quad(corners: np.ndarray, uv: np.ndarray | None = None) -> Mesh:
    """Four corners, counter-clockwise seen from the front."""
    corners = np.asarray(corners, float)
    normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
    normal /= np.linalg.norm(normal)
    made = mesh(corners, np.tile(normal, (4, 1)), np.array([[0, 1, 2], [0, 2, 3]]))
    return made if uv is None else Mesh(made.positions, made.normals, made.triangles, np.asarray(uv, np.float32))


def mesh(positions: np.ndarray, normals: np.ndarray, triangles: np.ndarray) -> Mesh:
    """With the records' types."""
    return Mesh(positions.astype(np.float32), normals.astype(np.float32), triangles.astype(np.uint32))


def analytic_map(
    size: int,
    radiance: Callable[[np.ndarray], np.ndarray],
    geometry: Geometry,
    parameterization: Parameterization = CUBE,
    map_from_world: np.ndarray | None = None,
) -> EnvMap:
    """Texels are ``radiance`` of the unit directions of their centres, in the world."""
    chain = MipChain(size, parameterization)
    d = np.concatenate([parameterization.texel_directions(n)[0].reshape(-1, 3) for n in chain.level_sizes])
    if map_from_world is not None:
        d = d @ map_from_world
    return EnvMap(chain, np.asarray(radiance(d), np.float32), geometry)


def random_map(size: int, channels: int, geometry: Geometry, seed: int) -> EnvMap:
    """Every texel different, radiance in [0, 2]; local ones premultiplied."""
    chain = MipChain(size)
    texels = np.random.default_rng(seed).uniform(0.0, 2.0, (chain.texel_count, channels))
    if channels == 4:
        texels[:, 3] *= 0.5
        texels[:, :3] *= texels[:, 3:]
    return EnvMap(chain, texels.astype(np.float16).astype(np.float32), geometry)


def scene_of(*parts: Part) -> Scene:
    """All reflective parts form one object."""
    reflective = tuple(i for i, part in enumerate(parts) if part.reflective)
    return Scene(parts, (ReflectiveObject("object", reflective),) if reflective else ())


def pem_of(
    scene: Scene,
    distant: list[EnvMap],
    local: list[EnvMap] | None = None,
    *,
    irradiance: IrradianceMap | None = None,
    on_hull: np.ndarray | None = None,
    lod_bias: float = -1.0,
    image_size: int = 64,
    sample_count: int = 4,
) -> ParameterizedEnvironmentMap:
    """One distant map and, if given, one local map for all reflective parts; samples lie 2° apart from azimuth 60°."""
    parts = scene.objects[0].parts
    layers = [_layer("distant", parts, distant[0])]
    maps = [(each,) for each in distant]
    if local is not None:
        layers.append(_layer("local", parts, local[0]))
        maps = list(zip(distant, local, strict=True))
    count = scene.triangle_offsets[-1]
    if irradiance is None:
        irradiance = IrradianceMap(np.zeros(count, np.uint32), np.zeros(count, np.uint32), np.zeros((1, 3), np.float32))
    values = tuple(60.0 + 2.0 * i for i in range(len(distant)))
    orbit = Orbit((0.0, 0.0, 0.0), 60.0, 22.0, 1.5, image_size=image_size)
    return ParameterizedEnvironmentMap(
        scene=scene,
        irradiance=irradiance,
        space=ParameterSpace((Axis("azimuth_deg", values),), orbit),
        layers=tuple(layers),
        maps=maps,
        on_hull=np.zeros(count, bool) if on_hull is None else on_hull,
        lod_bias=lod_bias,
        sample_count=sample_count,
    )


def _layer(kind: Literal["distant", "local"], parts: tuple[int, ...], env_map: EnvMap) -> Layer:
    return Layer(kind, kind, parts, env_map.geometry, env_map.chain.size, env_map.chain.parameterization)


def mirror_torus_pem(size: int = 32, samples: int = 1, image_size: int = 64, **options) -> ParameterizedEnvironmentMap:  # type: ignore[no-untyped-def]
    """A torus under random maps at infinity: any error in lookup or filter shows."""
    scene = scene_of(Part("torus", torus(), MIRROR, True))
    maps = [random_map(size, 3, InfiniteSphere(), seed) for seed in range(samples)]
    return pem_of(scene, maps, image_size=image_size, **options)


SKY = (0.7, 0.5, 0.3)


def flat_sky(d: np.ndarray) -> np.ndarray:
    return np.broadcast_to(np.float32(SKY), d.shape)


def traced_pem(
    *parts: Part, hits: int = 5, sky: Callable = flat_sky, size: int = 8, **options: Any
) -> ParameterizedEnvironmentMap:
    """All parts one object under a sky at infinity."""
    scene = Scene(parts, (ReflectiveObject("object", tuple(range(len(parts)))),))
    pem = pem_of(scene, [analytic_map(size, sky, InfiniteSphere())], on_hull=hull_triangles(scene), **options)
    return replace(pem, most_hits=hits)
