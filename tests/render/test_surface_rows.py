"""Rows of surface layers: what their matrix makes of a layer is what the shader shows."""

from dataclasses import replace

import numpy as np
import pytest
from scenes import MIRROR, torus, traced_pem
from surface_layers import random_surface

from reflet.infer.infer_layer import common_rows
from reflet.infer.infer_surface import surface_rows
from reflet.infer.product import multiply
from reflet.render.playback.renderer import Renderer
from reflet.scene.material import Material
from reflet.scene.scene import Part
from reflet.scene.surfaces.surface import gbuffer_from_visibility
from reflet.trace.tracer import Tracer

SAMPLES = 4


@pytest.mark.parametrize("double_sided", [False, True])
def test_the_matrix_shows_what_the_shader_shows(double_sided: bool) -> None:
    """Sub-sample by sub-sample averaged over pixels, over the light that alphas let pass; fronts and backs."""
    metal = Material("metal", (0.65, 0.65, 0.65), 1.0, 0.5, double_sided=double_sided)
    mesh = torus()
    if double_sided:  # a torus that is open above
        low = mesh.positions[mesh.triangles][..., 1].mean(1) < 0.05
        mesh = replace(mesh, triangles=mesh.triangles[low])
    pem = traced_pem(Part("torus", mesh, metal, True))
    surface = random_surface(pem.scene, (0,))
    surface = replace(surface, light=(surface.light + np.float16([1, 1, 1, 0])).astype(np.float16))  # is not cut at 0
    camera = pem.space.orbit.camera({"azimuth_deg": 60.5, "elevation_deg": 40.0})
    view = Tracer(pem.scene, irradiance=pem.irradiance).view(camera, spp=16, sample_count=SAMPLES, seed=3)
    rows = surface_rows(pem.scene, view, surface, [pem.maps[0]], pem.lod_bias_at(SAMPLES))
    gbuffer = gbuffer_from_visibility(pem.scene, view.visibility)
    of_gbuffer, of_layers = common_rows(gbuffer, view.layers)
    arrives = view.layers.combined[of_layers] / view.layers.fresnel[of_layers]
    shown = multiply(rows.matrix, surface.light[..., :3].reshape(-1, 3)) + arrives - rows.target

    renderer = Renderer(replace(pem, surface=surface))
    picture = renderer.frame(camera, samples=SAMPLES, what="object", layers=("distant", "local")).reshape(-1, 4)
    picture = picture[gbuffer.row_pixel[of_gbuffer]]
    covered = np.bincount(gbuffer.row_of_sample)[of_gbuffer] == SAMPLES
    covered &= picture[:, 3] == 1.0
    difference = np.abs(picture[covered, :3] - shown[covered]).max(1)
    # Random maps jump from site to site; rasterizer and tracer may see two triangles at their edge.
    assert np.quantile(difference, 0.98) < 6e-3, np.quantile(difference, [0.5, 0.9, 0.98, 1.0])
    assert covered.sum() > 300


def test_smooth_parts_have_no_rows() -> None:
    pem = traced_pem(Part("torus", torus(), MIRROR, True))
    surface = random_surface(pem.scene, (0,))
    camera = pem.space.orbit.camera({"azimuth_deg": 60.5})
    view = Tracer(pem.scene, irradiance=pem.irradiance).view(camera, spp=4, sample_count=SAMPLES, seed=3)
    rows = surface_rows(pem.scene, view, surface, [pem.maps[0]], pem.lod_bias)
    assert not len(rows.weights) and rows.matrix.texel_count == surface.light.shape[0] * surface.light.shape[1]
