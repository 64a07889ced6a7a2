"""Maps shown as they are, and drawn levels, measured in pictures."""

from dataclasses import replace

import numpy as np
import pytest
from map_scenes import analytic_levels, linear, sphere_reflections, view_rays

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.by_name import parameterization
from reflet.envmap.parameterizations.dual_paraboloid import DualParaboloid
from reflet.npr.drawing import drawn_levels
from reflet.npr.silhouette import Silhouette
from reflet.pipelines.sketch import on_paper, sketch
from reflet.reflectance.materials.map_material import Lookup
from reflet.render.materials.env_map_renderer import view_frame
from reflet.scene.meshes.primitives import sphere_mesh
from reflet.scene.views.camera import Camera

CAMERA = Camera((1.5, 1.2, 2.6), (0.0, 0.0, 0.0), fov_deg=50, width=72, height=60)
SIZE = 128
WIDTH = 2.5
SPHERE = sphere_mesh(around=256)


def seen(ray: np.ndarray, direction: np.ndarray, camera: Camera) -> np.ndarray:
    """Directions of the world in the frame of each pixel's viewer."""
    z = -ray
    x = np.broadcast_to(camera.frame()[0], z.shape)
    x = x - np.einsum("...i,...i->...", x, z)[..., None] * z
    x /= np.linalg.norm(x, axis=-1, keepdims=True)
    return np.stack([np.einsum("...i,...i->...", direction, axis) for axis in (x, np.cross(z, x), z)], -1)


@pytest.mark.parametrize("lookup", Lookup)
@pytest.mark.parametrize("kind", ["cube", "octahedral"])
def test_maps_are_looked_up_as_told(lookup: Lookup, kind: str) -> None:
    levels = analytic_levels(parameterization(kind), 64)
    turn = view_frame(Camera((1.0, 2.0, 0.5), (0.0, 0.0, 0.0)))
    picture = sketch(SPHERE, levels, CAMERA, lookup, samples=1, map_from_world=turn)
    ray = view_rays(CAMERA)
    direction, cosine = sphere_reflections(CAMERA)
    usable = np.isfinite(cosine) & (cosine > 0.6)
    if lookup in (Lookup.NORMAL, Lookup.VIEW_NORMAL):
        direction = direction - ray
        direction /= np.linalg.norm(direction, axis=-1, keepdims=True)
    by_view = lookup in (Lookup.VIEW_REFLECTION, Lookup.VIEW_NORMAL)
    direction = seen(ray, direction, CAMERA) if by_view else direction @ turn.T
    # Texels are as wide as a pixel sees, up to 0.25 radians: interpolated between them a slope of 0.5 errs by
    # 0.5·(0.25)²/8, and octahedral maps' kinks count an eighth of a texel. Another lookup would be off by 0.1 and more.
    np.testing.assert_allclose(picture[usable][:, :3], linear(direction[usable]), atol=1.6e-2)


def outline(radius: float, levels: tuple[EnvImage, ...], samples: int, size: int = 192) -> np.ndarray:
    """Width of the line around a ball of this radius in pixels, from the ink in each of eight sectors."""
    distance = np.hypot(1.0, 0.5 * size / (radius * np.tan(np.radians(18.0))))
    camera = Camera((0.3 * distance, 0.2 * distance, 0.0), (0.0, 0.0, 0.0), fov_deg=36.0, width=size, height=size)
    position = np.asarray(camera.position)
    camera = replace(camera, position=tuple(distance * position / np.linalg.norm(position)))
    ink = 1.0 - on_paper(sketch(SPHERE, levels, camera, samples=samples))[..., 0]
    y, x = np.mgrid[:size, :size] + 0.5 - 0.5 * size
    sector = np.floor((np.arctan2(y, x) / np.pi + 1.0) * 4.0).astype(int) % 8
    area = np.bincount(sector.ravel(), ink.ravel(), 8) * 8.0 / np.pi  # R² - (R - w)²
    return radius - np.sqrt(radius**2 - area)


def blended(radius: float) -> float:
    """The same by formula: what the levels hold along a radius, blended by the LOD."""
    depth = (np.arange(20_000) + 0.5) * min(radius, 12.0) / 20_000
    cosine = 1.0 - depth / radius
    normal = np.stack([cosine, 0.0 * cosine, np.sqrt(1.0 - cosine**2)], -1)
    turn = 1.0 / (radius * normal[:, 2])
    texel = 1.0 / (SIZE * np.sqrt(DualParaboloid().sampling_rate(normal)))
    lod = np.clip(np.log2(turn / texel), 0.0, np.log2(SIZE))
    ink = np.zeros(len(depth))
    for level in range(SIZE.bit_length()):
        share = np.maximum(1.0 - np.abs(lod - level), 0.0)
        ink += share * (1.0 - Silhouette(WIDTH).colors(normal, texel * 2.0**level)[:, 0])
    area = 2.0 * (ink * (radius - depth)).sum() * (depth[1] - depth[0])
    return float(radius - np.sqrt(radius**2 - area))


@pytest.mark.parametrize(("radius", "samples"), [(10.0, 4), (21.0, 16), (34.0, 4), (60.0, 1), (60.0, 4), (85.0, 4)])
def test_silhouettes_have_one_width_at_all_distances(radius: float, samples: int) -> None:
    levels = drawn_levels(Silhouette(WIDTH), DualParaboloid(), SIZE)
    width = outline(radius, levels, samples)
    # Between two levels the LOD blends: 0.86 to 1.22 of the width (`Silhouette`).
    assert 0.84 * WIDTH < width.mean() < 1.24 * WIDTH
    # Beside what the formula says: pixels' derivatives are differences, and texels of a pixel's width are interpolated.
    assert width.mean() == pytest.approx(blended(radius), rel=0.06 if samples > 1 else 0.12)
    # All around alike, but for pixels that lie in two sectors: on the smallest ball a sector is 8 of them long.
    assert np.ptp(width) < (0.5 if radius < 20 or samples == 1 else 0.25)


def test_filtered_levels_would_not_do() -> None:
    """The finest level's line, filtered, is wider the larger the ball is: it is a share of the radius."""
    from reflet.envmap.resampling.mip_reduction import mip_images

    finest = drawn_levels(Silhouette(WIDTH), DualParaboloid(), SIZE)[0]
    small, large = (outline(radius, mip_images(finest), 4).mean() for radius in (20.0, 80.0))
    assert large > 2.0 * small
