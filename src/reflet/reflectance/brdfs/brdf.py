"""What a BRDF is here: an isotropic one, a function of three cosines."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

Cosine = Float[np.ndarray, "*#batch"]
Values = Float[np.ndarray, "*batch channels"]


class Brdf(ABC):
    """The bidirectional reflectance distribution function of an isotropic surface, per steradian, ≥ 0.

    Isotropic: it depends on the angles of ``wi`` (to the light) and ``wo`` (to the viewer) to the normal and on the
    angle Δφ between their azimuths alone, so that prefiltered maps need no tangent frame. An anisotropic one has no
    place here for that very reason: its maps would be five-dimensional [Heidrich00, eq. 14].
    """

    @abstractmethod
    def evaluate(self, cos_theta_i: Cosine, cos_theta_o: Cosine, cos_delta_phi: Cosine) -> Values:
        """Values for cosines in (0, 1], (0, 1] and [-1, 1]; Δφ = 0 where ``wi`` and ``wo`` lie on one side.

        One channel, or the three of linear Rec. 709.
        """


@dataclass(frozen=True)
class FunctionBrdf(Brdf):
    """A BRDF given as a function of (cos θi, cos θo, Δφ), arrays that broadcast, which returns (…, 1 or 3 channels)."""

    function: Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]

    def evaluate(self, cos_theta_i: Cosine, cos_theta_o: Cosine, cos_delta_phi: Cosine) -> Values:
        """See `Brdf`."""
        delta_phi = np.arccos(np.clip(cos_delta_phi, -1.0, 1.0))
        return np.asarray(self.function(np.asarray(cos_theta_i), np.asarray(cos_theta_o), delta_phi))


def half_vector_cosines(
    cos_theta_i: Cosine, cos_theta_o: Cosine, cos_delta_phi: Cosine
) -> tuple[Float[np.ndarray, "..."], Float[np.ndarray, "..."]]:
    """(n·h, wo·h) of the halfway vector h = (wi + wo)/|wi + wo|: |wi + wo|² = 2 + 2·wi·wo."""
    length = np.sqrt(np.maximum(2.0 + 2.0 * cosine_between(cos_theta_i, cos_theta_o, cos_delta_phi), 1e-300))
    return np.asarray(np.minimum((cos_theta_i + cos_theta_o) / length, 1.0)), np.asarray(0.5 * length)


def cosine_between(cos_theta_i: Cosine, cos_theta_o: Cosine, cos_delta_phi: Cosine) -> Float[np.ndarray, "..."]:
    """wi·wo."""
    sines = np.sqrt((1.0 - np.square(cos_theta_i)) * (1.0 - np.square(cos_theta_o)))
    return np.asarray(np.clip(cos_theta_i * cos_theta_o + sines * cos_delta_phi, -1.0, 1.0))


def directional_albedo(
    brdf: Brdf, cos_theta_o: Float[np.ndarray, "n"], nodes: int = 256
) -> Float[np.ndarray, "n channels"]:
    """Share of light reflected towards each ``wo`` in a white furnace: ∫ f·cos θi dωi over the hemisphere.

    At most 1 where energy is kept. By Gauss-Legendre quadrature in cos θi and in Δφ, ``nodes`` and half as many: good
    to 1e-4 for lobes wider than some 8/nodes radians.
    """
    node, weight = np.polynomial.legendre.leggauss(nodes)
    cos_theta_i, weight_i = 0.5 + 0.5 * node, 0.5 * weight
    node, weight = np.polynomial.legendre.leggauss(nodes // 2)
    # dω = d(cos θ)·dφ; Δφ from 0 to π, and the same again
    delta_phi, weight_phi = 0.5 * np.pi * (1.0 + node), np.pi * weight
    each = [
        np.einsum(
            "i,p,ipc->c",
            cos_theta_i * weight_i,
            weight_phi,
            brdf.evaluate(cos_theta_i[:, None], np.array([[cosine]]), np.cos(delta_phi)[None, :]),
        )
        for cosine in cos_theta_o
    ]
    return np.array(each)
