"""The cube's face table; what all parameterizations share is in test_parameterizations."""

import numpy as np

from reflet.envmap.parameterizations.cube import AXES, CUBE, FACES, texel_directions, texel_solid_angle


def test_orientation_is_webgpus() -> None:
    """Side faces have +y at their top; right of pz's centre lies +x."""
    for name in ("px", "nx", "pz", "nz"):
        np.testing.assert_array_equal(AXES[FACES.index(name), 2], [0, -1, 0])
    np.testing.assert_array_equal(AXES[FACES.index("pz"), 1], [1, 0, 0])
    np.testing.assert_array_equal(AXES[FACES.index("px"), 1], [0, 0, -1])
    np.testing.assert_array_equal(AXES[FACES.index("py"), 2], [0, 0, 1])


def test_faces_as_functions_and_as_a_parameterization_are_one() -> None:
    direction, valid = CUBE.texel_directions(8)
    assert valid.all()
    np.testing.assert_allclose(texel_directions(8), direction, atol=1e-15)  # float64 in another order
    for face in CUBE.texel_solid_angle(8):
        np.testing.assert_array_equal(face, texel_solid_angle(8))
