"""What lobes gather at sites: closed forms, furnaces, and the same as pixels see."""

import numpy as np
import pytest
from trace_scenes import camera, constant_light, no_irradiance, quad, scene, sphere

from reflet.scene.material import Material
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.scene import Part, Scene
from reflet.scene.surfaces.surface_layer import SIDES, texel_directions
from reflet.trace.gloss.surface_light import DEEPEST, LEAST_RISE
from reflet.trace.layers import TracedSurface
from reflet.trace.tracer import Tracer

METAL = Material("metal", (1.0, 1.0, 1.0), 1.0, 0.5)
GLOW = Material("glow", (0.0, 0.0, 0.0), 1.0, 0.5, emission=(3.0, 2.0, 1.0))


SITES = 300  # about: enough for what is asked here of each, and of their means


def traced(what: Scene, parts: tuple[int, ...] = (0,), spp: int = 32) -> TracedSurface:
    return Tracer(what, irradiance=no_irradiance(what)).surface(parts, spp=spp, budget=SITES)


def test_a_convex_body_sees_the_sky_alone() -> None:
    found = traced(scene([Part("ball", sphere(rows=12), METAL, True)], [(0,)], constant_light(0.7)))
    assert not found.local.any()
    np.testing.assert_allclose(found.distant, 0.7, rtol=1e-5)
    np.testing.assert_allclose(np.linalg.norm(found.position, axis=1), 1.0, atol=0.02)  # facets
    rise = np.einsum("rc,rc->r", found.normal[found.row_site], found.mirrored)
    # the tails of lobes that go below a facet are hidden, few where they are looked at from above
    assert found.alpha[rise > 0.7].mean() < 2e-3 and found.alpha.mean() < 0.1
    assert rise.min() > LEAST_RISE - 1e-3  # made unit vectors afterwards
    assert set(zip(found.row_site.tolist(), found.row_texel.tolist(), strict=True)) == {
        (site, texel)
        for site, normal in enumerate(found.normal)
        for texel in np.flatnonzero(texel_directions(SIDES[0]) @ normal > -DEEPEST)
    }


def floor_under_glow() -> Scene:
    """A small floor whose sky is all but filled by another part of its object, which shines."""
    floor = Part("floor", quad((-0.1, 0.0, -0.1), (0.0, 0.0, 0.2), (0.2, 0.0, 0.0)), METAL, True)
    roof = Part("roof", quad((-50.0, 0.5, -50.0), (100.0, 0.0, 0.0), (0.0, 0.0, 100.0)), GLOW, True)
    return scene([floor, roof], [(0, 1)], constant_light(1.0))


def test_what_is_hidden_is_local() -> None:
    """Upwards no lobe of roughness 0.5 misses the roof: alpha 1 and the roof's own light, times no Fresnel term."""
    found = traced(floor_under_glow())
    upwards = found.mirrored[:, 1] > 0.6
    assert upwards.sum() > 100
    np.testing.assert_allclose(found.alpha[upwards], 1.0, atol=0.01)  # what slips past its edge at 0.6°
    # noise of emitters' and rays' samples of 32
    np.testing.assert_allclose(found.local[upwards].mean(0), (3.0, 2.0, 1.0), rtol=0.02)
    assert (np.abs(found.local[upwards] - (3.0, 2.0, 1.0)) < 0.5).all()


def test_a_white_furnace_stays_white() -> None:
    """In a hollow of white metal, whose lobes see it and the sky: local + (1 - alpha)·distant is 1."""
    ring = sphere(rows=24)
    inside = ring.positions[ring.triangles].mean(1)[:, 1] < 0.0  # the lower half, its front inside
    bowl = Mesh(ring.positions, -ring.normals, ring.triangles[inside][:, ::-1].copy())
    found = traced(scene([Part("bowl", bowl, METAL, True)], [(0,)], constant_light(1.0)), spp=64)
    shown = found.local + (1.0 - found.alpha[:, None]) * found.distant
    assert found.alpha.mean() > 0.3
    # eight bounces at random, of the last nothing: each row has some noise, none has a bias
    np.testing.assert_allclose(shown.mean(0), 1.0, atol=0.01)
    assert np.abs(shown - 1.0).mean() < 0.05


def test_sites_see_what_pixels_see() -> None:
    """The floor from above, looked at so that it mirrors the viewer along a texel's direction."""
    what = floor_under_glow()
    found = traced(what, spp=512)
    texel = int(np.argmax(texel_directions(SIDES[0]) @ (0.5, 0.7, 0.3)))
    along = texel_directions(SIDES[0])[texel]
    eye = 0.4 * np.array([-along[0], along[1], -along[2]])
    layers = Tracer(what, irradiance=no_irradiance(what)).view(camera(tuple(eye), 16), spp=512).layers
    rows = (layers.part == 0) & (layers.coverage == 1.0)
    site = int(np.argmin(np.linalg.norm(found.position, axis=1)))
    (row,) = np.flatnonzero((found.row_site == site) & (found.row_texel == texel))
    near = np.argsort(np.abs(layers.pixel[rows] - 8 * 16 - 8))[:4]
    for ours, theirs in ((found.local[row], layers.local[rows]), (found.alpha[row], layers.alpha[rows])):
        np.testing.assert_allclose(ours, theirs[near].mean(0), rtol=0.05, atol=0.02)  # noise; pixels lie beside it


def test_the_same_seed_gives_the_same_bytes() -> None:
    one, other = traced(floor_under_glow(), spp=8), traced(floor_under_glow(), spp=8)
    for name, value in vars(one).items():
        np.testing.assert_array_equal(value, getattr(other, name))
    assert one.row_texel.max() < one.side**2


@pytest.mark.parametrize("double_sided", [False, True])
def test_backs_have_sites_of_their_own_where_they_are_seen(double_sided: bool) -> None:
    floor = quad((-0.1, 0.0, -0.1), (0.0, 0.0, 0.2), (0.2, 0.0, 0.0))
    metal = Material("metal", (1.0, 1.0, 1.0), 1.0, 0.5, double_sided=double_sided)
    found = traced(scene([Part("floor", floor, metal, True)], [(0,)], constant_light(1.0)), spp=4)
    assert (found.normal[:, 1] < 0.0).any() == double_sided
    np.testing.assert_allclose(found.distant, 1.0, rtol=1e-5)
