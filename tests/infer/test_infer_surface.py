"""Surface layers inferred from pictures: the minimizer, and better pictures from other places too."""

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import spsolve

from reflet.envmap.env_map import EnvMap
from reflet.envmap.geometry import InfiniteSphere
from reflet.envmap.mip_chain import MipChain
from reflet.infer.fit_surface import edges_of, fit_surface
from reflet.infer.infer_surface import _SETTINGS, _STAYING, infer_surface, surface_rows
from reflet.infer.product import multiply
from reflet.infer.records import RenderingMatrix, Rows
from reflet.scene.assemble import assemble
from reflet.scene.material import EnvironmentLight, Material
from reflet.scene.meshes.primitives import torus_mesh
from reflet.scene.scene import Part
from reflet.scene.surfaces.surface_layer import SIDES, SurfaceLayer
from reflet.scene.views.parameter_space import Orbit
from reflet.trace.tracer import Tracer

TEXELS = SIDES[0] ** 2


def test_it_is_the_minimizer() -> None:
    """Three sites on a triangle, two of them on another too, and rows that see some of their texels."""
    rng = np.random.default_rng(2)
    surface = SurfaceLayer(
        resolution=np.ones(2, np.uint32),
        offset=np.uint32([0, 3]),
        site=np.uint32([0, 1, 2, 2, 1, 3]),
        light=rng.uniform(0.0, 1.0, (4, TEXELS, 4)).astype(np.float16),
    )
    a = sp.random(300, 4 * TEXELS, 0.05, random_state=3, format="csr", dtype=np.float32)
    target, weights = rng.uniform(0.0, 1.0, (300, 3)).astype(np.float32), rng.uniform(0.5, 1.5, 300).astype(np.float32)
    blocks = [
        Rows(
            RenderingMatrix(part.indptr.astype(np.int32), part.indices.astype(np.int32), part.data, part.shape[1]),
            target[span], weights[span],
        )
        for span in (slice(0, 120), slice(120, 300)) for part in (a[span],)
    ]  # fmt: skip
    edges = edges_of(surface)
    assert sorted(map(tuple, edges.tolist())) == [(0, 1), (0, 2), (1, 2), (1, 3), (2, 3)]
    found = infer_surface(blocks, surface, edges)

    g = np.zeros((len(edges), 4))
    g[np.arange(len(edges)), edges[:, 0]], g[np.arange(len(edges)), edges[:, 1]] = 1.0, -1.0
    penalty = sp.kron(sp.csr_matrix(g.T @ g), sp.eye(TEXELS)) + _STAYING * sp.eye(4 * TEXELS)
    penalty = _SETTINGS.regularization * weights.mean() * penalty
    prior = surface.light[..., :3].reshape(-1, 3).astype(float)

    def cost(x: np.ndarray) -> float:
        misses, d = a @ x - target, x - prior
        return float((weights[:, None] * misses**2).sum() + (d * (penalty @ d)).sum())

    normal = (a.T @ sp.diags(weights) @ a + penalty).tocsc()
    least = cost(prior + spsolve(normal, a.T @ (weights[:, None] * (target - a @ prior))))
    # twelve steps of conjugate gradient, and half floats
    assert cost(found.light[..., :3].reshape(-1, 3).astype(float)) - least < 1e-2 * (cost(prior) - least)
    np.testing.assert_array_equal(found.light[..., 3], surface.light[..., 3])


def test_pictures_from_elsewhere_are_nearer_to_traced_ones() -> None:
    """A rough torus under a sky with a bright side: its hole sees itself."""
    ramp = np.linspace(0.1, 2.0, 64, dtype=np.float32)[None, :, None] ** 2
    sky = EnvironmentLight(np.broadcast_to(ramp * np.float32([1.0, 0.8, 0.6]), (32, 64, 3)).copy())
    metal = Material("metal", (0.9, 0.9, 0.9), 1.0, 0.5)
    scene = assemble([Part("torus", torus_mesh(0.1, 0.05, around=24, sides=12), metal)], environment=sky)
    tracer = Tracer(scene, irradiance_spp=4)
    chain = MipChain(16)
    mean = (0.1 + 2.0) ** 2 / 4.0
    maps = [EnvMap(chain, np.full((chain.texel_count, 3), mean, np.float32), InfiniteSphere())]  # as wrong as can be
    surface = fit_surface(tracer.surface((0,), spp=32, budget=800), [maps], 0.0)
    orbit = Orbit((0.0, 0.0, 0.0), 0.0, 30.0, 0.7, image_size=48)

    def rows(azimuth: float, elevation: float, spp: int) -> Rows:
        camera = orbit.camera({"azimuth_deg": azimuth, "elevation_deg": elevation})
        view = tracer.view(camera, spp=spp, sample_count=4, seed=int(azimuth))
        return surface_rows(scene, view, surface, [maps], 0.0)

    blocks = [rows(azimuth, elevation, 32) for elevation in (15.0, 45.0) for azimuth in range(0, 360, 30)]
    better = infer_surface(blocks, surface, edges_of(surface))

    def error(layer: SurfaceLayer, held_back: Rows) -> float:
        shown = multiply(held_back.matrix, layer.light[..., :3].reshape(-1, 3))
        return float((held_back.weights[:, None] * (shown - held_back.target) ** 2).sum())

    for place in ((50.0, 30.0), (200.0, 22.0)):
        held_back = rows(*place, 128)
        assert error(better, held_back) < 0.8 * error(surface, held_back)


def test_without_rows_the_prior_stays() -> None:
    surface = SurfaceLayer(
        np.ones(1, np.uint32), np.zeros(1, np.uint32), np.uint32([0, 1, 2]),
        np.full((3, TEXELS, 4), 0.25, np.float16),
    )  # fmt: skip
    nothing = Rows(
        RenderingMatrix(np.zeros(1, np.int32), np.zeros(0, np.int32), np.zeros(0, np.float32), 3 * TEXELS),
        np.zeros((0, 3), np.float32), np.zeros(0, np.float32),
    )  # fmt: skip
    found = infer_surface([nothing], surface, edges_of(surface))
    np.testing.assert_array_equal(found.light, surface.light)
