"""Other pictures of mirrors that see themselves: of where light comes from, and those of motion."""

import numpy as np
from scenes import MIRROR, torus, traced_pem

from reflet.render.playback.renderer import Renderer
from reflet.report.measures import display_psnr
from reflet.scene.scene import Part


def test_what_is_met_is_orange_and_what_is_not_is_blue() -> None:
    """Of grey mirrors, in a picture by origin: as bright as it is, but for what the colours' luminance is off."""
    pem = traced_pem(Part("torus", torus(), MIRROR, True))
    view, luminance = pem.space.orbit.camera({"azimuth_deg": 60.5}), np.array([0.2126, 0.7152, 0.0722])
    renderer = Renderer(pem)
    plain, told = (renderer.frame(view, samples=1, what="object", by_origin=asked) for asked in (False, True))
    met = renderer.met_triangles(view, 1, 0)[..., 0] > 0
    for where, colour in ((met, (2.4, 0.65, 0.1)), (~met, (0.35, 1.0, 2.6))):
        seen = where & (plain[..., 3] == 1.0) & (plain[..., 1] > 0.0)  # backs are black
        assert seen.sum() > 50
        shares = told[seen, :3] / (told[seen, :3] @ luminance)[:, None]
        np.testing.assert_allclose(
            shares, np.tile(colour / (colour @ luminance), (seen.sum(), 1)), rtol=1e-4
        )  # float32
        np.testing.assert_allclose(told[seen, :3] @ luminance, plain[seen, :3] @ luminance, rtol=0.05)


def test_multi_sampled_pictures_trace_too() -> None:
    """As in motion, interpolated by the rasterizer."""
    pem = traced_pem(Part("torus", torus(), MIRROR, True))
    view, renderer = pem.space.orbit.camera({"azimuth_deg": 60.5}), Renderer(pem)
    exact = renderer.frame(view, samples=4, what="object")
    fast = renderer.frame(view, samples=4, what="object", multisampled=True, exact=False)
    untraced = renderer.frame(view, samples=4, what="object", layers=("fresnel", "distant"))
    covered = exact[..., 3] > 0.5
    # Measured: 53 dB, where drivers interpolate differently a few silhouettes. 23 where rays start off their triangle's
    # plane and meet its back; 32 untraced.
    assert display_psnr(exact[..., :3], fast[..., :3], covered) > 45
    assert display_psnr(exact[..., :3], untraced[..., :3], covered) < 35
