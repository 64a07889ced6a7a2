"""Samples where they count: which pixels take how many, and that the rest is as ever."""

from dataclasses import replace

import numpy as np
import pytest
import wgpu
from scenes import MIRROR, analytic_map, mirror_torus_pem, pem_of, quad, random_map, scene_of, sphere

from reflet.envmap.geometry import InfiniteSphere
from reflet.errors import RefletError
from reflet.render.playback.renderer import Renderer
from reflet.render.playback.target import Target
from reflet.scene.material import Material
from reflet.scene.scene import Part
from reflet.scene.views.camera import Camera
from reflet.scene.views.sample_pattern import AT_REST, IN_MOTION, NAMED_SAMPLES, Adaptive, resolved_samples

SIZE = 32
FACING = Camera((0.0, 0.0, 1.0), (0.0, 0.0, 0.0), fov_deg=90.0, width=SIZE, height=SIZE)  # z = 0 from -1 to 1


def radiance_of(display: float) -> float:
    """The inverse of CONVENTIONS.md's sRGB(1 - exp(-1.6 radiance))."""
    linear = display / 12.92 if display <= 0.04045 else ((display + 0.055) / 1.055) ** 2.4
    return -np.log1p(-linear) / 1.6


def two_halves(left: float, right: float, boundary: float) -> Renderer:
    """A wall that emits, on either side of a pixel coordinate x; display values."""
    x = boundary / SIZE * 2 - 1

    def half(name: str, x0: float, x1: float, display: float) -> Part:
        light = Material(base_color=(0.0,) * 3, metallic=0.0, emission=(radiance_of(display),) * 3)
        return Part(name, quad(np.array([(x0, -2, 0), (x1, -2, 0), (x1, 2, 0), (x0, 2, 0)])), light)

    away = Part("ball", sphere(8, 16, 0.01), MIRROR, True)  # a PEM has an object; this one is behind the wall
    moved = replace(away.mesh, positions=away.mesh.positions - np.float32([0, 0, 3]))
    scene = scene_of(replace(away, mesh=moved), half("left", -2, x, left), half("right", x, 2, right))
    return Renderer(pem_of(scene, [random_map(8, 3, InfiniteSphere(), 0)]))


@pytest.mark.parametrize("samples", [AT_REST, IN_MOTION])
@pytest.mark.parametrize(
    ("boundary", "columns"), [(10.3, {9, 10, 11}), (10.0, {9, 10}), (0.5, {0, 1}), (31.5, {30, 31})]
)
def test_an_edge_takes_all_samples_and_what_is_smooth_the_first(
    samples: Adaptive, boundary: float, columns: set[int]
) -> None:
    """Where the edge runs, and beside it: between two pixels neither's own samples disagree."""
    renderer = two_halves(0.1, 0.9, boundary)
    renderer.frame(FACING, samples=samples)
    counts = renderer.samples_taken()
    expected = np.full((SIZE, SIZE), samples.first)
    expected[:, sorted(columns)] = samples.most
    np.testing.assert_array_equal(counts, expected)


@pytest.mark.parametrize(("right", "most"), [(0.5, 16), (0.79, 16), (0.81, 256)])
def test_samples_disagree_from_three_tenths_of_the_display_range_on(right: float, most: int) -> None:
    renderer = two_halves(0.5, right, 10.3)
    renderer.frame(FACING, samples="adaptive")
    assert renderer.samples_taken().max() == most


def test_white_takes_no_more() -> None:
    white = analytic_map(8, lambda d: np.ones(d.shape), InfiniteSphere())
    everywhere = np.array([(-2, -2, 0), (2, -2, 0), (2, 2, 0), (-2, 2, 0)])
    renderer = Renderer(pem_of(scene_of(Part("mirror", quad(everywhere), MIRROR, True)), [white]))
    frame = renderer.frame(FACING, samples="adaptive")
    assert (renderer.samples_taken() == 16).all()
    np.testing.assert_array_equal(frame, renderer.frame(FACING, samples=16))


