"""What can be said of a BRDF: how much it reflects, whether it may be, and how well lobes stand for it."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from reflet.reflectance.brdfs.brdf import Brdf, directional_albedo
from reflet.reflectance.lobes.lobes import KINDS, Lobes, fit_lobes

_NODES = 32


@dataclass(frozen=True)
class BrdfFacts:
    """``albedo`` is `directional_albedo` at the view angles of ``one`` and ``several``: the fits with the glossy lobe
    alone and with all of `KINDS`."""

    albedo: Float[np.ndarray, "angles channels"]
    reciprocity_error: float
    one: Lobes
    several: Lobes


def brdf_facts(brdf: Brdf, angles: int = 8) -> BrdfFacts:
    """Facts at ``angles`` view angles. Raises RefletError for BRDFs that are negative or not finite."""
    one, several = fit_lobes(brdf, ("glossy",), angles), fit_lobes(brdf, KINDS, angles)
    return BrdfFacts(directional_albedo(brdf, one.cos_theta_o, 128), reciprocity_error(brdf), one, several)


def reciprocity_error(brdf: Brdf) -> float:
    """How far f(wi, wo) is from f(wo, wi): their difference over f itself, both in the mean square of all pairs.

    Pairs are weighted by cos θi·cos θo. 0 for reciprocal BRDFs; independent noise of a share ε in every value of a
    table gives at most √2·ε.
    """
    node, weight = np.polynomial.legendre.leggauss(_NODES)
    cosine, weight = 0.5 + 0.5 * node, weight * (0.5 + 0.5 * node)
    # Gauss's nodes for the cosines' measure dθ·sin θ·cos θ; Δφ by midpoints
    cos_delta_phi = np.cos((np.arange(_NODES) + 0.5) / _NODES * np.pi)
    f = brdf.evaluate(cosine[:, None, None], cosine[None, :, None], cos_delta_phi[None, None, :])
    pairs = weight[:, None, None, None] * weight[None, :, None, None]
    difference = f - f.swapaxes(0, 1)
    return float(np.sqrt((pairs * difference**2).sum() / max(float((pairs * f**2).sum()), 1e-300)))
