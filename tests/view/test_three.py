"""Pictures of three.js, which benchmarks compare with ours: one camera, and the environment the same way around."""

import runpy
import shutil
from dataclasses import replace

import numpy as np
import pytest
import trimesh
from browser import CHROMIUM, ROOT
from trimesh.visual.material import PBRMaterial
from trimesh.visual.texture import TextureVisuals

from reflet.envmap.parameterizations.latlong import LatLong
from reflet.files.pictures.hdr import write_hdr
from reflet.scene.meshes.primitives import sphere_mesh
from reflet.scene.views.camera import Camera

BENCHMARK = runpy.run_path(str(ROOT / "benchmarks" / "beside_three.py"))
VIEW = Camera((2.0, 1.5, 2.6), (0.0, 0.0, 0.0), fov_deg=34.0, width=48, height=48)
RADIUS, APART = 0.8, 10.0


def light(direction):
    """Radiance that tells every direction from every other, in each channel by one axis."""
    return 1.0 + 0.8 * direction


@pytest.fixture(scope="module")
def shown(tmp_path_factory):
    """A chrome ball, and one without a material a long way beside it."""
    if not shutil.which(CHROMIUM) or not shutil.which("node"):
        pytest.skip("needs Chromium and Node.js")
    if not (ROOT / "web/node_modules/three").exists():
        pytest.skip("three.js is not installed; run: make web")
    folder = tmp_path_factory.mktemp("three")
    write_hdr(folder / "axes.hdr", light(LatLong().texel_directions(128)[0][0]).astype(np.float32))
    mesh, balls = sphere_mesh(RADIUS, around=128), trimesh.Scene()
    chrome = TextureVisuals(material=PBRMaterial(metallicFactor=1.0, roughnessFactor=0.0))
    for look, place in ((chrome, 0.0), (None, APART)):
        triangles = {"vertices": mesh.positions + [place, 0.0, 0.0], "faces": mesh.triangles}
        balls.add_geometry(trimesh.Trimesh(**triangles, vertex_normals=mesh.normals, visual=look, process=False))
    balls.export(folder / "balls.glb", include_normals=True)
    beside = replace(VIEW, position=(2.0 + APART, 1.5, 2.6), target=(APART, 0.0, 0.0))
    shown = BENCHMARK["three_pictures"]
    return shown(folder / "balls.glb", folder / "axes.hdr", [VIEW, beside], APART + RADIUS, folder, across=1)


def rays():
    """Unit rays through pixels' middles, and n·v where they meet the ball, else below 0."""
    corner, dx, dy = VIEW.ray_basis()
    y, x = np.mgrid[: VIEW.height, : VIEW.width] + 0.5
    ray = corner + x[..., None] * dx + y[..., None] * dy
    ray /= np.linalg.norm(ray, axis=-1, keepdims=True)
    eye = np.asarray(VIEW.position)
    root = (ray @ eye) ** 2 - eye @ eye + RADIUS**2
    return ray, np.where(root > 0.0, np.sqrt(np.maximum(root, 0.0)) / RADIUS, -1.0)


def test_a_chrome_ball_mirrors_every_direction_where_ours_does(shown):
    ray, cosine = rays()
    eye = np.asarray(VIEW.position)
    t = -(ray @ eye) - RADIUS * np.maximum(cosine, 0.0)
    normal = (eye + t[..., None] * ray) / RADIUS
    mirrored = ray + 2.0 * cosine[..., None] * normal
    inside = cosine > 0.5  # nearer to the rim a pixel mirrors a wide angle
    assert inside.sum() > 700
    # three.js takes a mirror's roughness for 0.05, and its cube has 64² texels a face; the wrong way around is 0.5 off
    np.testing.assert_allclose(shown[0][inside], light(mirrored)[inside], rtol=0.0, atol=0.03)


def test_what_lies_behind_is_the_environment(shown):
    ray, cosine = rays()
    assert (cosine < 0.0).sum() > 300
    # half a texel of 128 rows is 0.7°, 0.01 of the light; shared exponents round by 0.004
    np.testing.assert_allclose(shown[0][cosine < 0.0], light(ray)[cosine < 0.0], rtol=0.0, atol=0.02)


def test_a_mesh_without_a_material_is_the_mirror_that_it_is_for_us(shown):
    _, cosine = rays()
    middle = cosine > 0.9
    np.testing.assert_allclose(shown[1][middle], 0.65 * shown[0][middle], rtol=0.0, atol=0.01)
