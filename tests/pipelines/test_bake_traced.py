"""Bakes whose local light is traced: the base is chosen, the tree is written, and mirrors show one another."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from small_scenes import ball, beside_a_block, files, in_a_room, orbit, under_the_sky

from reflet.infer.solve import SolverSettings
from reflet.pem.container import open_pem
from reflet.pem.pem import ParameterizedEnvironmentMap
from reflet.pipelines.bake import GLASS_HITS, MIRROR_HITS, bake
from reflet.pipelines.baking import base_maps, held_back, joint_set
from reflet.render.playback.renderer import Renderer
from reflet.report.measures import squared_error
from reflet.report.table import pem_table
from reflet.scene.assemble import assemble
from reflet.scene.material import Refraction
from reflet.scene.scene import Part, Scene
from reflet.scene.views.parameter_space import ParameterSpace
from reflet.trace.compose import object_radiance
from reflet.trace.tracer import Tracer


class StoppedError(Exception):
    """As Ctrl-C."""


@pytest.fixture(autouse=True, scope="module")
def small_work() -> Iterator[None]:
    few = {"_TRIAL_IMAGE_SIZE": 32, "_TRIAL_SPP": 4, "_TRIAL_SAMPLE_COUNT": 4, "_CLOSE_SIZE": 16}
    with pytest.MonkeyPatch.context() as patch:
        for name, value in few.items():
            patch.setattr(held_back, name, value)
        patch.setattr(base_maps, "_ENOUGH", 90.0)
        patch.setattr(joint_set, "SPACING_DEG", 180.0)
        patch.setattr(joint_set, "COARSE_SPACING_DEG", 180.0)
        patch.setattr(joint_set, "_SETTINGS", SolverSettings(regularization=0.02, rounds=(3, 2)))
        yield


def small_bake(scene: Scene, out: Path, space: ParameterSpace, **options) -> ParameterizedEnvironmentMap:  # type: ignore[no-untyped-def]
    options = {"em_size": 16, "spp": 4, "sample_count": 4, **options}
    return open_pem(bake(scene, out, space, **options))


def beside_itself() -> Scene:
    """Two mirror balls that do not touch: two objects, in a room."""
    scene = in_a_room()
    here, *room = scene.parts
    assert here.reflective
    small = replace(here.mesh, positions=here.mesh.positions * np.float32(0.5) + np.float32([0.8, 0.0, 0.0]))
    return assemble([here, Part("moved", small, here.material), *room], environment=scene.environment)


@pytest.fixture(name="two", scope="module")
def _two(tmp_path_factory: pytest.TempPathFactory) -> ParameterizedEnvironmentMap:
    return small_bake(beside_itself(), tmp_path_factory.mktemp("two") / "pem", orbit(0, image_size=48), em_size=32)


def test_it_has_distant_layers_alone_and_a_tree(two: ParameterizedEnvironmentMap) -> None:
    assert two.most_hits == MIRROR_HITS and two.bvh is not None
    assert {layer.kind for layer in two.layers} == {"distant"} and not len(two.maps)
    assert len(two.base) == len(two.distant_layers) >= 2
    told = two.statistics["base"]
    better = "joint" if told["joint_psnr"] > told["static_psnr"] + 0.2 else "static"
    assert told["kind"] == better and two.lod_bias == -3.0
    assert ("joint" in two.statistics) == (better == "joint")
    assert "at held-back viewpoints" in pem_table(two)


def test_mirrors_that_do_not_touch_show_one_another(two: ParameterizedEnvironmentMap) -> None:
    """Each one's distant light is that behind both, so that the other is seen where it is, and nowhere twice."""
    camera = two.space.orbit.camera({"azimuth_deg": 70.0, "elevation_deg": 20.0})
    renderer, tracer = Renderer(two), Tracer(two.scene, irradiance=two.irradiance)
    truth, coverage = object_radiance(tracer.view(camera, spp=64).layers)
    errors = {}
    for name, layers in (
        ("traced", ("diffuse", "fresnel", "distant", "local")),
        ("not", ("diffuse", "fresnel", "distant")),
    ):
        frame = renderer.frame(camera, what="object", samples=16, layers=layers)  # type: ignore[arg-type]
        shown = frame[..., :3] / np.maximum(frame[..., 3:], np.float32(1e-6))
        errors[name] = squared_error(truth, shown, coverage > 0.5).psnr
    assert errors["traced"] > errors["not"] + 1.0  # a tenth of the picture is a ball in the other
    assert errors["traced"] > 24.0  # maps of 32 rows


