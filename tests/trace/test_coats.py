"""Clear coats in the tracer: furnaces, and the path tracer's picture."""

from dataclasses import replace

import numpy as np
import pytest
from trace_scenes import camera, constant_light, no_irradiance, quad, scene, sphere

from reflet.reflectance.brdfs.dfg import dfg
from reflet.scene.material import EnvironmentLight, Material, Texture
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.scene import Part, Scene
from reflet.trace.compose import compose, object_radiance
from reflet.trace.references.path_reference import PathReference
from reflet.trace.tracer import Tracer

PAINT = Material("paint", (0.5, 0.1, 0.05), 0.0, 0.5, clearcoat=1.0, clearcoat_roughness=0.1)


def coated_albedo(below: float, cosine: np.ndarray, roughness: float) -> np.ndarray:
    """Of white light: what is below is seen through the coat."""
    some = np.linspace(0.1, 1.0, 64) ** 2
    kept = np.interp(cosine, some, dfg(some, roughness**2, 1 << 13).sum(1))
    fresnel = 0.04 + 0.96 * (1.0 - cosine) ** 5
    return np.asarray((1.0 - fresnel) * below + fresnel * kept)


@pytest.mark.parametrize("roughness", [0.0, 0.3, 1.0])
@pytest.mark.parametrize("below", [0.0, 0.5])
def test_white_light_shows_the_albedo(roughness: float, below: float) -> None:
    """A coat over white metal, a mirror or rough: what it keeps of its light is lost, nothing else."""
    metal = Material("metal", (1.0,) * 3, 1.0, below, clearcoat=1.0, clearcoat_roughness=roughness)
    what = scene([Part("ball", sphere(rows=96), metal, True)], [(0,)], constant_light(1.0))
    view = camera((0.0, 0.0, 8.0), 32)
    view = replace(view, fov_deg=18.0)
    shown, coverage = object_radiance(Tracer(what, irradiance=no_irradiance(what)).view(view, spp=256).layers)
    corner, dx, dy = view.ray_basis()
    y, x = np.mgrid[:32, :32] + 0.5
    ray = corner + x[..., None] * dx + y[..., None] * dy
    ray /= np.linalg.norm(ray, axis=-1, keepdims=True)
    eye = np.asarray(view.position)
    cosine = np.sqrt(np.maximum((ray @ eye) ** 2 - eye @ eye + 1.0, 0.0))
    inside = (coverage == 1.0) & (cosine > 0.4)
    expected = coated_albedo(1.0, cosine[inside], roughness)
    wrong = shown[inside].mean(-1) - expected
    assert inside.sum() > 100
    assert abs(wrong.mean()) < 2e-3  # a third of which is the table's
    assert np.abs(wrong).max() < 0.02  # noise of 256 samples


def ripples() -> Texture:
    """Normals tilted by up to 20° to and fro."""
    tilt = 0.35 * np.sin(np.arange(16) * np.pi / 4)
    normal = np.stack([np.sin(tilt), 0.0 * tilt, np.cos(tilt)], -1)
    return Texture(np.dstack([np.rint(127.5 * normal + 127.5)[None], np.full((1, 16, 1), 255)]).astype(np.uint8))


def shares(channel: int) -> Texture:
    pixels = np.zeros((4, 4, 4), np.uint8)
    pixels[..., channel] = np.random.default_rng(2).integers(0, 256, (4, 4))
    return Texture(pixels)


def panel(material: Material) -> Part:
    flat = quad((-1, -1, 0), (2, 0, 0), (0, 2, 0))
    tangents = np.tile(np.float32([1.0, 0.0, 0.0, 1.0]), (4, 1))
    return Part("panel", Mesh(flat.positions, flat.normals, flat.triangles, flat.uv, tangents), material, True)


def court(material: Material) -> Scene:
    """A coated panel behind a coated ball that it mirrors, under a sky with a small sun."""
    sky = np.full((32, 64, 3), 0.4, np.float32)
    sky[:16, :, 2] = 0.8
    sky[8:10, 44:48] = (40.0, 36.0, 30.0)  # behind the viewer
    ball = Part("ball", sphere((0.3, 0.1, 0.7), 0.35, 24), replace(PAINT, name="ball"), True)
    return scene([panel(material), ball], [(0, 1)], EnvironmentLight(sky))


@pytest.mark.parametrize("kind", ["textured and bumpy", "mirrors"])
def test_the_path_tracer_shows_the_same(kind: str) -> None:
    """Both lobes of what is seen, and of what it mirrors; without coats the picture is off by more."""
    material = replace(PAINT, clearcoat_roughness=0.0, perceptual_roughness=0.0, metallic=1.0)
    if kind != "mirrors":
        material = replace(
            PAINT, clearcoat_texture=shares(0), clearcoat_roughness_texture=shares(1), clearcoat_roughness=0.6,
            clearcoat_normal_texture=ripples(), clearcoat_normal_scale=0.8,
        )  # fmt: skip
    what, view = court(material), camera((0.2, 0.3, 4.0), 24)
    tracer = Tracer(what, irradiance_spp=64)
    shown = compose(tracer.view(view, spp=128, surroundings=True).layers)
    bare = replace(what, parts=tuple(replace(p, material=replace(p.material, clearcoat=0.0)) for p in what.parts))
    uncoated = compose(Tracer(bare, irradiance=tracer.irradiance).view(view, spp=64, surroundings=True).layers)
    reference = PathReference(what, materials="gltf")
    one, other = (reference.picture(view, spp=128, max_depth=9, seed=seed) for seed in (1, 2))
    expected, noise = (one + other) / 2, np.sqrt(np.mean((one - other) ** 2)) / 2

    def error(picture: np.ndarray) -> float:
        return float(np.sqrt(np.mean((picture - expected) ** 2)))

    assert error(shown) < 2.0 * noise, (error(shown), error(uncoated), noise)  # and its own
    assert error(uncoated) > 1.5 * error(shown), (error(shown), error(uncoated), noise)
    assert abs(float(np.mean(shown - expected))) < 0.01 * float(expected.mean())
