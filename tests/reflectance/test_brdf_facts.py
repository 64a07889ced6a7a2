"""What is told of BRDFs: reciprocity and albedo against closed forms."""

import numpy as np
import pytest

from reflet.reflectance.brdfs.brdf import FunctionBrdf
from reflet.reflectance.brdfs.ggx import Ggx
from reflet.reflectance.brdfs.lambert import Lambert
from reflet.reflectance.lobes.brdf_facts import brdf_facts, reciprocity_error


def test_reciprocity_error_in_closed_form() -> None:
    assert reciprocity_error(Ggx(0.4)) < 1e-12
    # f = cos θi = x, of weight 2x: E[x] = 2/3 and E[x²] = 1/2, so E[(x - y)²] = 2·(1/2 - 4/9).
    f = FunctionBrdf(lambda i, o, p: (i + 0.0 * o + 0.0 * p)[..., None])
    assert reciprocity_error(f) == pytest.approx(np.sqrt((1.0 / 9.0) / 0.5), abs=1e-9)  # exact for polynomials


def test_facts_of_diffuse_reflection() -> None:
    facts = brdf_facts(Lambert(), 2)
    np.testing.assert_allclose(facts.albedo, 1.0, atol=1e-9)  # the integrand is linear
    # The fits' own error (test_lobes); a single lobe does as well, for its axis is free to be the normal.
    assert facts.several.error.max() < 1e-3 and facts.one.error.max() < 1e-2
    np.testing.assert_allclose(facts.one.lobes[0].axis_angle, 0.0, atol=0.02)
