"""Rough parts of PEMs: what they reflect of a white room, and that mirrors stay mirrors."""

from dataclasses import replace

import numpy as np
import pytest

from reflet.envmap.env_map import EnvMap
from reflet.envmap.geometry import InfiniteSphere
from reflet.envmap.parameterizations.cube import CUBE
from reflet.pem.pem import Layer, ParameterizedEnvironmentMap
from reflet.reflectance.brdfs.dfg import dfg
from reflet.render.playback.renderer import Renderer
from reflet.scene.material import Material, Texture
from reflet.scene.meshes.primitives import sphere_mesh
from reflet.scene.roughness import TRACED_ROUGHNESS
from reflet.scene.scene import Part, ReflectiveObject, Scene
from reflet.scene.surfaces.irradiance import IrradianceMap
from reflet.scene.views.parameter_space import Axis, Orbit, ParameterSpace
from reflet.shaders.link import link

ORBIT = Orbit((0.0, 0.0, 0.0), 90.0, 15.0, 9.0, fov_deg=40.0, image_size=96)
METALLIC = (0.0, 0.5, 1.0)
CENTRES = ((-2.2, 0.0, 0.0), (0.0, 0.0, 0.0), (2.2, 0.0, 0.0))


def furnace(*materials: Material, diffuse: bool = False, most_hits: int = 0) -> ParameterizedEnvironmentMap:
    """Unit spheres in white light, which is all around, and if asked lights them diffusely."""
    balls = tuple(
        Part(f"ball {k}", sphere_mesh(1.0, CENTRES[k], around=256), material, True)
        for k, material in enumerate(materials)
    )
    numbers = tuple(range(len(balls)))
    scene = Scene(balls, (ReflectiveObject("balls", numbers),))
    layer = Layer("balls", "distant", numbers, InfiniteSphere(), 32, CUBE)
    count = scene.triangle_offsets[-1]
    resolution = np.full(count, diffuse, np.uint32)
    return ParameterizedEnvironmentMap(
        scene=scene,
        irradiance=IrradianceMap(
            resolution, np.arange(count, dtype=np.uint32) * 3, np.ones((3 * count, 3), np.float32)
        ),
        space=ParameterSpace((Axis("azimuth_deg", ()),), ORBIT),
        layers=(layer,),
        maps=[],
        base=(EnvMap(layer.chain, np.ones((layer.chain.texel_count, 3), np.float32), layer.geometry),),
        on_hull=np.zeros(count, bool),
        lod_bias=-1.5,
        sample_count=4,
        most_hits=most_hits,
    )


def shown(pem: ParameterizedEnvironmentMap, samples: int = 1) -> list[tuple[np.ndarray, np.ndarray]]:
    """Radiance of the pixels that each sphere covers, and n·v of a true sphere there."""
    camera = ORBIT.camera()
    picture = Renderer(pem).frame(camera, samples=samples, what="object")
    corner, dx, dy = camera.ray_basis()
    y, x = np.mgrid[: camera.height, : camera.width] + 0.5
    ray = corner + x[..., None] * dx + y[..., None] * dy
    ray /= np.linalg.norm(ray, axis=-1, keepdims=True)
    out = []
    for k in range(len(pem.scene.parts)):
        eye = np.asarray(camera.position) - CENTRES[k]
        cosine = np.sqrt(np.maximum((ray @ eye) ** 2 - eye @ eye + 1.0, 0.0))
        inside = (cosine > 0.15) & (picture[..., 3] == 1.0)  # beyond, facets are seen beside the sphere's own rim
        out.append((picture[inside][:, :3], cosine[inside]))
    return out


def albedo(f0: float, cosine: np.ndarray, roughness: float) -> np.ndarray:
    some = np.linspace(0.3, 1.0, 64) ** 2
    a, b = dfg(some, roughness**2, 1 << 13).T
    return np.interp(cosine, some, (f0 * a + b) * (1.0 + f0 * (1.0 / (a + b) - 1.0)))


@pytest.mark.parametrize("roughness", [0.1, 0.3, 1.0])
def test_white_light_shows_the_albedo(roughness: float) -> None:
    greys = [Material("grey", (0.5, 0.5, 0.5), metallic, roughness) for metallic in METALLIC]
    for metallic, (radiance, cosine) in zip(METALLIC, shown(furnace(*greys)), strict=True):
        paint, metal = (albedo(f0, cosine, roughness)[:, None] for f0 in (0.04, 0.5))
        wanted = np.repeat(paint + metallic * (metal - paint), 3, axis=1)
        np.testing.assert_allclose(radiance, wanted, rtol=5e-3)  # 3e-3 is the table's, the rest the facets'


@pytest.mark.parametrize(("roughness", "most_hits", "samples"), [(0.15, 3, 1), (0.15, 3, 16), (0.6, 0, 1)])
def test_white_stays_white(roughness: float, most_hits: int, samples: int) -> None:
    """Seen in each other as well, and where 16 samples draw their rays from the lobe."""
    whites = [Material("white", (1.0,) * 3, metallic, roughness) for metallic in METALLIC]
    for radiance, _ in shown(furnace(*whites, diffuse=True, most_hits=most_hits), samples):
        np.testing.assert_allclose(radiance, 1.0, atol=1e-5)  # whatever the table says


def test_roughness_comes_from_green() -> None:
    """A texture of one texel is as good as the factor; black green is a mirror."""
    half = replace(Material("grey", (0.5,) * 3, 1.0, 1.0), metallic_roughness_texture=texel(128))
    pem, plain = furnace(half), furnace(Material("grey", (0.5,) * 3, 1.0, 128 / 255))
    (part,) = pem.scene.parts
    uv = np.full((len(part.mesh.positions), 2), 0.5, np.float32)
    textured = replace(part, mesh=replace(part.mesh, uv=uv))
    ((wanted, _),) = shown(plain)
    at_half = replace(pem, scene=replace(pem.scene, parts=(textured,)))
    np.testing.assert_allclose(shown(at_half)[0][0], wanted, atol=1e-6)
    smooth = replace(textured, material=replace(half, metallic_roughness_texture=texel(0)))
    mirror = furnace(replace(half, perceptual_roughness=0.0, metallic_roughness_texture=None))
    black = shown(replace(pem, scene=replace(pem.scene, parts=(smooth,))))[0][0]
    # the table's first row stands for Schlick's formula, linear between its columns
    np.testing.assert_allclose(black, shown(mirror)[0][0], atol=2e-3)


def texel(green: int) -> Texture:
    return Texture(np.array([[[0, green, 255, 255]]], np.uint8))


def test_python_and_shader_trace_up_to_one_roughness() -> None:
    assert f"const TRACED_ROUGHNESS = {TRACED_ROUGHNESS};" in link("traced_picture.wgsl")
