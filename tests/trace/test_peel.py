"""Shells of distant light: what rays meet with all that is nearer taken away, in closed forms."""

from dataclasses import fields

import numpy as np
import pytest
from trace_scenes import CHROME, Vec3, camera, constant_light, no_irradiance, quad, room, scene, sphere

from reflet.envmap.parameterizations.cube import texel_directions
from reflet.scene.material import EnvironmentLight, Material
from reflet.scene.scene import Part, Scene
from reflet.trace.layers import SegmentedLayers, Shells, StaticProbe
from reflet.trace.tracer import Tracer

ORIGIN = (0.0, 0.0, 0.0)
SKY = 7.0
RADII = (1.0, 2.0, 3.0, 4.0, 5.0)
BALL = Part("ball", sphere(radius=0.3, rows=16), CHROME, True)


def glow(radiance: float, double_sided: bool = True) -> Material:
    return Material(f"glow {radiance}", (0, 0, 0), 0.0, emission=(radiance,) * 3, double_sided=double_sided)


def layers_of(
    what: Scene, *shells: Shells, spp: int = 4, size: int = 24, eye: Vec3 = (0.0, 0.3, 1.5)
) -> SegmentedLayers:
    tracer = Tracer(what, irradiance=no_irradiance(what))
    return tracer.view(camera(eye, size), spp=spp, shells=shells or None).layers


def probe_of(what: Scene, shells: Shells, size: int = 8, spp: int = 4) -> StaticProbe:
    return Tracer(what, irradiance=no_irradiance(what)).probe(0, shells, size=size, spp=spp)


@pytest.fixture(scope="module")
def nested() -> Scene:
    """Five spheres around a ball, each as bright as its radius, under a sky of 7. Rays may slip past an edge of
    triangles that they meet exactly: with 37 rows no texel looks along one."""
    spheres = [Part(f"sphere {r}", sphere(radius=r, rows=37), glow(r)) for r in RADII]
    return scene([BALL, *spheres], [(0,)], constant_light(SKY))


@pytest.mark.parametrize(
    ("ends", "expected"),
    [
        ((), (1.0,)),
        ((0.5,), (None, 1.0)),
        ((2.5,), (1.0, 3.0)),
        ((4.5,), (1.0, 5.0)),  # four surfaces between
        ((9.0,), (1.0, SKY)),
        ((1.5, 3.5), (1.0, 2.0, 4.0)),
        ((0.5, 0.7), (None, None, 1.0)),
        ((2.5, 2.7), (1.0, None, 3.0)),  # nothing stands between these
        ((5.5, 6.0), (1.0, None, SKY)),
    ],
)
def test_a_shell_holds_the_first_beyond_its_beginning(
    nested: Scene, ends: tuple[float, ...], expected: tuple[float | None, ...]
) -> None:
    """For rays from the mirror and for the probe alike."""
    shells = Shells(ORIGIN, ends)
    tracer = Tracer(nested, irradiance=no_irradiance(nested))
    layers = tracer.view(camera((0.0, 0.2, 0.9), 24), spp=4, shells=[shells]).layers
    probe = tracer.probe(0, shells, size=8, spp=4)
    assert len(layers.pixel) > 100 and layers.shells.shape[1] == len(probe.shells) == len(expected)
    np.testing.assert_allclose(layers.distant, 1.0, rtol=1e-6)
    np.testing.assert_allclose(probe.texels, 1.0, rtol=1e-6)
    for number, radiance in enumerate(expected):
        light, present = (0.0, 0.0) if radiance is None else (radiance, 1.0)
        np.testing.assert_allclose(layers.shells[:, number, :3], light, rtol=1e-6)
        np.testing.assert_array_equal(layers.shells[:, number, 3], present)
        held = probe.shells[number]
        np.testing.assert_allclose(held.texels[:, :3], light, rtol=1e-6)
        assert held.texels.shape[1] == (3 if number == len(ends) else 4)
        if held.texels.shape[1] == 4:
            np.testing.assert_allclose(held.texels[:, 3], present, rtol=1e-6)  # coarser levels are float32 means
        if radiance in (None, SKY):
            assert np.isinf(held.distance).all()
        else:  # 37 rows of facets lie up to 1 - cos²(π/74) = 0.2 % inside the sphere
            assert (held.distance <= radiance * (1 + 1e-6)).all() and (held.distance > 0.995 * radiance).all()
    np.testing.assert_array_equal(probe.distance, np.min([shell.distance for shell in probe.shells], 0))


