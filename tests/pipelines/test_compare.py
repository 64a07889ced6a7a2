"""What a comparison measures, where, and by which methods."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from small_scenes import beside_a_block, in_a_room, orbit, under_the_sky

from reflet.infer.solve import SolverSettings
from reflet.pem.container import open_pem
from reflet.pem.pem import ParameterizedEnvironmentMap
from reflet.pipelines import compare as module
from reflet.pipelines.bake import bake
from reflet.pipelines.baking import joint_set
from reflet.pipelines.compare import compare, dome_points, straight
from reflet.pipelines.rivals import as_if_smooth, engine_lights, static_shells
from reflet.render.playback.renderer import Renderer
from reflet.report.comparison import METHODS, PLACES, Comparison
from reflet.report.measures import display_psnr
from reflet.scene.assemble import assemble
from reflet.scene.material import MIRROR
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.meshes.primitives import sphere_mesh
from reflet.scene.scene import Part, Scene
from reflet.trace.compose import object_radiance
from reflet.trace.tracer import Tracer

OWN = ["layered", "distant-only", "distant-only-static", "static-shells"]


@pytest.fixture(autouse=True, scope="module")
def small_work() -> Iterator[None]:
    """Short solves, and two of the twelve views of the dome."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "dome_points", lambda azimuths: dome_points(azimuths)[::9])
        patch.setattr(joint_set, "_SETTINGS", SolverSettings(regularization=0.02, rounds=(3, 2)))
        yield


def pem_of(scene: Scene, folder: Path, views: int, **options) -> ParameterizedEnvironmentMap:  # type: ignore[no-untyped-def]
    options = {"em_size": 16, "spp": 4, "sample_count": 4, "joint_spacing_deg": 180.0, "local": "ellipsoid", **options}
    return open_pem(bake(scene, folder, orbit(views, image_size=24), **options))


def compared(pem: ParameterizedEnvironmentMap) -> Comparison:
    """Without rivals, which take time to compile; the command's tests have them."""
    return compare(pem, samples=1, reference_spp=8, trace_spp=4, rivals=False)


def psnr(comparison: Comparison, method: str) -> dict[str, float]:
    return {r.where: r.psnr_display for r in comparison.results if r.method == method}


@pytest.mark.parametrize("azimuths", [(60.0,), (60.0, 62.0, 64.0), (-170.0, 10.0)])
def test_the_dome_has_one_viewpoint_in_each_of_its_cells(azimuths: tuple[float, ...]) -> None:
    points = np.array(dome_points(azimuths))
    assert points.shape == (12, 2)
    width = (azimuths[-1] - azimuths[0] + 40.0) / 4.0
    column = (points[:, 0] - (azimuths[0] - 20.0)) / width
    row = (points[:, 1] - 12.0) / (40.0 / 3.0)
    assert (points[:, 1] >= 12.0).all() and (points[:, 1] <= 52.0).all()
    cells = sorted(zip(np.floor(column).astype(int).tolist(), np.floor(row).astype(int).tolist(), strict=True))
    assert cells == [(k, m) for k in range(4) for m in range(3)]
    np.testing.assert_array_equal(points, dome_points(azimuths))  # the same on every run
    assert np.unique(np.round(column % 1.0, 6)).size == 12  # and at random within


def test_a_pem_with_shells_and_a_base_is_measured_in_all_its_parts(tmp_path: Path) -> None:
    comparison = compared(pem_of(beside_a_block(), tmp_path / "pem", 2, distant="relief", shells=2))
    assert comparison.methods == [method for method in METHODS if method in (*OWN, "distant-only-joint")]
    assert {(r.where, r.method) for r in comparison.results} == {(w, m) for w in PLACES for m in comparison.methods}
    assert [exhibit.where for exhibit in comparison.exhibits] == list(PLACES)
    # a convex ball has no local layer: what shows of the shells alone is the whole
    static = psnr(comparison, "static-shells")
    for where, value in psnr(comparison, "distant-only-static").items():
        assert value == pytest.approx(static[where], abs=1.0)  # other sub-samples at silhouettes


def test_a_pem_of_the_papers_kind_has_no_joint_set(tmp_path: Path) -> None:
    comparison = compared(pem_of(in_a_room(), tmp_path / "pem", 1, distant="box"))
    assert comparison.methods == [method for method in METHODS if method in OWN]
    assert {r.where for r in comparison.results} == set(PLACES) - {"between"}


