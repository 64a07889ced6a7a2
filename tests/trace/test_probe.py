"""Static probes: distances, radiance and what is taken away."""

import numpy as np
import pytest
from trace_scenes import CHROME, constant_light, no_irradiance, room, scene, sphere

from reflet.envmap.mip_chain import MipChain
from reflet.envmap.parameterizations.cube import texel_directions, texel_solid_angle
from reflet.scene.material import Material
from reflet.scene.scene import Part
from reflet.trace.layers import Shells
from reflet.trace.tracer import Tracer

GLOW = Material("glow", base_color=(0, 0, 0), metallic=0.0, emission=(0.5, 1.0, 1.5))


def test_probe_in_a_room_without_its_object() -> None:
    what = scene([Part("ball", sphere(radius=0.5, rows=8), CHROME, True), Part("room", room(2.0), GLOW)], [(0,)])
    probe = Tracer(what, irradiance=no_irradiance(what)).probe(0, Shells((0.0, 0.5, 0.0)), size=16, spp=4)
    np.testing.assert_allclose(probe.texels, np.tile([[0.5, 1.0, 1.5]], (len(probe.texels), 1)), rtol=1e-6)
    d = texel_directions(16)
    walls = np.where(d > 0, (2.0 - np.array([0, 0.5, 0])) / d, (-2.0 - np.array([0, 0.5, 0])) / d)
    np.testing.assert_allclose(probe.distance, walls.min(-1), rtol=1e-5)


def test_probe_sees_other_objects_mirror_and_nothing_as_infinite() -> None:
    balls = [Part("a", sphere(radius=0.5, rows=16), CHROME, True), Part("b", sphere((3, 0, 0), 1.0), CHROME, True)]
    what = scene(balls, [(0,), (1,)], constant_light(1.0))
    probe = Tracer(what, irradiance=no_irradiance(what)).probe(0, Shells((0.0, 0.0, 0.0)), size=16, spp=4)
    hit = np.isfinite(probe.distance)
    # a sphere of radius 1 three metres away fills 2π(1 - cos asin 1/3)
    solid_angle = (hit * texel_solid_angle(16)).sum()
    assert solid_angle == pytest.approx(2 * np.pi * (1 - np.sqrt(1 - 1 / 9)), rel=0.1)  # texels are counted whole
    chain = MipChain(16)
    # the middle texels of face px, off the axis by 1/16 either way; 48 rows of triangles flatten the ball by 1e-3
    cosine = 1.0 / np.sqrt(1.0 + 2.0 / 256.0)
    expected = 3.0 * cosine - np.sqrt(9.0 * cosine**2 - 8.0)
    np.testing.assert_allclose(probe.distance[0, 7:9, 7:9], expected, atol=2e-3)
    finest = chain.level(probe.texels, 0)
    assert (finest[~hit][:, 0] == 1.0).mean() > 0.97  # texels on the rim are hit by some of their rays only
    assert finest[0, 6, 8, 0] == pytest.approx(0.65, abs=0.01)
    # coarser levels keep the mean over the sphere
    for level in range(5):
        texels = chain.level(probe.texels, level)[..., 0]
        mean = (texels * texel_solid_angle(texels.shape[1])).sum() / (4 * np.pi)
        assert mean == pytest.approx((finest[..., 0] * texel_solid_angle(16)).sum() / (4 * np.pi), rel=1e-5)


def test_probe_with_nothing_else_in_the_scene() -> None:
    what = scene([Part("ball", sphere(rows=8), CHROME, True)], [(0,)], constant_light(2.0))
    probe = Tracer(what, irradiance=no_irradiance(what)).probe(0, Shells((0.0, 0.0, 0.0)), size=4, spp=4)
    np.testing.assert_allclose(probe.texels, 2.0, rtol=1e-6)
    assert np.isinf(probe.distance).all()


def test_a_probe_inside_of_something_sees_what_is_outside() -> None:
    """A globe around a closed core: its backs do not make the map black. Backs farther off are, as for any ray."""
    globe, core = Part("globe", sphere(rows=8), CHROME, True), Part("core", sphere(radius=0.2, rows=8), GLOW)
    what = scene([globe, core], [(0,)], constant_light(2.0))
    probe = Tracer(what, irradiance=no_irradiance(what)).probe(0, Shells((0.0, 0.0, 0.0)), size=8, spp=4)
    np.testing.assert_allclose(probe.texels, 2.0, rtol=1e-6)
    assert np.isinf(probe.distance).all()
    shell = Part("shell", sphere(radius=3.0, rows=16), GLOW)
    what = scene([globe, core, shell], [(0,)], constant_light(2.0))
    probe = Tracer(what, irradiance=no_irradiance(what)).probe(0, Shells((0.0, 0.0, 0.0)), size=8, spp=4)
    met = np.isfinite(probe.distance)
    assert met.mean() > 0.95  # a ray along an edge may slip through
    np.testing.assert_allclose(probe.distance[met], 3.0, rtol=0.03)  # 16 rows of flat triangles
    assert np.median(MipChain(8).level(probe.texels, 0)) == 0.0
