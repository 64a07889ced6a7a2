"""Bakes with shells, with and without samples: what is written, what is kept, and that it shows the scene."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from small_scenes import beside_a_block, files, in_a_room, orbit, under_the_sky

from reflet.envmap.geometry import Box, InfiniteSphere
from reflet.envmap.relief import Relief
from reflet.errors import RefletError
from reflet.infer.shown import shown_rows
from reflet.infer.solve import SolverSettings
from reflet.pem.container import open_pem
from reflet.pem.pem import ParameterizedEnvironmentMap
from reflet.pipelines.bake import bake
from reflet.pipelines.baking import held_back, joint_set
from reflet.pipelines.baking.held_back import held_back_views
from reflet.pipelines.baking.probes import PROBE_SPP
from reflet.scene.assemble import assemble
from reflet.scene.scene import Part, Scene
from reflet.scene.views.parameter_space import ParameterSpace
from reflet.trace.layers import Shells
from reflet.trace.tracer import Tracer


class StoppedError(Exception):
    """As Ctrl-C."""


@pytest.fixture(autouse=True, scope="module")
def small_work() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        for name, value in {"_TRIAL_IMAGE_SIZE": 64, "_TRIAL_SPP": 4, "_TRIAL_SAMPLE_COUNT": 4}.items():
            patch.setattr(held_back, name, value)
        patch.setattr(joint_set, "_SETTINGS", SolverSettings(regularization=0.02, rounds=(3, 2)))
        yield


def small_bake(scene: Scene, out: Path, space: ParameterSpace, **options) -> ParameterizedEnvironmentMap:  # type: ignore[no-untyped-def]
    options = {"em_size": 16, "spp": 4, "sample_count": 4, "joint_spacing_deg": 180.0, "local": "ellipsoid", **options}
    return open_pem(bake(scene, out, space, **options))


@pytest.fixture(name="whole", scope="module")
def _whole(tmp_path_factory: pytest.TempPathFactory) -> tuple[ParameterizedEnvironmentMap, Path]:
    """Two samples, two shells and a base."""
    out = tmp_path_factory.mktemp("whole") / "pem"
    return small_bake(beside_a_block(), out, orbit(2), distant="relief", shells=2), out


def psnr(pem: ParameterizedEnvironmentMap, places: tuple[tuple[float, float], ...], seed: int = 9) -> float:
    """Of the base, under the true local layer, at degrees from the middle sample."""
    tracer = Tracer(pem.scene, irradiance=pem.irradiance)
    views = held_back_views(tracer, pem.space, places, image_size=32, spp=16, sample_count=4, seed=seed)
    errors = [view.error((0,), shown_rows(view.gbuffer, pem.base, pem.lod_bias)) for view in views]
    return sum(errors[1:], errors[0]).psnr


def test_shells_are_layers_with_a_base(whole: tuple[ParameterizedEnvironmentMap, Path]) -> None:
    pem, out = whole
    near, far = (pem.layers[index] for index in pem.distant_layers)
    assert (near.name, far.name) == ("ball near", "ball far")
    assert (near.channels, far.channels) == (4, 3)
    assert near.begin == 0.0 and near.end == far.begin and far.end == np.inf
    assert 1.04 < near.end < 2.0
    assert isinstance(near.geometry, Relief) and isinstance(far.geometry, Relief)
    assert len(pem.maps) == 2 and len(pem.base) == 2
    assert [env_map.texels.shape[1] for env_map in pem.base] == [4, 3]
    assert pem.base[0].texels[:, 3].max() <= 1.0 and (pem.base[0].texels[:, 3] > 0.5).any()
    assert (out / "maps/base/0-ball-near.avif").exists()
    assert not (out / "work").exists()
    assert pem.fade_deg >= 2.0
    told = pem.statistics
    assert told["distant"][0]["kinds"] == ["relief", "relief"] and told["distant"][0]["ends"] == [near.end]
    assert len(told["joint"]["layers"]) == 2 and told["joint"]["viewpoints"] == VIEWPOINTS
    assert [len(sample["layers"]) for sample in told["samples"]] == [len(pem.layers)] * 2


def test_the_joint_base_shows_all_sides_better_than_static_maps(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(joint_set, "_SETTINGS", SolverSettings(regularization=0.02))
    options = {"distant": "relief", "shells": 2, "joint_spacing_deg": 60.0, "em_size": 8, "spp": 16}
    joint = small_bake(beside_a_block(), tmp_path / "joint", orbit(0), **options)
    static = small_bake(beside_a_block(), tmp_path / "static", orbit(0), **options, static=True)
    places = ((0.0, 5.0), (120.0, 10.0), (-60.0, 0.0))
    assert psnr(joint, places) > psnr(static, places) + 1.0
    assert psnr(static, places) > 20.0


VIEWPOINTS = 8  # of a joint set 180 degrees apart: two by two beside the samples, two on the other side, two samples
STOPS = [("joint set", 3), ("viewpoints", 1)]


@pytest.mark.parametrize(("stage", "done"), STOPS)
def test_a_bake_stopped_anywhere_ends_as_an_undisturbed_one(
    whole: tuple[ParameterizedEnvironmentMap, Path], tmp_path: Path, stage: str, done: int
) -> None:
    def stop(name: str, count: int, _total: int) -> None:
        if (name, count) == (stage, done):
            raise StoppedError

    out, told = tmp_path / "pem", []
    with pytest.raises(StoppedError):
        small_bake(beside_a_block(), out, orbit(2), distant="relief", shells=2, progress=stop)
    assert (out / "work").exists() and not (out / "scene.gltf").exists()
    small_bake(
        beside_a_block(), out, orbit(2), distant="relief", shells=2, resume=True,
        progress=lambda name, *_: told.append(name),
    )  # fmt: skip
    assert "diffuse light" not in told
    assert files(out) == files(whole[1])


def test_what_is_solved_is_not_solved_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, whole: tuple[ParameterizedEnvironmentMap, Path]
) -> None:
    """The joint set, above all: its views are traced and its maps inferred once."""

    def stop(name: str, count: int, _total: int) -> None:
        if (name, count) == ("fade", 0):
            raise StoppedError

    with pytest.raises(StoppedError):
        small_bake(beside_a_block(), tmp_path / "pem", orbit(2), distant="relief", shells=2, progress=stop)

    def again(*_args: object, **_options: object) -> None:
        raise AssertionError

    monkeypatch.setattr("reflet.pipelines.baking.joint_set.infer_map", again)
    monkeypatch.setattr("reflet.pipelines.baking.joint_set.layer_rows", again)
    monkeypatch.setattr("reflet.pipelines.baking.viewpoints.infer_view", again)
    small_bake(beside_a_block(), tmp_path / "pem", orbit(2), distant="relief", shells=2, resume=True)
    assert files(tmp_path / "pem") == files(whole[1])


def test_static_maps_are_a_pem_without_samples(tmp_path: Path) -> None:
    told: list[str] = []
    told_of = {"progress": lambda name, *_: told.append(name)}
    pem = small_bake(in_a_room(), tmp_path / "pem", orbit(3), static=True, codec="none", **told_of)
    assert not {"joint set", "local shapes", "fade"} & set(told)
    assert pem.space.sample_count == 0 and len(pem.maps) == 0
    assert [layer.kind for layer in pem.layers] == ["distant"] and isinstance(pem.layers[0].geometry, Box)
    assert pem.lod_bias == -2.5 and "joint" not in pem.statistics
    tracer = Tracer(pem.scene, irradiance=pem.irradiance)
    probe = tracer.probe(0, Shells(pem.layers[0].geometry.origin), size=16, spp=PROBE_SPP)
    # the very probe, in half floats as maps are stored: half a unit in the 11th digit
    np.testing.assert_allclose(pem.base[0].texels, probe.shells[0].texels, rtol=2.0**-11, atol=1e-7)
    assert pem.base_share({"azimuth_deg": 123.0}) == 1.0
    assert not (tmp_path / "pem" / "work").exists()
    assert psnr(pem, ((0.0, 0.0), (150.0, 20.0))) > 18.0


def test_no_samples_are_a_base_alone(tmp_path: Path) -> None:
    pem = small_bake(under_the_sky(), tmp_path / "pem", orbit(0), parameterization="octahedral", em_size=32)
    assert len(pem.maps) == 0 and len(pem.base) == 1 and [layer.kind for layer in pem.layers] == ["distant"]
    assert isinstance(pem.layers[0].geometry, InfiniteSphere)
    assert pem.statistics["joint"]["viewpoints"] == 4 and pem.lod_bias == -2.0
    assert psnr(pem, ((10.0, 5.0), (170.0, 10.0))) > 30.0


def test_shells_may_be_octahedral(tmp_path: Path) -> None:
    pem = small_bake(
        beside_a_block(), tmp_path / "pem", orbit(1), distant="relief", shells=2, parameterization="octahedral",
        em_size=32,
    )  # fmt: skip
    assert [layer.parameterization.name for layer in pem.layers] == ["octahedral"] * len(pem.layers)
    assert len(pem.base) == 2 and psnr(pem, ((0.0, 5.0), (120.0, 10.0))) > 20.0


def test_the_papers_way_has_a_map_a_viewpoint_and_no_base(tmp_path: Path) -> None:
    told: list[str] = []
    pem = small_bake(
        in_a_room(), tmp_path / "pem", orbit(2), distant="box", progress=lambda name, *_: told.append(name)
    )
    assert not {"joint set", "choose shells", "fade"} & set(told)
    assert pem.base == () and pem.fade_deg == 0.0 and len(pem.maps) == 2
    assert isinstance(pem.layers[0].geometry, Box) and "joint" not in pem.statistics
    assert pem.base_share({"azimuth_deg": 200.0}) == 0.0


def test_maps_that_turn_with_the_camera_have_no_base(tmp_path: Path) -> None:
    pem = small_bake(in_a_room(), tmp_path / "pem", orbit(1), parameterization="gazing_ball")
    assert pem.base == () and len(pem.maps) == 1
    for options in ({"static": True}, {"views": 0}):
        space = orbit(options.get("views", 1))
        with pytest.raises(RefletError, match="gazing_ball serves one viewpoint only"):
            small_bake(
                in_a_room(), tmp_path / "none", space, parameterization="gazing_ball", static="static" in options
            )
    assert not (tmp_path / "none").exists()


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"distant": "box", "shells": 2}, "Choose relief or auto, or one shell"),
        ({"shells": 4}, "1 to 3 shells, not 4"),
        ({"distant": "cylinder"}, "cylinder is none"),
        ({"joint_spacing_deg": 0.0}, "a positive angle apart, not 0 degrees"),
    ],
)
def test_nothing_is_written_where_a_bake_is_refused(tmp_path: Path, options: dict[str, object], said: str) -> None:
    with pytest.raises(RefletError, match=said):
        small_bake(in_a_room(), tmp_path / "pem", orbit(1), **options)
    assert not (tmp_path / "pem").exists()


def test_viewpoints_that_see_nothing_ask_for_nothing(tmp_path: Path) -> None:
    """All around stand cameras behind the screen, and outside of the room: the rest is enough."""
    space = orbit(1)
    far = ParameterSpace(space.axes, type(space.orbit)((0, 0, 0), 20.0, 15.0, 2.6, image_size=16))
    pem = small_bake(in_a_room(), tmp_path / "pem", far, joint_spacing_deg=60.0)
    assert all(np.isfinite(env_map.texels).all() for env_map in pem.base)


def test_a_scene_without_light_is_baked(tmp_path: Path) -> None:
    """All differences are zero: what statistics say of them is still a number."""
    lit = in_a_room()
    dark = [replace(part, material=replace(part.material, emission=(0.0, 0.0, 0.0))) for part in lit.parts]
    pem = small_bake(Scene(tuple(dark), lit.objects), tmp_path / "pem", orbit(1))
    assert not any(env_map.texels.any() for env_map in pem.base)
    psnr = [trial["psnr"] for trial in pem.statistics["distant"][0]["trials"]]
    assert len(psnr) > 2 and set(psnr) == {99.0}


def test_objects_have_shells_of_their_own(tmp_path: Path) -> None:
    """The screen is near the ball and far from the knob above it: their layers are as many as each one's gaps."""
    ball, screen, *room = beside_a_block().parts
    mesh = replace(ball.mesh, positions=ball.mesh.positions * np.float32(0.4) + np.float32([0.0, 0.6, 0.0]))
    scene = assemble([ball, Part("knob", mesh, ball.material), screen, *room])
    space = orbit(1, image_size=40)
    space = replace(space, orbit=replace(space.orbit, target=(0.0, 0.25, 0.0), distance=1.9))
    pem = small_bake(scene, tmp_path / "pem", space, static=True)
    names = [item.name for item in pem.scene.objects]
    assert names == ["ball", "knob"]
    of_object = {item.name: [layer for layer in pem.layers if layer.parts == item.parts] for item in pem.scene.objects}
    for item, told in zip(pem.scene.objects, pem.statistics["distant"], strict=True):
        layers = of_object[item.name]
        assert [layer.geometry.kind for layer in layers] == told["kinds"]
        assert [layer.end for layer in layers] == [*told["ends"], np.inf]
    assert len(of_object["ball"]) == 2 and len(pem.base) == len(pem.layers) == sum(map(len, of_object.values()))
    tracer = Tracer(pem.scene, irradiance=pem.irradiance)
    (view,) = held_back_views(tracer, pem.space, [(5.0, 5.0)], image_size=40, spp=16, sample_count=4, seed=3)
    for name, item in zip(names, pem.scene.objects, strict=True):
        maps = [env_map for env_map, layer in zip(pem.base, pem.layers, strict=True) if layer.parts == item.parts]
        assert view.error(item.parts, shown_rows(view.gbuffer, maps, pem.lod_bias)).psnr > 15.0, name


def test_where_the_samples_are_most_is_looked_at(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Rows of the two samples, which come last in the joint set, count eight times."""
    weights = []
    kept = joint_set.row_arrays
    monkeypatch.setattr(joint_set, "row_arrays", lambda rows: weights.append(float(rows.weights.max())) or kept(rows))
    small_bake(beside_a_block(), tmp_path / "pem", orbit(2), distant="relief", shells=1)
    assert len(weights) > 4
    # At most 1 each, (1 + b)⁻² of what is darkest in the view.
    assert min(weights[-2:]) > 3.0 and max(weights[:-2]) <= 1.03
