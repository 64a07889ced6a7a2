"""Bakes of rough parts: light on their surfaces is inferred from pictures, and kept while that goes on."""

from dataclasses import replace
from functools import partialmethod
from pathlib import Path

import numpy as np
import pytest
from small_scenes import ball, files, in_a_room, orbit

from reflet.pem.container import open_pem
from reflet.pem.pem import ParameterizedEnvironmentMap
from reflet.pipelines.bake import bake
from reflet.pipelines.baking import held_back, rough_parts
from reflet.scene.assemble import assemble
from reflet.scene.scene import Part, Scene
from reflet.scene.surfaces.surface_layer import SIDES
from reflet.trace.tracer import Tracer


class StoppedError(Exception):
    """As Ctrl-C."""


@pytest.fixture(autouse=True)
def _small_work(monkeypatch: pytest.MonkeyPatch) -> None:
    for name, value in {"_TRIAL_IMAGE_SIZE": 32, "_TRIAL_SPP": 4, "_TRIAL_SAMPLE_COUNT": 4}.items():
        monkeypatch.setattr(held_back, name, value)
    monkeypatch.setattr(rough_parts, "VIEWPOINTS", 4)
    monkeypatch.setattr(Tracer, "surface", partialmethod(Tracer.surface, budget=200))


def rough_ball_in_a_room() -> Scene:
    here = ball()
    dull = Part(here.name, here.mesh, replace(here.material, perceptual_roughness=0.5))
    return assemble([dull, *in_a_room().parts[1:]])


def small_bake(out: Path, **options) -> ParameterizedEnvironmentMap:  # type: ignore[no-untyped-def]
    options = {"em_size": 16, "spp": 4, "sample_count": 4, **options}
    return open_pem(bake(rough_ball_in_a_room(), out, orbit(0, image_size=24), **options))


def test_viewpoints_lie_evenly_all_around(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.undo()
    points = rough_parts.surface_points(orbit(3))
    assert len(points) == rough_parts.VIEWPOINTS + 3
    assert [point["azimuth_deg"] for point in points[-3:]] == list(orbit(3).axes[0].values)  # the samples
    phi, theta = (np.radians([point[axis] for point in points[:-3]]) for axis in ("azimuth_deg", "elevation_deg"))
    directions = np.stack([np.cos(phi) * np.cos(theta), np.sin(theta), np.sin(phi) * np.cos(theta)], -1)
    cosines = directions @ directions.T - 2.0 * np.eye(len(directions))
    nearest = np.degrees(np.arccos(cosines.max(1)))
    assert nearest.min() > 10.0 and nearest.max() < 22.0, nearest  # of 0.62 of the sphere each has 16.5° square
    alone = rough_parts.surface_points(orbit(0))
    assert alone[-1] == orbit(0).middle_point() and len(alone) == rough_parts.VIEWPOINTS + 1


def test_a_bake_that_was_stopped_amid_its_pictures_goes_on_to_the_same_files(tmp_path: Path) -> None:
    whole = small_bake(tmp_path / "whole")
    assert whole.surface is not None and whole.surface.light.shape[1:] == (SIDES[0] ** 2, 4)

    def stop(name: str, done: int, _: int) -> None:
        if (name, done) == ("rough surfaces", 3):
            raise StoppedError

    with pytest.raises(StoppedError):
        small_bake(tmp_path / "stopped", progress=stop)
    told = []
    small_bake(tmp_path / "stopped", resume=True, progress=lambda *step: told.append(step))
    assert files(tmp_path / "whole") == files(tmp_path / "stopped")
    assert not any(name == "light on surfaces" for name, *_ in told)  # what was traced was kept


def test_static_bakes_infer_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rough_parts, "infer_surface", None)
    assert small_bake(tmp_path / "pem", static=True).surface is not None
