"""What a bake tells of itself: something from the start, and the end of every stage."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from reflet.pipelines.bake import bake
from reflet.pipelines.load import load_scene
from reflet.scene.assemble import assemble
from reflet.scene.material import MIRROR, EnvironmentLight, Material
from reflet.scene.meshes.primitives import sphere_mesh, torus_mesh
from reflet.scene.scene import Part, Scene
from reflet.scene.views.framing import frame_orbit
from reflet.scene.views.parameter_space import orbit_space


class StoppedError(Exception):
    """As Ctrl-C."""


@pytest.fixture(scope="module")
def scene() -> Scene:
    light = EnvironmentLight(np.ones((8, 16, 3), np.float32))
    stand = Part("stand", sphere_mesh(0.4, (0.0, -1.2, 0.0), 16), Material(metallic=0.0))
    return assemble([Part("ring", torus_mesh(around=24, sides=12), MIRROR), stand], environment=light)


@pytest.fixture(autouse=True, scope="module")
def few_trials() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        for module in ("reflet.infer.fit_local", "reflet.pipelines.baking.plan_layers"):
            patch.setattr(f"{module}.TRIALS", 3)
        yield


def small_bake(scene: Scene, out: Path, progress, **options) -> None:  # type: ignore[no-untyped-def]
    space = orbit_space(frame_orbit(scene, image_size=24), 1, 2.0)
    bake(scene, out, space, em_size=8, spp=4, sample_count=4, local="ellipsoid", progress=progress, **options)


@pytest.fixture(scope="module")
def undisturbed(scene: Scene, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[tuple[str, int, int]]]:
    """A whole bake, and what it told."""
    told: list[tuple[str, int, int]] = []
    out = tmp_path_factory.mktemp("whole") / "out"
    small_bake(scene, out, lambda *step: told.append(step))
    return out, told


def test_every_stage_is_told_from_its_beginning_to_its_end(undisturbed) -> None:  # type: ignore[no-untyped-def]
    _, told = undisturbed
    stages = list(dict.fromkeys(stage for stage, _, _ in told))
    assert stages == [
        "prepare", "diffuse light", "choose shells", "static maps", "joint set", "local shapes", "viewpoints", "fade",
        "write",
    ]  # fmt: skip
    for stage in stages:
        steps = [(done, total) for name, done, total in told if name == stage]
        assert steps[0][0] == 0 and steps[-1][0] == steps[-1][1], stage
        assert [done for done, _ in steps] == sorted(done for done, _ in steps), stage
    # what lasts long has many steps: each trial of the shape of the ring's local layer
    assert [step for step in told if step[0] == "local shapes"][-1] == ("local shapes", 3, 3)


def test_the_first_word_comes_before_the_file_is_opened(tmp_path: Path) -> None:
    told: list[tuple[str, int, int]] = []
    broken = tmp_path / "broken.glb"
    broken.write_bytes(b"no glTF at all")

    def stop(*step: int | str) -> None:
        told.append(step)  # type: ignore[arg-type]
        raise StoppedError

    with pytest.raises(StoppedError):
        load_scene(broken, progress=stop)
    assert told == [("read", 0, 3)]


def test_a_bake_stopped_before_its_views_goes_on_and_keeps_its_light(scene: Scene, tmp_path: Path, undisturbed) -> None:  # type: ignore[no-untyped-def]
    """What is found after resuming equals an undisturbed bake, byte for byte; light that was traced is not again."""

    def stop(name: str, done: int, total: int) -> None:
        if name == "static maps" and done == total:
            raise StoppedError

    out, (whole, _) = tmp_path / "out", undisturbed
    with pytest.raises(StoppedError):
        small_bake(scene, out, stop)
    told: list[str] = []
    small_bake(scene, out, lambda name, *_: told.append(name), resume=True)
    assert "diffuse light" not in told
    files = {path.relative_to(whole) for path in whole.rglob("*") if path.is_file() and path.suffix != ".jsonl"}
    assert files and all((whole / name).read_bytes() == (out / name).read_bytes() for name in files)
