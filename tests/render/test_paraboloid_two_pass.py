"""The dual paraboloid by texture matrices against the single lookup."""

import numpy as np
import pytest
from map_scenes import analytic_levels, linear, sphere_reflections

from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.parameterizations.dual_paraboloid import DualParaboloid
from reflet.errors import RefletError
from reflet.render.materials.env_map_renderer import render_mirror, view_frame
from reflet.render.materials.paraboloid_two_pass import ParaboloidRenderer
from reflet.scene.meshes.primitives import sphere_mesh
from reflet.scene.views.camera import Camera

# The border between the hemispheres runs across what is seen.
CAMERA = Camera((2.6, 1.2, 0.8), (0.0, 0.0, 0.0), fov_deg=50, width=128, height=112)
TURN = view_frame(Camera((1.0, 2.0, 0.5), (0.0, 0.0, 0.0)))


@pytest.mark.parametrize("method", ["two_pass", "one_pass"])
@pytest.mark.parametrize("frame", [None, TURN], ids=["straight", "turned"])
def test_texture_matrices_agree_with_the_single_lookup(method, frame) -> None:  # type: ignore[no-untyped-def]
    turn = np.eye(3) if frame is None else frame
    mesh, levels = sphere_mesh(around=256), analytic_levels(DualParaboloid(), 128, lambda d: linear(d @ turn))[:1]
    by_matrices = ParaboloidRenderer(mesh, levels).picture(CAMERA, frame=frame, method=method)
    single = render_mirror(mesh, levels, CAMERA, frame=frame, samples=1)
    direction, cosine = sphere_reflections(CAMERA)
    usable = np.isfinite(cosine) & (cosine > 0.3)
    assert ((direction @ turn.T)[usable][:, 2] > 0.1).mean() > 0.1 < ((direction @ turn.T)[usable][:, 2] < -0.1).mean()
    assert (by_matrices[usable][:, 3] == 1.0).all()
    # The ray is interpolated between vertices 1.4° apart, mirrored 2.8°: it falls short of unit length, and z by
    # (0.05)²/8 with it; half floats near 0.9 are 5e-4 apart; cards round filter weights to 8 bits. Where the disc
    # touches the border the hardware repeats the last texel: half of one is 1/128 radians of a slope of 0.35.
    np.testing.assert_allclose(by_matrices[usable][:, :3], single[usable][:, :3], atol=3e-3)
    np.testing.assert_allclose(by_matrices[usable][:, :3], linear(direction[usable]), atol=3e-3)


def test_without_a_ring_two_passes_leave_a_gap_between_the_hemispheres() -> None:
    mesh, levels = sphere_mesh(around=256), analytic_levels(DualParaboloid(), 64)[:1]
    bare, ringed = (ParaboloidRenderer(mesh, levels, ring=ring) for ring in (0.0, 2.0))
    direction, cosine = sphere_reflections(CAMERA)
    usable = np.isfinite(cosine) & (cosine > 0.3)
    gap = usable & (bare.picture(CAMERA)[..., 3] == 0.0)
    assert gap.sum() > 20
    # Beside the border of 64 rows a texel is 2/64 radii deep, of twice as many radians of direction each, and a filter
    # reaches one and a half texels in diagonal.
    assert np.abs(direction[gap][:, 2]).max() < 1.5 * np.sqrt(2.0) * 2.0 / 64 * 1.1
    assert not (usable & (ringed.picture(CAMERA)[..., 3] == 0.0)).any()
    # Blending leaves none, as the back is drawn everywhere.
    assert not (usable & (bare.picture(CAMERA, method="one_pass")[..., 3] == 0.0)).any()


def test_other_maps_are_refused() -> None:
    with pytest.raises(RefletError, match="not a cube map"):
        ParaboloidRenderer(sphere_mesh(), analytic_levels(CUBE, 4))
