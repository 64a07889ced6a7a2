"""The fade from the samples' maps to the base, where it is known which of them are right."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from small_scenes import ball, orbit

from reflet.envmap.env_map import EnvMap
from reflet.envmap.geometry import InfiniteSphere
from reflet.envmap.mip_chain import MipChain
from reflet.pem.pem import Layer
from reflet.pem.writer import PemWriter
from reflet.pipelines.baking import choose_fade as module
from reflet.pipelines.baking.choose_fade import choose_fade
from reflet.scene.assemble import assemble
from reflet.scene.material import EnvironmentLight
from reflet.scene.surfaces.irradiance import IrradianceMap
from reflet.scene.views.parameter_space import Axis, ParameterSpace
from reflet.trace.tracer import Tracer

CHAIN = MipChain(4)
LIGHT = 0.5


@pytest.fixture(name="tracer", scope="module")
def _tracer() -> Tracer:
    """A ball under light of 0.5 from everywhere."""
    scene = assemble([ball()], environment=EnvironmentLight(np.full((4, 8, 3), LIGHT, np.float32)))
    none = np.zeros(scene.triangle_offsets[-1], np.uint32)
    return Tracer(scene, irradiance=IrradianceMap(none, none, np.zeros((1, 3), np.float32)))


def fade(tracer: Tracer, folder: Path, samples: float, base: float, space: ParameterSpace | None = None) -> float:
    """Where the samples' maps hold one radiance, and the base another."""
    space = space or orbit(2, image_size=24)
    parts = tracer.scene.objects[0].parts
    layers = (Layer("sky", "distant", parts, InfiniteSphere(), CHAIN.size),)
    writer = PemWriter(folder, {})

    def env_map(radiance: float) -> EnvMap:
        return EnvMap(CHAIN, np.full((CHAIN.texel_count, 3), radiance, np.float32), InfiniteSphere())

    for sample in range(space.sample_count):
        writer.write_sample(sample, layers, [env_map(samples)])
    return choose_fade(tracer, space, layers, [env_map(base)], -2.0, writer)


def test_a_base_that_is_right_takes_over_at_once(tracer: Tracer, tmp_path: Path) -> None:
    assert fade(tracer, tmp_path / "pem", 0.7, LIGHT) == module._FADES_DEG[0]


def test_samples_that_are_right_everywhere_are_kept_long(tracer: Tracer, tmp_path: Path) -> None:
    assert fade(tracer, tmp_path / "pem", LIGHT, 0.7) == module._FADES_DEG[-1]


@pytest.mark.parametrize("elevations", [(0.0, 20.0, 40.0), (30.0, 80.0), (85.0,)])
def test_views_stand_off_the_samples_whatever_these_are(
    tracer: Tracer, tmp_path: Path, elevations: tuple[float, ...]
) -> None:
    """Views among the samples, or as steep as they, would tell nothing: the first fade would do as well as any."""
    axes = (Axis("azimuth_deg", (20.0,)), Axis("elevation_deg", elevations))
    assert fade(tracer, tmp_path / "pem", LIGHT, 0.7, replace(orbit(image_size=24), axes=axes)) == 50.0


def test_errors_that_cancel_are_shared(tracer: Tracer, tmp_path: Path) -> None:
    """Of opposite errors half is best: Σ (1 - 2·min(d/fade, 1))² over d = 4, 9, 18° is least at 33, and next at 22."""
    assert fade(tracer, tmp_path / "pem", LIGHT + 0.02, LIGHT - 0.02) in (22.0, 33.0)


def test_where_no_camera_stands_beside_the_samples_there_is_a_fade(tracer: Tracer, tmp_path: Path) -> None:
    """All held-back views lie within the ball."""
    space = orbit(1, image_size=8)
    inside = ParameterSpace(space.axes, type(space.orbit)((0, 0, 0), 20.0, 15.0, 0.1, image_size=8))
    assert fade(tracer, tmp_path / "pem", LIGHT, 0.7, inside) in module._FADES_DEG
