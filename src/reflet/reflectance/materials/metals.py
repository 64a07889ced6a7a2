"""Metals by name: complex indices of refraction n - ik for each channel of linear Rec. 709.

They are the fits of `spectral.index_rgb` to measured tables: Johnson and Christy's of gold, silver and copper, Rakić's
of aluminium. Gold's red, near 1 at all angles, is a fit and no measured index.
"""

from reflet.reflectance.materials.material import Conductor

METALS = {
    "Au": Conductor((0.1089, 0.4972, 1.4684), (16.0481, 2.2651, 1.7721)),
    "Ag": Conductor((0.0565, 0.0549, 0.0432), (4.4621, 3.5476, 2.5894)),
    "Cu": Conductor((0.2219, 1.0404, 1.2953), (3.2847, 2.6262, 2.3606)),
    "Al": Conductor((1.4878, 0.9875, 0.6043), (7.6215, 6.5532, 5.3416)),
}