def test_a_silhouette_counts_where_it_cannot_be_seen() -> None:
    """A black object's picture is all black, but its coverage is not."""
    black = analytic_map(8, lambda d: np.zeros(d.shape), InfiniteSphere())
    half = np.array([(-2, -2, 0), (0.03, -2, 0), (0.03, 2, 0), (-2, 2, 0)])  # up to x = 16.48
    renderer = Renderer(pem_of(scene_of(Part("mirror", quad(half), MIRROR, True)), [black]))
    coverage = renderer.frame(FACING, samples="adaptive", what="object")[..., 3]
    assert set(np.flatnonzero((renderer.samples_taken() == 256).any(0))) == {15, 16, 17}
    assert np.abs(coverage[:, 16] - 0.48).max() <= 1 / 64  # one of 64 columns more or less


@pytest.mark.parametrize(("samples", "first", "most"), [("adaptive", 16, 256), (IN_MOTION, 4, 16)])
@pytest.mark.parametrize("kind", ["picture", "object", "distant"])
def test_pixels_are_those_of_the_pictures_of_their_own_count(
    kind: str, samples: Adaptive | str, first: int, most: int
) -> None:
    """Nothing that depends on the number of samples is in this scene: no picture textures, no backdrop."""
    pem = mirror_torus_pem()
    renderer, camera = Renderer(pem), pem.space.camera(0)

    def drawn(count) -> np.ndarray:  # type: ignore[no-untyped-def]
        if kind == "distant":
            return renderer.layer_image(camera, "distant", samples=count)
        return renderer.frame(camera, samples=count, what=kind)

    plain = {count: drawn(count) for count in (first, most)}
    adaptive = drawn(samples)
    counts = renderer.samples_taken()
    for count, picture in plain.items():
        assert (counts == count).mean() > 0.05
        np.testing.assert_array_equal(adaptive[counts == count], picture[counts == count])
    np.testing.assert_array_equal(drawn(first), plain[first])  # nothing is left behind
    assert (renderer.samples_taken() == first).all()


def test_the_fast_path_takes_samples_where_they_count_too() -> None:
    pem = mirror_torus_pem()
    renderer, camera = Renderer(pem), pem.space.camera(0)
    all_256 = renderer.frame(camera, samples=256, exact=False)
    fast = renderer.frame(camera, samples="adaptive", exact=False)
    taken = renderer.samples_taken() == 256
    np.testing.assert_array_equal(fast[taken], all_256[taken])
    assert 0.05 < taken.mean() < 0.95
    with pytest.raises(RefletError, match="4 samples a pixel, not 4 to 16"):
        renderer.frame(camera, samples=IN_MOTION, multisampled=True)


def test_the_memory_of_a_target_is_what_it_says() -> None:
    """16 bytes a pixel of colour, 4 of depth, 16 of the sum; 12 more where samples are taken where they count."""
    pem = mirror_torus_pem()
    renderer, camera = Renderer(pem), replace(pem.space.camera(0), width=24, height=16)

    def bytes_a_pixel() -> float:
        target = renderer._target
        assert isinstance(target, Target)
        buffers = [each.size for each in vars(target).values() if isinstance(each, wgpu.GPUBuffer)]
        texel = {"rgba32float": 16, "depth32float": 4, "rgba16float": 8}
        textures = [texel[name] * count * 24 * 16 for name, count in target._textures]
        return (sum(buffers) + sum(textures)) / (24 * 16)

    for samples, multisampled, expected in ((16, False, 36), ("adaptive", False, 48), (4, True, 48 + 56)):
        renderer.frame(camera, samples=samples, multisampled=multisampled)
        assert bytes_a_pixel() == expected


def test_counts_are_those_of_a_picture() -> None:
    with pytest.raises(RefletError, match="ask for a frame first"):
        Renderer(mirror_torus_pem()).samples_taken()


def test_samples_go_by_name_and_others_are_refused() -> None:
    pem = mirror_torus_pem()
    renderer, camera = Renderer(pem), pem.space.camera(0)
    for name, meant in NAMED_SAMPLES.items():
        renderer.frame(camera, samples=name)
        assert set(np.unique(renderer.samples_taken())) == {meant.first, meant.most}
    for odd in (0, 5, "fast"):
        with pytest.raises(RefletError, match="1, 4, 16, 64 or 256, or one of adaptive, quick, motion, not"):
            resolved_samples(odd)