def test_static_maps_that_show_enough_are_the_base(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(base_maps, "_ENOUGH", 5.0)
    monkeypatch.setattr(base_maps, "infer_joint_set", None)  # is not asked
    pem = small_bake(under_the_sky(), tmp_path / "pem", orbit(0))
    assert pem.statistics["base"]["joint_psnr"] is None and pem.statistics["base"]["kind"] == "static"
    assert "nothing was inferred" in pem_table(pem)


def test_who_asks_for_a_joint_set_gets_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """However good static maps are."""
    monkeypatch.setattr(base_maps, "_ENOUGH", 5.0)
    pem = small_bake(under_the_sky(), tmp_path / "pem", orbit(0), joint_spacing_deg=180.0)
    assert pem.statistics["joint"]["viewpoints"] > 0 and "base" not in pem.statistics


def test_what_inference_harms_is_left_static(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def spoilt(*arguments, **options):  # type: ignore[no-untyped-def]
        maps, solutions = joint_set.infer_joint_set(*arguments, **options)
        return [replace(each, texels=0.2 * each.texels) for each in maps], solutions

    monkeypatch.setattr(base_maps, "infer_joint_set", spoilt)
    pem = small_bake(in_a_room(), tmp_path / "pem", orbit(0))
    told = pem.statistics["base"]
    assert told["kind"] == "static" and told["static_psnr"] > told["joint_psnr"] + 3.0
    assert pem.base[0].texels.max() > 0.3 and "joint" not in pem.statistics


def test_viewpoints_may_have_maps_over_the_base(tmp_path: Path) -> None:
    pem = small_bake(beside_a_block(), tmp_path / "pem", orbit(2), distant="relief", shells=2)
    assert len(pem.maps) == 2 and {layer.kind for layer in pem.layers} == {"distant"}
    assert pem.fade_deg >= 2.0 and pem.most_hits == MIRROR_HITS


def test_a_bake_that_was_stopped_goes_on_to_the_same_files(tmp_path: Path) -> None:
    scene, space = beside_a_block(), orbit(0)
    small_bake(scene, tmp_path / "whole", space)

    def stop(name: str, done: int, _: int) -> None:
        if (name, done) == ("joint set", 2):
            raise StoppedError

    with pytest.raises(StoppedError):
        small_bake(scene, tmp_path / "stopped", space, progress=stop)
    small_bake(scene, tmp_path / "stopped", space, resume=True)
    assert files(tmp_path / "whole") == files(tmp_path / "stopped")


def test_glass_may_be_met_more_often(tmp_path: Path) -> None:
    """A ray goes through both of its sides."""
    clear = ball()
    glass = replace(clear, material=replace(clear.material, metallic=0.0, refraction=Refraction(1.5)))
    pem = small_bake(
        assemble([glass], environment=under_the_sky().environment), tmp_path / "pem", orbit(0), static=True
    )
    assert pem.most_hits == GLASS_HITS > MIRROR_HITS


def test_what_stands_close_is_met_and_in_no_shell(tmp_path: Path) -> None:
    """A ball and a screen beside it, and nothing else: all light is traced, and the shells are black."""
    scene = assemble([part for part in beside_a_block().parts if part.name in ("ball", "screen")])
    pem = small_bake(scene, tmp_path / "pem", orbit(0, image_size=48), static=True)
    assert pem.companions == (1,) and pem.bvh is not None
    assert not any(each.texels[:, :3].any() for each in pem.base)
    camera = pem.space.orbit.camera({"azimuth_deg": 150.0, "elevation_deg": 20.0})
    truth, coverage = object_radiance(Tracer(scene, irradiance=pem.irradiance).view(camera, spp=256).layers)
    frame = Renderer(pem).frame(camera, what="object", samples=64)
    shown = frame[..., :3] / np.maximum(frame[..., 3:], np.float32(1e-6))
    assert truth[coverage > 0.5].max() > 0.5
    # What is left is how 64 and 256 samples fall on the tiles' edges.
    assert squared_error(truth, shown, coverage > 0.5).psnr > 38.0


def test_a_box_may_stand_for_the_room(tmp_path: Path) -> None:
    """As in the paper but for what is local: its base is chosen too."""
    pem = small_bake(assemble([ball(), *in_a_room().parts[1:]]), tmp_path / "pem", orbit(0), distant="box")
    assert [layer.geometry.kind for layer in pem.layers] == ["box"] and len(pem.base) == 1
