"""fresnel.wgsl against its NumPy twin."""

import numpy as np
from compute import run

from reflet.reflectance.brdfs.fresnel import fresnel_conductor, fresnel_dielectric, fresnel_schlick


def test_fresnel_twins() -> None:
    random = np.random.default_rng(0)
    cosine = np.concatenate([[0.0, 1.0], random.random(998)]).astype(np.float32)
    n = random.uniform(0.1, 5.0, 1000).astype(np.float32)
    k = random.uniform(0.0, 8.0, 1000).astype(np.float32)
    code = """
    #import fresnel
    let c = in0[i]; let n = in1[i]; let k = in2[i];
    out[3*i] = fresnel_dielectric(n, c);
    out[3*i+1] = fresnel_conductor(vec3f(n), vec3f(k), c).y;
    out[3*i+2] = fresnel_schlick(vec3f(0.04), 0.7, c).z;
    """
    shader = run(code, [cosine[:, None], n[:, None], k[:, None]], 3).astype(np.float64)
    c, n, k = (x.astype(np.float64) for x in (cosine, n, k))
    # Some ten roundings of 6e-8.
    np.testing.assert_allclose(shader[:, 1], fresnel_conductor(c, n, k), atol=2e-6)
    np.testing.assert_allclose(shader[:, 2], fresnel_schlick(c, 0.04, 0.7), atol=2e-6)
    # Near the critical angle g is the root of a difference of two numbers near 1, and F falls with g: the rounding of
    # g² counts g times less. Elsewhere as above.
    g = np.sqrt(np.maximum(n * n - 1.0 + c * c, 0.0))
    error = np.abs(shader[:, 0] - fresnel_dielectric(c, n))
    assert (error <= 2e-6 + 2e-6 / np.maximum(g, 1e-3)).all()