def test_distance_counts_from_the_origin_of_the_shells() -> None:
    """Of a sphere around 0, what lies nearer than 1 to (0.5, 0, 0) has x > 1/4."""
    what = scene([BALL, Part("sphere", sphere(rows=37), glow(1.0)), Part("outer", room(3.0), glow(3.0))], [(0,)])
    shells = Shells((0.5, 0.0, 0.0), (1.0,))
    near, far = probe_of(what, shells, size=16, spp=1).shells
    d = texel_directions(16)
    along = 0.5 * d[..., 0]
    distance = -along + np.sqrt(along**2 + 0.75)
    x = 0.5 + distance * d[..., 0]
    inside = x > 0.25
    sure = np.abs(x - 0.25) > 0.01  # facets are 0.2 % nearer
    np.testing.assert_array_equal(np.isfinite(near.distance)[sure], inside[sure])
    np.testing.assert_allclose(near.distance[inside & sure], distance[inside & sure], rtol=5e-3)
    np.testing.assert_allclose(far.distance[~inside & sure], distance[~inside & sure], rtol=5e-3)
    assert (far.distance[inside & sure] > 2.4).all()
    # and along the mirrored rays, which start elsewhere: from the outer sphere where the inner one was near
    rows = layers_of(what, shells, spp=1, eye=(0.0, 0.2, 0.9))
    is_near = rows.shells[:, 0, 3] == 1.0
    assert 20 < is_near.sum() < len(is_near) - 20
    np.testing.assert_allclose(rows.shells[:, 1, 0], np.where(is_near, 3.0, 1.0), rtol=1e-6)


def test_backs_of_single_sided_faces_are_black_and_opaque_in_shells() -> None:
    """The sphere of radius 1 shows its back, that of radius 3 its front: behind a black near shell the far one."""
    parts = [BALL, Part("back", sphere(), glow(1.0, False)), Part("room", room(3.0), glow(3.0, False))]
    layers = layers_of(scene(parts, [(0,)]), Shells(ORIGIN, (2.0,)), eye=(0.0, 0.2, 0.9))
    np.testing.assert_array_equal(layers.shells[:, 0], np.tile([0.0, 0.0, 0.0, 1.0], (len(layers.pixel), 1)))
    np.testing.assert_allclose(layers.shells[:, 1, :3], 3.0, rtol=1e-6)
    assert not layers.distant.any()


def varied() -> Scene:
    """A ball that sees itself in a knob, panels near and less near, some before others, in a room with a window."""
    light = EnvironmentLight(np.random.default_rng(0).random((8, 16, 3), np.float32))
    panels = [
        Part("left", quad((-0.9, -0.6, -0.6), (0, 0, 1.2), (0, 1.1, 0)), glow(2.0)),
        Part("behind", quad((-1.3, -0.9, -1.6), (0, 0, 2.2), (0, 1.5, 0.3)), glow(0.5, False)),
        Part("above", quad((-0.3, 1.2, -0.3), (0.5, 0, 0), (0, 0, 0.6)), glow(4.0)),
        Part("wall", quad((-3.0, -3.0, -3.0), (6.0, 0, 0), (0, 6.0, 0)), glow(1.0)),
        Part("floor", quad((-3.0, -2.0, -3.0), (0, 0, 5.0), (6.0, 0, 0)), glow(0.25)),
    ]
    knob = Part("knob", sphere((0.0, 0.36, 0.05), 0.1, rows=12), CHROME, True)
    other = Part("other", sphere((0.42, 0.1, 0.0), 0.12, rows=16), CHROME, True)
    return scene([BALL, knob, other, *panels], [(0, 1), (2,)], light)


SHELLS = [Shells(ORIGIN, (1.1, 2.2)), Shells((0.42, 0.1, 0.0), (1.0,))]


def test_each_ray_sees_the_nearest_shell_that_is_there() -> None:
    layers = layers_of(varied(), *SHELLS, spp=1, size=40)
    shells = layers.shells.astype(np.float64)
    seen, clear = np.zeros((len(shells), 3)), np.ones((len(shells), 1))
    for number in range(3):
        assert set(np.unique(shells[:, number, 3])) <= {0.0, 1.0}
        seen += clear * shells[:, number, :3]
        clear = clear * (1.0 - shells[:, number, 3:])
    np.testing.assert_allclose(seen, layers.distant, rtol=1e-6)
    assert not clear.any(), "the last shell hides all behind it"
    ball = layers.part < 2
    assert 0.1 < shells[ball, 0, 3].mean() < 0.9 and 0.02 < shells[ball, 1, 3].mean() < 0.98
    assert layers.alpha.max() == 1.0, "what an object sees of itself does not take its shells away"
    assert shells[layers.alpha == 1.0].sum() > 0.0


