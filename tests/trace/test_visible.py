"""Which triangles sub-samples see, and which pixels objects may cover."""

import numpy as np
import pytest
from trace_scenes import CHROME, camera, constant_light, no_irradiance, quad, scene, sphere

from reflet.scene.material import Material, Refraction
from reflet.scene.scene import Part, Scene
from reflet.scene.views.camera import Camera
from reflet.scene.views.sample_pattern import sample_positions
from reflet.trace.device_scene import DeviceScene
from reflet.trace.footprint import covered_pixels
from reflet.trace.tracer import Tracer
from reflet.trace.variant import use_variant
from reflet.trace.visible import covered_share


def first_hits(what: Scene, view: Camera, count: int) -> np.ndarray:
    """Triangle that each sub-sample sees first by Möller and Trumbore's test in float64, -1 for none."""
    corners = np.concatenate([part.mesh.positions[part.mesh.triangles] for part in what.parts]).astype(np.float64)
    corner, dx, dy = view.ray_basis()
    y, x = np.divmod(np.arange(view.width * view.height), view.width)
    xy = np.stack([x, y], -1)[:, None, :] + sample_positions(count)
    d = (corner + xy[..., :1] * dx + xy[..., 1:] * dy).reshape(-1, 3)
    best, nearest = np.full(len(d), -1), np.full(len(d), np.inf)
    w = np.asarray(view.position)
    for k, (a, b, c) in enumerate(corners):
        e1, e2 = b - a, c - a
        h = np.cross(d, e2)
        det = h @ e1
        with np.errstate(divide="ignore", invalid="ignore"):
            u, q = (h @ (w - a)) / det, np.cross(w - a, e1)
            v, t = (d @ q) / det, (q @ e2) / det
            closer = (u >= 0) & (v >= 0) & (u + v <= 1) & (t > 0) & (t < nearest)
        best[closer], nearest[closer] = k, t[closer]
    return best.reshape(view.height * view.width, count)


def two_balls() -> Scene:
    back = quad((-1.5, -1.0, 0.3), (0, 2.0, 0), (3.0, 0, 0))  # seen from behind: a black wall
    parts = [
        Part("ball", sphere((0.5, 0, 0), 0.6, rows=8), CHROME, True),
        Part("wall", back, CHROME, True),
        Part("small", sphere((-0.6, 0.3, 0.6), 0.3, rows=8), CHROME, True),
    ]
    return scene(parts, [(0,), (1, 2)], constant_light(1.0))


def test_visibility_is_what_a_ray_cast_finds() -> None:
    what, view = two_balls(), camera(size=24)
    found = Tracer(what, irradiance=no_irradiance(what)).view(view, spp=1, sample_count=16).visibility
    expected = first_hits(what, view, 16)
    wall = slice(what.triangle_offsets[1], what.triangle_offsets[2])
    expected[(expected >= wall.start) & (expected < wall.stop)] = -1
    pixel, sub_sample = np.nonzero(expected >= 0)
    key, expected_key = found.pixel * 16 + found.sub_sample, pixel * 16 + sub_sample
    assert (np.diff(key) > 0).all()
    # rays within float32 rounding of an edge may fall to either side
    assert len(np.setxor1d(key, expected_key)) <= 0.002 * len(key)
    _, ours, theirs = np.intersect1d(key, expected_key, return_indices=True)
    assert (found.triangle[ours] == expected[pixel, sub_sample][theirs]).mean() > 0.998
    assert len(key) > 1000


def test_one_sample_is_the_pixels_centre() -> None:
    what, view = two_balls(), camera(size=24)
    tracer = Tracer(what, irradiance=no_irradiance(what))
    one, four = (tracer.view(view, spp=1, sample_count=count).visibility for count in (1, 4))
    assert not one.sub_sample.any()
    assert four.sub_sample.max() == 3
    assert abs(4 * len(one.pixel) - len(four.pixel)) < 0.05 * len(four.pixel)


def test_no_covered_pixel_is_missed_and_few_too_many_named() -> None:
    mesh, view = sphere((0.2, 0.1, 0), 0.8, rows=12), camera(size=32)
    what = scene([Part("ball", mesh, CHROME, True)], [(0,)], constant_light(1.0))
    covered = covered_pixels(view, mesh.positions, mesh.triangles).ravel()
    seen = (first_hits(what, view, 16) >= 0).any(1)
    assert not (seen & ~covered).any()
    # pixels touched between the samples only: at most a rim one pixel wide
    assert covered.sum() - seen.sum() < 4 * np.sqrt(seen.sum())


def test_thin_triangles_are_covered_whole_and_not_their_boxes() -> None:
    view = camera((0, 0, 4), size=32)
    line = np.array([[-1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [1.0, 1.001, 0.0]], np.float32)
    covered = covered_pixels(view, line, np.array([[0, 1, 2]], np.uint32))
    rows, columns = np.nonzero(covered)
    assert set(np.unique(rows)) == set(range(rows.min(), rows.max() + 1))
    assert (abs(rows + columns - 31) <= 1).all()


def test_triangles_behind_the_camera_are_left_out_and_those_around_it_cover_all() -> None:
    behind = np.array([[-1, 0, 9], [1, 0, 9], [0, 1, 9]], np.float32)
    around = np.array([[-1, -0.5, 9], [1, -0.5, 9], [0, -0.5, -9]], np.float32)
    triangle = np.array([[0, 1, 2]], np.uint32)
    view = camera((0, 0, 4), size=8)
    assert not covered_pixels(view, behind, triangle).any()
    assert covered_pixels(view, around, triangle).all()


def test_layers_without_a_seed_are_those_of_the_very_same_samples() -> None:
    what, view = two_balls(), camera((0, 0, 3.0), size=24)
    traced = Tracer(what, irradiance=no_irradiance(what)).view(view, spp=16, sample_count=16, seed=None)
    part = np.searchsorted(what.triangle_offsets, traced.visibility.triangle, side="right") - 1
    pixels = view.width * view.height
    seen = np.bincount(traced.visibility.pixel + pixels * part, minlength=pixels * len(what.parts))
    layers = traced.layers
    covered = np.zeros(seen.shape)
    covered[layers.pixel + pixels * layers.part] = layers.coverage
    assert np.array_equal(covered, (seen / 16.0).astype(np.float32))


def test_coverage_is_of_all_there_is_but_holes() -> None:
    """What glows, what is unlit, of thin glass, half transparent or masked, on the left half of a picture."""
    use_variant("llvm_ad_rgb")
    fov = float(np.degrees(2.0 * np.arctan(0.25)))
    view = Camera((0.0, 0.0, 4.0), (0.0, 0.0, 0.0), fov_deg=fov, width=8, height=8)
    square = quad((-1, -1, 0), (1.0, 0, 0), (0, 2, 0))
    for material, share in (
        (Material("lamp", emission=(3.0, 3.0, 3.0)), 1.0),
        (Material("plain", unlit=True), 1.0),
        (Material("sheet", refraction=Refraction(thin=True)), 1.0),
        (Material("veil", alpha=0.25, alpha_mode="blend"), 0.25),
        (Material("net", alpha=0.25, alpha_mode="mask"), 0.0),
    ):
        device = DeviceScene(scene([Part("square", square, material)], [], constant_light(1.0)))
        seen = covered_share(device, view, 16)
        # 512 sub-samples, let through by numbers spread evenly, tell a share to some per cent
        assert seen[:, :4].mean() == pytest.approx(share, abs=0.02 if 0.0 < share < 1.0 else 0.0)
        np.testing.assert_array_equal(seen[:, 4:], 0.0)