def test_a_pem_without_samples_is_compared_at_viewpoints_that_stand_for_them(tmp_path: Path) -> None:
    comparison = compared(pem_of(in_a_room(), tmp_path / "pem", 0, static=True))
    assert {r.where for r in comparison.results} == set(PLACES)
    # it is static shells itself
    layered, static = psnr(comparison, "layered"), psnr(comparison, "static-shells")
    assert layered == pytest.approx(static, abs=0.3)  # of half floats, and of probes traced twice
    assert min(layered.values()) > 20.0


def test_static_shells_of_a_map_that_turns_with_the_camera_are_those_of_a_cube(tmp_path: Path) -> None:
    """Also where the orbit's own azimuth is no sample's."""
    space = orbit(1, image_size=24)
    turned = replace(space, orbit=replace(space.orbit, azimuth_deg=110.0))
    frames = []
    for name, size in (("cube", 32), ("gazing_ball", 64)):
        options = {"parameterization": name, "em_size": size, "spp": 1, "sample_count": 1, "distant": "box"}
        pem = open_pem(bake(in_a_room(), tmp_path / name, turned, **options))
        renderer = Renderer(static_shells(pem, Tracer(pem.scene, irradiance=pem.irradiance)))
        frames.append(renderer.frame(space.camera(0), what="object", samples=1))
    error = np.abs(frames[0] - frames[1])[..., :3][frames[0][..., 3] > 0.0]
    assert len(error) > 200 and frames[0].max() > 0.5
    assert error.mean() < 0.05  # the other's texels; in another frame it would be 0.2


def test_a_pem_that_traces_its_own_mesh_is_measured_beside_the_papers_layers(tmp_path: Path) -> None:
    """A bowl, which shows much of itself; static for the comparison's sake."""
    mesh = sphere_mesh(0.3, (0.0, 0.0, 0.0), 12)
    bowl = mesh.positions[mesh.triangles].mean(1)[:, 1] < 0.05
    inside = Mesh(mesh.positions, -mesh.normals, np.ascontiguousarray(mesh.triangles[bowl][:, ::-1]))
    scene = assemble([Part("bowl", inside, MIRROR)], environment=under_the_sky().environment)
    pem = pem_of(scene, tmp_path / "pem", 0, static=True, local="traced")
    comparison = compare(pem, samples=4, reference_spp=16, trace_spp=4)
    assert set(METHODS) - set(comparison.methods) == {"distant-only-joint", "mirror"}  # nothing is rough
    assert comparison.played == "traced"
    traced, static, layered = (psnr(comparison, method) for method in ("traced", "traced-static", "layered"))
    for where, value in traced.items():
        assert value == pytest.approx(static[where], abs=0.3)  # of half floats, and of probes traced twice
        assert value > psnr(comparison, "static-shells")[where] + 3.0  # most of the bowl shows the bowl
    assert traced["above-20"] > layered["above-20"] + 3.0


def test_engines_show_smooth_balls_as_mirrors_do_and_rough_ones_better(tmp_path: Path) -> None:
    """Balls, which nothing hides anything of, under a sky."""
    found = {}
    for roughness in (0.0, 0.5):
        ball = Part("ball", sphere_mesh(0.3, around=64), replace(MIRROR, perceptual_roughness=roughness))
        scene = assemble([ball], environment=under_the_sky().environment)
        pem = pem_of(scene, tmp_path / f"{roughness}", 0, static=True, local="traced", em_size=64)
        tracer, camera = Tracer(scene, irradiance=pem.irradiance), pem.space.orbit.camera()
        undivided = module._undivided(pem, tracer)
        engine = tracer.split_sum(camera, engine_lights(undivided.static["box"], undivided.probes))
        smooth, played = (
            straight(Renderer(each).frame(camera, what="object", samples=16))
            for each in (as_if_smooth(pem, "llvm_ad_rgb"), pem)
        )
        truth, coverage = object_radiance(tracer.view(camera, spp=256, sample_count=1).layers)
        shown = {"engine": engine, "mirror": smooth, "played": played}
        found[roughness] = {name: display_psnr(truth, each, coverage == 1.0) for name, each in shown.items()}
        if roughness == 0.0:  # one map, whose texels one looks up by their LOD and the other interpolates
            assert display_psnr(smooth, engine, coverage == 1.0) > 45.0
    assert min(found[0.0].values()) > 45.0
    rough = found[0.5]
    assert rough["mirror"] + 4.0 < rough["engine"] < rough["played"] - 3.0  # 27, 34 and 41 dB
