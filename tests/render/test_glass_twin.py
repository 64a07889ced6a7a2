"""glass.wgsl against the ray tracer's twin."""

import drjit as dr
import numpy as np
from compute import run

from reflet.trace.variant import use_variant


def test_glass_twins() -> None:
    """Reflectance and refracted rays, of solids from both sides and of thin sheets."""
    random = np.random.default_rng(0)
    count = 4000
    ng = random.normal(size=(count, 3))
    ng /= np.linalg.norm(ng, axis=1, keepdims=True)
    n = ng + 0.2 * random.normal(size=(count, 3))
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    d = random.normal(size=(count, 3))
    d *= -np.sign((d * ng).sum(1, keepdims=True))
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    index = random.uniform(1.0, 2.5, count)
    back, thin = random.random(count) < 0.5, random.random(count) < 0.2
    kinds = np.stack([index, back, thin, np.zeros(count)], -1).astype(np.float32)
    code = """
    #import glass
    let d = vec3f(in0[3*i], in0[3*i+1], in0[3*i+2]);
    let n = vec3f(in1[3*i], in1[3*i+1], in1[3*i+2]);
    let ng = vec3f(in2[3*i], in2[3*i+1], in2[3*i+2]);
    let back = in3[4*i+1] > 0.5;
    let thin = in3[4*i+2] > 0.5;
    let r = refracted(d, n, ng, in3[4*i], back, thin);
    out[4*i] = r.x; out[4*i+1] = r.y; out[4*i+2] = r.z;
    out[4*i+3] = glass_reflectance(in3[4*i], dot(-d, n), back, thin);
    """
    shader = run(code, [d.astype(np.float32), n.astype(np.float32), ng.astype(np.float32), kinds], 4)
    use_variant()
    import mitsuba as mi

    from reflet.trace.glass import glass_reflectance, refracted

    d_, n_, ng_ = (mi.Vector3f(*(mi.Float(x[:, k].astype(np.float32)) for k in range(3))) for x in (d, n, ng))
    index_, back_, thin_ = mi.Float(kinds[:, 0]), mi.Bool(back), mi.Bool(thin)
    cosine = dr.clip(-dr.dot(d_, n_), 0.0, 1.0)
    tracer = np.column_stack(
        [*refracted(d_, n_, ng_, index_, back_, thin_), glass_reflectance(cosine, index_, back_, thin_)]
    )
    facing = (d * n).sum(1) < 0.0  # shading normals that look away say nothing
    error = np.abs(shader - tracer).max(1)[facing]
    # Near the critical angle g and the refracted ray are roots of differences of numbers near 1: 3e-4 of 1e-7.
    assert np.percentile(error, 98) < 2e-5
    assert error.max() < 2e-3
    # Snell's law, where nothing is bent or reflected totally
    plain = facing & ~thin & (shader[:, 3] < 1.0) & ((shader[:, :3] * ng).sum(1) < -0.01)
    ratio = np.where(back, index, 1.0 / index)[:, None]
    np.testing.assert_allclose(np.cross(n, shader[:, :3])[plain], (ratio * np.cross(n, d))[plain], atol=1e-5)
    assert plain.sum() > 1500 and (shader[:, 3] == 1.0).sum() > 300
