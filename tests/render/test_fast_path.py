"""The fast path beside the exact one: the same pictures but for rounding and silhouettes."""

from dataclasses import replace

import numpy as np
import pytest
from scenes import MIRROR, analytic_map, pem_of, quad, random_map, scene_of, torus
from small_pem import small_pem

from reflet.envmap.geometry import Ellipsoid, InfiniteSphere
from reflet.render.playback.renderer import Renderer
from reflet.render.playback.visibility import rasterized_visibility
from reflet.report.measures import display_psnr
from reflet.scene.scene import Part
from reflet.scene.views.camera import Camera

FLOOR = [(-1, 0, 1), (1, 0, 1), (1, 0, -1), (-1, 0, -1)]


@pytest.mark.parametrize("multisampled", [False, True])
@pytest.mark.parametrize("what", ["object", "picture"])
def test_pictures_with_all_kinds_of_surfaces_agree(what, multisampled) -> None:  # type: ignore[no-untyped-def]
    """Mirrors with and without normal map, two layers, hull, two samples blended; textured walls with mesh colours."""
    pem = small_pem()
    renderer = Renderer(pem)
    camera = pem.space.orbit.camera({"azimuth_deg": 61.0})
    exact, fast = (
        renderer.frame(camera, samples=4, what=what, multisampled=multisampled, exact=path) for path in (True, False)
    )
    covered = exact[..., 3] > 0.5
    np.testing.assert_allclose(fast[..., 3], exact[..., 3], atol=0.25)  # nothing but a sub-sample's own half of an edge
    # Silhouettes seen edge-on, where the exact path cuts planes off and derivatives blow up, are what differs: measured
    # 60 dB, 56 dB with four samples at once. Losing the tangents leaves
    # 47 dB, swapped mesh colours 28.
    assert display_psnr(exact[..., :3], fast[..., :3], covered) > 50
    difference = np.abs(exact - fast)[covered]
    # Float32 interpolation, of attributes of order 1, and texel gradients of order 1; half floats where multi-sampled.
    assert np.median(difference) < (5e-4 if multisampled else 1e-6)
    assert covered.mean() > 0.1


# Finest level: a sub-sample lies 1e-7 off, its normal too; a texel is 1/16 wide, its neighbour differs by 2: 1e-5, more
# at silhouettes. Coarse levels: derivatives are differences over a pixel, which perspective bends by some 1/300 a
# pixel where surfaces are steep; LODs are that much off, and levels differ by up to 2. (Neighbours whose normals stay
# the same: 0.19; a whole pixel away: 0.10.)
@pytest.mark.parametrize(("lod_bias", "tolerance"), [(-1.0, 1e-3), (2.5, 0.03)])
def test_interiors_of_triangles_agree_under_random_maps(lod_bias, tolerance) -> None:  # type: ignore[no-untyped-def]
    """Neighbouring texels differ as much as they can: any error in position, normal, LOD or hull flag shows."""
    scene = scene_of(Part("torus", torus(), MIRROR, True))
    ellipsoid = Ellipsoid((0, 0, 0), (0.5, 0.2, 0.5), (0, 0, 0))
    on_hull = np.random.default_rng(0).random(scene.triangle_offsets[-1]) < 0.5
    maps = [random_map(32, 3, InfiniteSphere(), k) for k in range(2)], [random_map(32, 4, ellipsoid, k) for k in (2, 3)]
    renderer = Renderer(pem_of(scene, *maps, on_hull=on_hull, lod_bias=lod_bias, image_size=128))
    camera = renderer.pem.space.orbit.camera({"azimuth_deg": 60.5})
    exact, fast = (renderer.frame(camera, samples=1, exact=path).reshape(-1, 4) for path in (True, False))
    seen = rasterized_visibility(renderer, camera, 1)
    for chosen in (on_hull[seen.triangle], ~on_hull[seen.triangle]):
        difference = np.abs(exact - fast)[seen.pixel[chosen]].max(-1)
        assert np.percentile(difference, 94) < tolerance
        assert len(difference) > 500
    assert not renderer.frame(camera, samples=1, exact=False, layers=()).reshape(-1, 4)[:, :3].any()


def test_backs_of_single_sided_faces_are_black() -> None:
    bright = analytic_map(8, lambda d: np.ones(d.shape), InfiniteSphere())
    below = Camera((0.0, -1.0, 0.3), (0, 0, 0), width=8, height=8)
    for double_sided in (False, True):
        floor = Part("floor", quad(FLOOR), replace(MIRROR, double_sided=double_sided), True)
        renderer = Renderer(pem_of(scene_of(floor), [bright]))
        exact, fast = (renderer.frame(below, exact=path) for path in (True, False))
        np.testing.assert_allclose(fast, exact, atol=1e-6)  # a constant map: float32's rounding of F
        assert (fast[4, 4, 0] > 0.6) == double_sided and fast[4, 4, 3] == 1.0
        assert renderer.frame(below, what="object", exact=False)[4, 4, 3] == double_sided