def test_shells_are_means_over_the_row_and_the_light_does_not_depend_on_them() -> None:
    what = varied()
    divided, whole = layers_of(what, *SHELLS, spp=16, size=40), layers_of(what, spp=16, size=40)
    for name in ("pixel", "part", "coverage", "diffuse", "fresnel", "local", "alpha"):
        np.testing.assert_array_equal(getattr(divided, name), getattr(whole, name))
    # another kernel: rounding, seldom an edge that turns the other way
    assert np.mean(np.abs(divided.distant - whole.distant).max(1) > 1e-4) < 0.01
    # alpha is a share of the row's samples, and where the near shell is of one brightness, its light times that
    samples = np.round(divided.coverage * 16)
    share = divided.shells[..., 3] * samples[:, None]
    np.testing.assert_allclose(share, np.round(share), atol=1e-4)
    partly = (divided.shells[:, 0, 3] > 0.0) & (divided.shells[:, 0, 3] < 1.0)
    assert partly.sum() > 20
    only = layers_of(
        scene([BALL, Part("panel", quad((-0.9, -0.6, -0.6), (0, 0, 1.2), (0, 1.1, 0)), glow(2.0))], [(0,)]),
        Shells(ORIGIN, (2.0,)), spp=16,
    )  # fmt: skip
    np.testing.assert_allclose(only.shells[:, 0, :3], 2.0 * only.shells[:, 0, 3:] * np.ones(3), rtol=1e-5)
    np.testing.assert_allclose(only.distant, only.shells[:, 0, :3], rtol=1e-6)
    assert not only.shells[:, 1, :3].any()  # nothing is behind, and there is no sky


def test_one_shell_is_the_distant_layer() -> None:
    layers = layers_of(varied(), spp=4)
    assert layers.shells.shape[1:] == (1, 4)
    np.testing.assert_array_equal(layers.shells[:, 0, :3], layers.distant)
    np.testing.assert_array_equal(layers.shells[:, 0, 3], 1.0)


def test_objects_have_as_many_shells_as_they_are_told() -> None:
    """The other object's rows have none where it has fewer, and it is what it is alone."""
    what = varied()
    layers = layers_of(what, *SHELLS)
    other = layers.part == 2
    assert layers.shells.shape[1] == 3 and other.any() and not other.all()
    assert not layers.shells[other, 2].any() and layers.shells[~other, 2].any()
    np.testing.assert_array_equal(layers.shells[other, 1, 3], 1.0)
    mirrored = layers_of(what, SHELLS[0], Shells(ORIGIN))
    np.testing.assert_array_equal(layers.shells[~other], mirrored.shells[~other])
    np.testing.assert_array_equal(mirrored.shells[other, 1:], 0.0)


def test_the_same_call_gives_the_same_bytes() -> None:
    first, again = (layers_of(varied(), *SHELLS) for _ in range(2))
    for field in fields(SegmentedLayers):
        np.testing.assert_array_equal(getattr(first, field.name), getattr(again, field.name))
    probes = [probe_of(varied(), SHELLS[0]) for _ in range(2)]
    for one, other in zip(probes[0].shells, probes[1].shells, strict=True):
        np.testing.assert_array_equal(one.texels, other.texels)
        np.testing.assert_array_equal(one.distance, other.distance)


def test_where_only_the_object_is_its_shells_are_the_sky() -> None:
    what, shells = scene([BALL], [(0,)], constant_light(SKY)), Shells(ORIGIN, (1.0, 2.0))
    layers, probe = layers_of(what, shells), probe_of(what, shells)
    assert not layers.shells[:, :2].any()
    np.testing.assert_allclose(layers.shells[:, 2], np.tile([SKY, SKY, SKY, 1.0], (len(layers.pixel), 1)), rtol=1e-6)
    assert all(np.isinf(shell.distance).all() for shell in probe.shells)
    assert not probe.shells[0].texels.any() and not probe.shells[1].texels.any()
    np.testing.assert_allclose(probe.shells[2].texels, SKY, rtol=1e-6)
    dark = layers_of(scene([BALL], [(0,)]), shells)
    assert len(dark.pixel) and not dark.shells[..., :3].any() and (dark.shells[:, 2, 3] == 1.0).all()


def test_probe_alphas_are_shares_of_texels_and_their_coarser_means() -> None:
    """A half space of panel: the near shell's alpha over all directions is its solid angle."""
    panel = Part("panel", quad((1.0, -40.0, -40.0), (0, 0, 80.0), (0, 80.0, 0)), glow(2.0))
    near, far = probe_of(scene([BALL, panel], [(0,)], constant_light(SKY)), Shells(ORIGIN, (100.0,)), 16, 64).shells
    level = near.texels[: 6 * 256].reshape(6, 16, 16, 4)
    np.testing.assert_allclose(level[..., :3], 2.0 * level[..., 3:] * np.ones(3), rtol=1e-5)
    np.testing.assert_array_equal(level[0, ..., 3], 1.0)
    np.testing.assert_array_equal(level[1], 0.0)
    # beside px the panel goes on to x = 1/40 of the way: on the other faces to 20·(1 - 1/40) of 16 columns or rows
    assert level[4, ..., 3].mean() == pytest.approx(0.5 - 0.5 / 40.0, abs=1 / 128)  # of 64 rays a texel
    np.testing.assert_allclose(far.texels, SKY, rtol=1e-6)
    assert near.texels[-6:, 3].max() == pytest.approx(1.0) and near.texels[-5, 3] == 0.0
