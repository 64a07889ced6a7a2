"""A material given by any isotropic BRDF, measured or not, as lobes."""

from dataclasses import dataclass

import numpy as np

from reflet.reflectance.lobes.lobes import Lobes
from reflet.reflectance.materials.material import Cosine, SurfaceMaterial, Weights


@dataclass(frozen=True, eq=False)
class Measured(SurfaceMaterial):
    """Looks up a `BrdfMap3d` of its lobes (`reflected_radiance`; `shaders/lobes.wgsl` is the twin)."""

    kind = 7
    diffuses = True
    lobes: Lobes

    def weights(self, n_dot_v: Cosine) -> Weights:
        """The shares of light that all lobes together, and the diffuse one, reflect."""
        lobes = self.lobes
        glossy = sum((lobe.albedo for lobe in lobes.lobes), np.zeros_like(lobes.diffuse))
        specular, diffuse = (
            np.stack(
                [np.interp(n_dot_v, lobes.cos_theta_o, albedo[:, min(c, albedo.shape[1] - 1)]) for c in range(3)], -1
            )
            for albedo in (glossy, lobes.diffuse)
        )
        return specular, diffuse
