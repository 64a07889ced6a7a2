"""The local ellipsoid comes closer to what was mirrored."""

import numpy as np
import pytest
from synthetic import mirror_scene, picture, sphere_mesh
from test_infer_layer import layers_of

from reflet.envmap.geometry import Ellipsoid
from reflet.envmap.mip_chain import MipChain
from reflet.envmap.parameterizations.cube import texel_directions
from reflet.infer import fit_local
from reflet.infer.fit_local import fit_local_ellipsoid
from reflet.infer.infer_layer import infer_layer
from reflet.infer.product import multiply
from reflet.infer.rendering_matrix import rendering_matrix

TRUE = Ellipsoid((0.05, 0.1, 0.0), (0.5, 0.45, 0.6), (0.05, 0.1, 0.0))
START = Ellipsoid((0.0, 0.0, 0.0), (0.8, 0.8, 0.8), (0.0, 0.0, 0.0))
CHAIN = MipChain(16)
BIAS = -1.5


def test_shows_a_second_viewpoint_better(monkeypatch: pytest.MonkeyPatch) -> None:
    """Stripes on an ellipsoid, mirrored in a sphere within it: inferred from one side and shown from another."""
    monkeypatch.setattr(fit_local, "TRIALS", 25)
    scene = mirror_scene(sphere_mesh(0.3, 12))
    on_hull = np.zeros(scene.triangle_offsets[-1], np.bool_)
    stripes = [0.5 + 0.4 * np.sin(6.0 * texel_directions(n).reshape(-1, 3)) for n in CHAIN.level_sizes]
    texels = np.concatenate([np.concatenate(stripes), np.ones((CHAIN.texel_count, 1))], 1).astype(np.float32)
    views, shown = [], []
    for eye in ((0.8, 0.4, 0.7), (0.5, 0.8, 0.6)):
        seen = picture(scene, eye, 24, sample_count=4)
        shown.append(multiply(rendering_matrix(seen.gbuffer, CHAIN, TRUE, BIAS), texels))
        views.append((seen.gbuffer, layers_of(seen, np.zeros((len(shown[-1]), 3)), shown[-1])))

    def error_elsewhere(shape: Ellipsoid) -> float:
        solution = infer_layer("local", *views[0], (0,), shape, CHAIN, BIAS)
        again = multiply(rendering_matrix(views[1][0], CHAIN, shape, BIAS), solution.texels)
        return float(np.mean((again - shown[1]) ** 2))

    found = fit_local_ellipsoid(START, views, 0, on_hull, BIAS, CHAIN)
    # The true shape's error is that of texels unseen at first, so that improvement has a floor: half the excess.
    excess = error_elsewhere(START) - error_elsewhere(TRUE)
    assert excess > 0.0
    assert error_elsewhere(found) - error_elsewhere(TRUE) < 0.5 * excess


def test_a_part_that_mirrors_nothing_of_its_object_keeps_its_shape() -> None:
    scene = mirror_scene(sphere_mesh(0.3, 12))
    seen = picture(scene, (0.8, 0.4, 0.7), 16, sample_count=1)
    rows = len(seen.gbuffer.row_pixel)
    view = (seen.gbuffer, layers_of(seen, np.ones((rows, 3)), np.zeros((rows, 4))))
    assert fit_local_ellipsoid(START, [view], 0, np.zeros(scene.triangle_offsets[-1], np.bool_), BIAS, CHAIN) is START
