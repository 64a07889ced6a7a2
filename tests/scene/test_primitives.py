"""Meshes from formulas, finer meshes of the same surface, and the light they are shown under."""

import numpy as np
import pytest

from reflet.scene.builtin.solids import box
from reflet.scene.meshes.corners import weld
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.meshes.primitives import sphere_mesh, torus_mesh
from reflet.scene.meshes.tessellate import tessellated
from reflet.scene.sky_light import SkyLight


def corners_of(mesh: Mesh) -> np.ndarray:
    return mesh.positions[mesh.triangles].astype(np.float64)


def area(mesh: Mesh) -> float:
    a, b, c = np.moveaxis(corners_of(mesh), 1, 0)
    return float(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=-1).sum())


def volume(mesh: Mesh) -> float:
    """By the divergence theorem; positive where triangles are counter-clockwise from outside."""
    a, b, c = np.moveaxis(corners_of(mesh), 1, 0)
    return float(np.einsum("ti,ti->t", a, np.cross(b, c)).sum() / 6.0)


def open_edges(mesh: Mesh) -> int:
    """Directed edges whose opposite no triangle has; vertices at one place, to 1e-5 m, count as one."""
    keys = [tuple(p) for p in np.round(mesh.positions.astype(np.float64) * 1e5).astype(int)]
    number = {key: i for i, key in enumerate(dict.fromkeys(keys))}
    vertex = np.array([number[key] for key in keys])[mesh.triangles]
    edges = {(int(a), int(b)) for t in vertex for a, b in zip(t, np.roll(t, -1), strict=True)}
    return sum((b, a) not in edges for a, b in edges)


def test_sphere() -> None:
    mesh = sphere_mesh(0.5, (1.0, 2.0, 3.0), around=64)
    assert len(mesh.triangles) == 64 * 62
    assert open_edges(mesh) == 0
    np.testing.assert_allclose(np.linalg.norm(mesh.positions - (1.0, 2.0, 3.0), axis=1), 0.5, atol=1e-6)
    np.testing.assert_allclose(mesh.positions, 0.5 * mesh.normals + (1.0, 2.0, 3.0), atol=1e-6)
    # An inscribed polygon of n corners has 1 - (2π/n)²/6 of the circle's area; across and along, some 3e-3.
    assert area(mesh) == pytest.approx(4.0 * np.pi * 0.25, rel=4e-3)
    assert volume(sphere_mesh(0.5, around=64)) == pytest.approx(4.0 / 3.0 * np.pi * 0.125, rel=6e-3)


def test_torus() -> None:
    mesh = torus_mesh(0.7, 0.3, around=96, sides=48)
    assert len(mesh.triangles) == 2 * 96 * 48
    assert open_edges(mesh) == 0
    ring = np.hypot(mesh.positions[:, 0], mesh.positions[:, 2])
    np.testing.assert_allclose(np.hypot(ring - 0.7, mesh.positions[:, 1]), 0.3, atol=1e-6)
    # Pappus; polygons as above.
    assert area(mesh) == pytest.approx(4.0 * np.pi**2 * 0.7 * 0.3, rel=3e-3)
    assert volume(mesh) == pytest.approx(2.0 * np.pi**2 * 0.7 * 0.3**2, rel=5e-3)
    assert np.einsum("vi,vi->v", mesh.normals, mesh.positions - 0.7 * np.stack(
        [mesh.positions[:, 0] / ring, 0 * ring, mesh.positions[:, 2] / ring], -1)).min() > 0.0  # fmt: skip


@pytest.mark.parametrize("longest", [0.1, 0.33, 5.0])
def test_tessellation_keeps_the_surface(longest: float) -> None:
    solid = box((0.0, 0.0, 0.0), (1.0, 0.5, 0.8), 0)
    mesh = weld(solid.corners, solid.normals, solid.uv)
    fine = tessellated(mesh, longest)
    edges = np.linalg.norm(np.roll(corners_of(fine), -1, axis=1) - corners_of(fine), axis=-1)
    assert edges.max() <= longest + 1e-6
    assert open_edges(fine) == 0
    assert area(fine) == pytest.approx(area(mesh), rel=1e-6)
    assert volume(fine) == pytest.approx(0.4, rel=1e-6)
    assert fine.uv is not None and fine.uv.min() >= 0.0 and fine.uv.max() <= 1.0


def test_sky_light_is_the_integral_over_the_hemisphere() -> None:
    light = SkyLight(sky=(1.0, 0.6, 0.2), ground=(0.1, 0.3, 0.5))
    random = np.random.default_rng(0)
    normal = random.normal(size=3)
    normal /= np.linalg.norm(normal)
    cosine, phi = np.meshgrid(1 - 2 * (np.arange(800) + 0.5) / 800, 2 * np.pi * (np.arange(800) + 0.5) / 800)
    sine = np.sqrt(1.0 - cosine**2)
    w = np.stack([sine * np.cos(phi), cosine, sine * np.sin(phi)], -1)
    radiance = np.where(w[..., 1:2] > 0.0, light.sky, light.ground)
    expected = (radiance * np.maximum(w @ normal, 0.0)[..., None]).mean((0, 1)) * 4.0 * np.pi / np.pi
    # Midpoints of 800² equal solid angles: the kink at the horizon leaves some 1e-5.
    np.testing.assert_allclose(light.irradiance_over_pi(normal), expected, atol=1e-4)


def test_sun_shines_on_what_faces_it() -> None:
    light = SkyLight((0, 0, 0), (0, 0, 0), (2.0, 1.0, 0.5), (0.0, 0.6, 0.8))
    np.testing.assert_allclose(light.irradiance_over_pi(np.array([0.0, 0.6, 0.8])), (2.0, 1.0, 0.5))
    np.testing.assert_allclose(light.irradiance_over_pi(np.array([0.0, 0.0, 1.0])), (1.6, 0.8, 0.4))
    np.testing.assert_allclose(light.irradiance_over_pi(np.array([0.0, -1.0, 0.0])), 0.0)
