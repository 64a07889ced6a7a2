"""Local light of rough parts, beside the same lookups in NumPy."""

from dataclasses import replace

import numpy as np
import pytest
from scenes import SKY, quad, torus, traced_pem
from surface_layers import looked_up, random_surface

from reflet.pem.pem import ParameterizedEnvironmentMap
from reflet.render.playback.renderer import Renderer
from reflet.render.playback.visibility import rasterized_visibility
from reflet.scene.material import Material
from reflet.scene.scene import Part
from reflet.scene.surfaces.surface import gbuffer_from_visibility
from reflet.scene.surfaces.surface_layer import SIDES


def rough_pem(roughness: float, side: int = 8, **options: bool) -> ParameterizedEnvironmentMap:
    metal = Material("metal", (0.65, 0.65, 0.65), 1.0, roughness, **options)
    pem = traced_pem(Part("torus", torus(), metal, True))
    return replace(pem, surface=random_surface(pem.scene, (0,), side=side))


@pytest.mark.parametrize("side", SIDES)
def test_light_is_that_of_sites_around_and_of_texels_around(side: int) -> None:
    """Of the middle of each pixel, over the share of the distant light that arrives; the mirrored ray does not lean."""
    pem = rough_pem(0.5, side)
    surface = pem.surface
    assert surface is not None and surface.side == side
    lifted = replace(surface, light=(surface.light + np.float16([1, 1, 1, 0])).astype(np.float16))  # is not cut at 0
    view, renderer = pem.space.orbit.camera({"azimuth_deg": 60.5}), Renderer(replace(pem, surface=lifted))
    shown = renderer.frame(view, samples=1, what="object", layers=("distant", "local")).reshape(-1, 4)
    seen = gbuffer_from_visibility(pem.scene, rasterized_visibility(renderer, view, 1))
    triangle, position = seen.triangle, seen.lookups[0].position[0].astype(float)
    mesh = pem.scene.parts[0].mesh
    corners, normals = (each[mesh.triangles[triangle]].astype(float) for each in (mesh.positions, mesh.normals))
    edges = corners[:, 1:] - corners[:, :1]
    b = np.stack([np.linalg.lstsq(e.T, p, rcond=None)[0] for e, p in zip(edges, position - corners[:, 0], strict=True)])
    normal = np.einsum("tk,tkc->tc", np.concatenate([1.0 - b.sum(1, keepdims=True), b], 1), normals)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    ray = position - view.position
    ray /= np.linalg.norm(ray, axis=-1, keepdims=True)
    mirrored = ray - 2.0 * (ray * normal).sum(-1, keepdims=True) * normal
    geometric = np.cross(edges[:, 0], edges[:, 1])
    geometric /= np.linalg.norm(geometric, axis=-1, keepdims=True)
    straight = (mirrored * geometric).sum(-1) > 2e-3  # others are bent
    light = looked_up(lifted, triangle, np.clip(b, 0.0, 1.0), mirrored)
    wanted = light[:, :3] + (1.0 - light[:, 3:]) * np.array(SKY)
    # float32 of positions within a triangle, over maps without any smoothness; the sky is stored in half floats
    np.testing.assert_allclose(shown[seen.row_pixel][straight, :3], wanted[straight], atol=4e-3)
    assert straight.sum() > 500


def test_smooth_parts_are_traced_instead() -> None:
    pem = rough_pem(0.15)
    view = pem.space.orbit.camera({"azimuth_deg": 60.5})
    with_maps, without = (Renderer(each).frame(view, samples=1) for each in (pem, replace(pem, surface=None)))
    np.testing.assert_array_equal(with_maps, without)


def test_samples_draw_their_rays_from_the_lobe() -> None:
    """A wall mirrored in a floor: by its edge some of a pixel's samples see it and some the sky, as of no mirror; of
    four samples a pixel all follow the peak."""
    floor = quad(np.array([(-0.5, 0.0, -0.5), (-0.5, 0.0, 0.5), (0.5, 0.0, 0.5), (0.5, 0.0, -0.5)]))
    wall = quad(np.array([(-0.5, 0.0, -0.5), (0.5, 0.0, -0.5), (0.5, 0.3, -0.5), (-0.5, 0.3, -0.5)]))
    dark = Material("dark", (0.0, 0.0, 0.0), 1.0, 0.0)
    mixed = {}
    for roughness in (0.0, 0.19):
        metal = Material("metal", (1.0, 1.0, 1.0), 1.0, roughness)
        pem = traced_pem(Part("floor", floor, metal, True), Part("wall", wall, dark, True))
        renderer = Renderer(pem)
        view = pem.space.orbit.camera({"azimuth_deg": 270.0, "elevation_deg": 30.0})
        for samples in (4, 16):
            picture = renderer.frame(view, samples=samples, what="object")
            share = picture[picture[..., 3] == 1.0][:, 1] / SKY[1]
            mixed[roughness, samples] = int(((share > 0.1) & (share < 0.9)).sum())
    assert mixed[0.19, 16] > 3 * mixed[0.0, 16] + 30, mixed
    assert mixed[0.19, 4] < 0.5 * mixed[0.19, 16], mixed


def test_without_local_light_the_sky_is_seen_whole() -> None:
    pem = rough_pem(0.5)
    view = pem.space.orbit.camera({"azimuth_deg": 60.5})
    seen = Renderer(pem).frame(view, samples=1, what="object", layers=("distant",))
    covered = seen[..., 3] == 1.0
    np.testing.assert_allclose(seen[covered][:, :3], np.tile(SKY, (covered.sum(), 1)), rtol=1e-3)  # half floats


def test_what_a_mirror_sees_has_it_too() -> None:
    """A mirror torus around a rough one: where traced rays end on that, its maps count."""
    thin = torus()
    inner = replace(thin, positions=(thin.positions * np.float32([0.5, 2.0, 0.5])).astype(np.float32))
    metal = Material("metal", (0.65, 0.65, 0.65), 1.0, 0.5)
    mirror = Material("mirror", (0.65, 0.65, 0.65), 1.0, 0.0)
    pem = traced_pem(Part("mirror", thin, mirror, True), Part("rough", inner, metal, True))
    dark = random_surface(pem.scene, (1,))
    dark = replace(dark, light=np.broadcast_to(np.float16([0, 0, 0, 1]), dark.light.shape).copy())
    view = pem.space.orbit.camera({"azimuth_deg": 60.5})
    lit, unlit = (Renderer(replace(pem, surface=each)).frame(view, samples=1, what="object") for each in (None, dark))
    part = np.full(lit.shape[:2], -1)
    seen = gbuffer_from_visibility(pem.scene, rasterized_visibility(Renderer(pem), view, 1))
    part.ravel()[seen.row_pixel] = seen.row_part
    assert (unlit[part == 1][:, :3] < 1e-6).all() and (lit[part == 1][:, :3] > 0.05).any()
    darker = unlit[part == 0][:, 1] < lit[part == 0][:, 1]
    assert 20 < darker.sum() < 0.7 * (part == 0).sum()  # what does not see it stays
    np.testing.assert_array_equal(unlit[part == 0][~darker], lit[part == 0][~darker])
