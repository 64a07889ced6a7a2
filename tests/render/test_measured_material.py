"""Materials given by lobes, on the device, against the NumPy twin."""

import numpy as np
import pytest
from compute import run
from map_scenes import sphere_reflections, view_rays

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS
from reflet.errors import RefletError
from reflet.reflectance.brdfs.brdf import FunctionBrdf
from reflet.reflectance.brdfs.lambert import Lambert
from reflet.reflectance.lobes.lobes import fit_lobes
from reflet.reflectance.materials.material_maps import EnvironmentMaps
from reflet.reflectance.materials.measured_material import Measured
from reflet.reflectance.prefilter.brdf_map import lobe_axis, reflected_radiance
from reflet.render.device.device import shared_device
from reflet.render.maps.brdf_map_texture import upload_brdf_map
from reflet.render.materials.env_map_renderer import view_frame
from reflet.render.materials.material_renderer import MaterialRenderer
from reflet.scene.meshes.primitives import sphere_mesh
from reflet.scene.views.camera import Camera

CAMERA = Camera((1.5, 1.2, 2.6), (0.0, 0.0, 0.0), fov_deg=50, width=72, height=60)


def off_specular(cos_i: np.ndarray, cos_o: np.ndarray, delta_phi: np.ndarray) -> np.ndarray:
    """A red ground, a lobe beyond the mirrored direction, and a blue one back to the viewer."""
    sines = np.sqrt((1.0 - cos_i**2) * (1.0 - cos_o**2))
    axis = np.minimum(1.15 * np.arccos(cos_o), 1.5)
    glossy = np.cos(axis) * cos_i - np.sin(axis) * np.sqrt(1.0 - cos_i**2) * np.cos(delta_phi)
    retro = cos_i * cos_o + sines * np.cos(delta_phi)
    lobes = [np.maximum(glossy, 0.0) ** 30 * 2.0, np.maximum(retro, 0.0) ** 15]
    return 0.1 * np.array([1.0, 0.3, 0.2]) + lobes[0][..., None] + lobes[1][..., None] * np.array([0.2, 0.4, 1.0])


def environment(size: int = 32) -> EnvImage:
    """Light from all sides, every axis told apart, and a lamp."""
    to = PARAMETERIZATIONS["octahedral"]
    direction, _ = to.texel_directions(size)
    lamp = 4.0 * np.exp(20.0 * (direction @ np.array([0.48, 0.6, 0.64]) - 1.0))
    return EnvImage(to, (0.5 + 0.3 * direction + lamp[..., None]).astype(np.float32))


@pytest.fixture(scope="module")
def material() -> Measured:
    return Measured(fit_lobes(FunctionBrdf(off_specular), angles=4))


@pytest.mark.parametrize(("name", "turned"), [("octahedral", False), ("cube", True)])
def test_a_sphere_shows_what_the_twin_reflects(material: Measured, name: str, turned: bool) -> None:
    turn = view_frame(Camera((1.0, 2.0, 0.5), (0.0, 0.0, 0.0))) if turned else np.eye(3)
    maps = EnvironmentMaps(environment(), 16, PARAMETERIZATIONS[name])
    # Close by, where texels of 5° to 13° are larger than pixels' mirrored footprints: level 0 is all that is read.
    camera = Camera((0.75, 0.6, 1.3), (0.0, 0.0, 0.0), fov_deg=30, width=96, height=80)
    picture = MaterialRenderer(sphere_mesh(around=512), maps).picture(material, camera, frame=turn, samples=1)
    direction, cosine = sphere_reflections(camera)
    ray = view_rays(camera)
    usable = np.isfinite(cosine) & (cosine > 0.35)
    assert usable.mean() > 0.3
    usable &= np.random.default_rng(0).uniform(size=usable.shape) < 0.2
    normal = (direction - ray)[usable]
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    wanted = reflected_radiance(maps.brdf_map(material.lobes), normal @ turn.T, -ray[usable] @ turn.T)
    # The mesh of 512 meridians: normals off by (π/256)²/8 = 2e-5, positions by as much, which turns rays that meet them
    # aslant by 6e-5; radiance changes by 5 a radian at most.
    np.testing.assert_allclose(picture[usable][:, :3], wanted, atol=5e-4)


def test_axes_are_twins() -> None:
    random = np.random.default_rng(3)
    n, v = random.normal(size=(2, 500, 3))
    n, v = (w / np.linalg.norm(w, axis=-1, keepdims=True) for w in (n, v))
    v *= np.sign((n * v).sum(-1, keepdims=True))
    v[0] = n[0]
    side = np.where(np.arange(500) % 2 == 0, 1.0, -1.0)
    apart = random.uniform(-0.3, 0.3, 500)
    apart[0] = 0.0  # along the normal no side is the mirrored one
    n, v = n.astype("f4").astype(float), v.astype("f4").astype(float)
    code = """
    #import lobe_axis
    let n = vec3f(in0[3*i], in0[3*i+1], in0[3*i+2]);
    let v = vec3f(in1[3*i], in1[3*i+1], in1[3*i+2]);
    let axis = lobe_axis(n, v, in2[2*i], in2[2*i+1]);
    out[3*i] = axis.x; out[3*i+1] = axis.y; out[3*i+2] = axis.z;
    """
    shader = run(code, [n, v, np.stack([side, apart], -1)], 3)
    cosine = np.clip((n * v).sum(-1), -1.0, 1.0)
    # WGSL allows sines an error of 2^-11; Mesa's err by 1e-6, and cancellation near the normal adds some float32 steps.
    np.testing.assert_allclose(shader, lobe_axis(n, v, side * np.arccos(cosine) + apart), atol=5e-4)


def test_in_a_furnace_the_albedo_shows(material: Measured) -> None:
    maps = EnvironmentMaps(EnvImage(PARAMETERIZATIONS["cube"], np.ones((6, 16, 16, 3), np.float32)), 32)
    picture = MaterialRenderer(sphere_mesh(around=256), maps).picture(material, CAMERA, samples=1)
    _, cosine = sphere_reflections(CAMERA)
    usable = np.isfinite(cosine) & (cosine > 0.1)
    specular, diffuse = material.weights(cosine[usable])
    # The mesh of 256 meridians: n·v off by sqrt(2·7.5e-5)/2 near the outline (test_material_renderer); slopes of 1.
    np.testing.assert_allclose(picture[usable][:, :3], specular + diffuse, atol=6e-3)
    assert picture[..., :3][picture[..., 3] > 0.0].min() > 0.1  # nothing black, up to the outline


def test_diffuse_alone_needs_no_slices() -> None:
    maps = EnvironmentMaps(EnvImage(PARAMETERIZATIONS["cube"], np.ones((6, 16, 16, 3), np.float32)), 32)
    picture = MaterialRenderer(sphere_mesh(), maps).picture(
        Measured(fit_lobes(Lambert(), ("diffuse",), 2)), CAMERA, samples=1
    )
    np.testing.assert_allclose(picture[30, 36], 1.0, atol=1e-3)  # the fit's


def test_more_layers_than_the_device_has_are_refused() -> None:
    layers = shared_device().limits["max-texture-array-layers"]
    maps = EnvironmentMaps(environment(8), 8, PARAMETERIZATIONS["cube"]).brdf_map(fit_lobes(Lambert(), ("glossy",), 2))
    many = type(maps)(maps.lobes, maps.diffuse, (maps.slices[0][:1] * (layers // 6 + 1),))
    with pytest.raises(RefletError, match="fewer view angles"):
        upload_brdf_map(shared_device(), many)
