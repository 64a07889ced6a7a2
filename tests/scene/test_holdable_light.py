"""Scenes brighter than half floats: what a bake makes of their light."""

import warnings
from dataclasses import replace

import numpy as np
import pytest

from reflet.envmap.env_image import EnvImage
from reflet.envmap.facts import facts
from reflet.envmap.parameterizations.latlong import LatLong
from reflet.envmap.resampling.spread_light import HALF_MAX
from reflet.errors import RefletError, RefletWarning
from reflet.scene.holdable_light import with_holdable_light
from reflet.scene.material import EnvironmentLight, Material
from reflet.scene.meshes.primitives import sphere_mesh
from reflet.scene.scene import Part, ReflectiveObject, Scene


def scene(radiance: np.ndarray, emission: float = 0.0) -> Scene:
    ball = Part("ball", sphere_mesh(around=16), Material("mirror"), True)
    lamp = Part("lamp", sphere_mesh(around=16), Material("lamp", emission=(emission,) * 3), False)
    return Scene((ball, lamp), (ReflectiveObject("ball", (0,)),), environment=EnvironmentLight(radiance))


def test_a_suns_light_is_kept() -> None:
    radiance = np.ones((64, 128, 3), np.float32)
    radiance[20:22, 30:32] = 1e6
    given = scene(radiance)
    with pytest.warns(RefletWarning, match=r"of the light is brighter than a bake can hold \(65504\); none is lost"):
        light = with_holdable_light(given).environment
    assert light is not None and light.radiance.max() <= HALF_MAX
    before, after = (facts(EnvImage(LatLong(), each[None])) for each in (radiance, light.radiance))
    np.testing.assert_allclose(after.power, before.power, rtol=1e-6)  # a rounding to float32
    # Half a texel of 2.8°: discs consist of whole ones.
    assert np.linalg.norm(np.subtract(after.dominant, before.dominant)) < 0.025


def test_dim_scenes_stay_what_they_are() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        dim = scene(np.ones((8, 16, 3), np.float32))
        assert with_holdable_light(dim).environment is not None
        np.testing.assert_array_equal(with_holdable_light(dim).environment.radiance, 1.0)  # type: ignore[union-attr]
        dark = replace(dim, environment=None)
        assert with_holdable_light(dark) is dark


def test_lamps_that_mirrors_cannot_show_are_said() -> None:
    with pytest.warns(RefletWarning, match="lamp glows brighter than mirrors can show .* up to 50 % of its light"):
        with_holdable_light(scene(np.ones((8, 16, 3), np.float32), 2.0 * HALF_MAX))


@pytest.mark.parametrize("wrong", [-0.5, np.nan, np.inf])
def test_light_that_is_none_is_refused(wrong: float) -> None:
    radiance = np.ones((8, 16, 3), np.float32)
    radiance[2, 3] = wrong
    with pytest.raises(RefletError, match="negative, infinite or not a number"):
        with_holdable_light(scene(radiance))
