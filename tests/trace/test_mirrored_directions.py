"""The tracer mirrors where the G-buffer says: a sky linear in the direction tells which way its rays went."""

from dataclasses import replace

import numpy as np
import pytest
from trace_scenes import CHROME, camera, no_irradiance, quad, scene, sphere

from reflet.scene.material import EnvironmentLight, Material, Texture
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.scene import Part
from reflet.scene.surfaces.surface import gbuffer_from_visibility
from reflet.scene.views.camera import Camera
from reflet.trace.compose import object_radiance
from reflet.trace.references.path_reference import PathReference
from reflet.trace.tracer import Tracer


def linear_sky(height: int = 128) -> EnvironmentLight:
    """Radiance 1 + direction/2, a channel for each axis."""
    v, u = np.meshgrid((np.arange(height) + 0.5) / height, (np.arange(2 * height) + 0.5) / (2 * height), indexing="ij")
    phi, theta = (u - 0.5) * 2 * np.pi, v * np.pi
    direction = np.stack([np.cos(phi) * np.sin(theta), np.cos(theta), np.sin(phi) * np.sin(theta)], -1)
    return EnvironmentLight((1.0 + 0.5 * direction).astype(np.float32))


def wavy_plate() -> Part:
    """A plate with a smooth normal map, tangents along +x."""
    y, x = np.mgrid[0:64, 0:64] * (2 * np.pi / 64)
    n = np.stack([0.3 * np.sin(x), 0.2 * np.cos(y), np.ones_like(x)], -1)
    n /= np.linalg.norm(n, axis=-1, keepdims=True)
    pixels = np.full((64, 64, 4), 255, np.uint8)
    pixels[..., :3] = np.round((n + 1.0) * 127.5)
    flat = quad((-1, -1, 0), (2, 0, 0), (0, 2, 0))
    tangents = np.tile([1.0, 0.0, 0.0, -1.0], (4, 1)).astype(np.float32)
    mesh = Mesh(flat.positions, flat.normals, flat.triangles, flat.uv, tangents)
    wavy = Material("wavy", (0.9, 0.9, 0.9), 1.0, 0.0, normal_texture=Texture(pixels), normal_scale=0.7)
    return Part("plate", mesh, wavy, True)


@pytest.mark.parametrize("shape", ["ball", "wavy plate"])
def test_distant_light_comes_from_the_g_buffers_directions(shape: str) -> None:
    part = Part("ball", sphere((0.2, 0.1, 0)), CHROME, True) if shape == "ball" else wavy_plate()
    what = scene([part], [(0,)], linear_sky())
    view = Tracer(what, irradiance=no_irradiance(what)).view(camera((0.5, 0.4, 4.0)), spp=64, sample_count=16)
    gbuffer = gbuffer_from_visibility(what, view.visibility)
    direction = gbuffer.lookups[0].direction[0]
    count = np.bincount(gbuffer.row_of_sample)
    mean = np.stack([np.bincount(gbuffer.row_of_sample, 1.0 + 0.5 * direction[:, c]) / count for c in range(3)], -1)
    layers = view.layers
    full = layers.coverage == 1.0
    pixels = np.intersect1d(layers.pixel[full], gbuffer.row_pixel[count == 16])
    ours, theirs = (np.searchsorted(rows, pixels) for rows in (layers.pixel, gbuffer.row_pixel))
    error = np.abs(layers.distant[ours] - mean[theirs])
    # Two patterns of 64 and 16 samples in one pixel: near the ball's rim the direction turns by 40° in a pixel, and a
    # pattern of 16 errs by about a fiftieth of that.
    assert np.median(error) < 1.5e-3
    assert np.quantile(error, 0.98) < 2e-2
    assert len(pixels) > 500
    assert np.ptp(mean, axis=0).min() > 0.1, "the sky must tell directions apart"


def test_the_path_reference_shows_the_same_bumps() -> None:
    """Two codes of normal maps, the tracer's and that of glTF's materials, sample by sample of their own patterns."""
    plate = wavy_plate()
    chrome = replace(plate, material=replace(plate.material, perceptual_roughness=0.0))
    what = scene([chrome], [(0,)], linear_sky())
    view = camera((0.5, 0.4, 4.0))
    layers = Tracer(what, irradiance=no_irradiance(what)).view(view, spp=64).layers
    ours, coverage = object_radiance(layers)
    theirs = PathReference(what, materials="gltf").picture(view, spp=256, max_depth=2)
    error = np.abs(ours - theirs)[coverage == 1.0]
    # Over a pixel the bumps turn reflections by a degree: 0.01 of radiance, by the roots of 64 and 256 samples.
    assert np.median(error) < 1e-3
    assert np.quantile(error, 0.98) < 6e-3
    assert theirs[coverage == 1.0].std(0)[:2].min() > 0.08, "the bumps must show"


def test_sky_and_camera_stand_as_in_mitsuba() -> None:
    """Away from objects the picture is the sky itself; its own camera and environment agree with ours."""
    what = scene([Part("ball", sphere((0, 0, 0), 0.01, rows=4), CHROME, True)], [(0,)], linear_sky())
    view = camera((1.0, 0.7, 3.0), size=16)
    ours = Tracer(what, irradiance=no_irradiance(what)).view(view, spp=16, surroundings=True).layers.surroundings
    theirs = PathReference(what).picture(view, spp=16, max_depth=2)
    away = np.ones((16, 16), bool)
    away[6:10, 6:10] = False
    # Mitsuba sets its rows' centres half a pixel elsewhere: π/128/2 of a slope of 0.5
    np.testing.assert_allclose(ours[away], theirs[away], atol=8e-3)
    assert np.ptp(ours[away], axis=0).min() > 0.05


@pytest.mark.parametrize("roughness", [0.0, 0.02])
def test_normals_that_face_away_reflect_by_the_bent_rays_own_normal(roughness: float) -> None:
    """Paint whose normals lean 20° away, seen from 8° above, in white light; the path traced references agree."""
    lean, low = np.radians(20.0), np.radians(8.0)
    floor = quad((-0.5, 0, -0.5), (0, 0, 1), (1, 0, 0))
    mesh = replace(floor, normals=np.tile(np.float32([np.sin(lean), np.cos(lean), 0.0]), (4, 1)))
    paint = Part("floor", mesh, Material("paint", (0.0,) * 3, 0.0, roughness), True)
    what = scene([paint], [(0,)], EnvironmentLight(np.ones((8, 16, 3), np.float32)))
    view = Camera((-4.0 * float(np.cos(low)), 4.0 * float(np.sin(low)), 0.0), (0.0, 0.0, 0.0), fov_deg=0.1, width=2,
                  height=2)  # fmt: skip
    # the half vector lies halfway between the viewer and a ray 0.001 above the floor
    cosine = np.cos((np.pi - low - 0.001) / 2.0)
    expected = 0.04 + 0.96 * (1.0 - cosine) ** 5
    radiance, _ = object_radiance(Tracer(what, irradiance=no_irradiance(what)).view(view, spp=16).layers)
    # a pixel of 0.05° is 4e-4 of the half vector's cosine; the ray is normalized
    np.testing.assert_allclose(radiance, expected, rtol=5e-3)
    for materials in ("mirrors", "gltf"):
        theirs = PathReference(what, materials=materials).picture(view, spp=256, max_depth=2)
        # of "mirrors" half of the samples mirror: a 16th of the value each in 1024 samples, three times that
        np.testing.assert_allclose(theirs.mean(), expected, rtol=0.1)
