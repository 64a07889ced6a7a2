"""Bakes of a small scene in several parameterizations show what the cube shows, and ray tracing."""

from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from test_verify import ring

from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS
from reflet.errors import RefletError
from reflet.pem.container import open_pem
from reflet.pipelines.bake import bake, default_size
from reflet.pipelines.compare import object_radiance, straight
from reflet.render.playback.renderer import Renderer
from reflet.report.measures import squared_error
from reflet.scene.material import EnvironmentLight, Material
from reflet.scene.scene import Part, ReflectiveObject, Scene
from reflet.scene.views.parameter_space import Axis, Orbit, ParameterSpace
from reflet.trace.tracer import Tracer

SPACE = ParameterSpace((Axis("azimuth_deg", (60.0, 66.0)),), Orbit((0, 0, 0), 60.0, 22.0, 1.25, image_size=64))
SIZE = 64  # of the others; `test_verify` has all seven


class StoppedError(Exception):
    """As Ctrl-C."""


def scene() -> Scene:
    """A mirror ring under a sky that is bright in one corner and has no symmetry."""
    v, u = np.meshgrid(np.linspace(0, np.pi, 32), np.linspace(-np.pi, np.pi, 64), indexing="ij")
    sky = np.stack(
        [0.5 + 0.4 * np.cos(u) * np.sin(v), 0.5 + 0.4 * np.cos(2 * v), 0.5 + 0.4 * np.sin(u) * np.sin(v)], -1
    )
    sky[4:8, 20:26] = 5.0
    mirror = Material(base_color=(0.65,) * 3, metallic=1.0, perceptual_roughness=0.0)
    part = Part("ring", ring(), mirror, True)
    return Scene((part,), (ReflectiveObject("ring", (0,)),), EnvironmentLight(sky.astype(np.float32)))


@pytest.fixture(name="psnr", scope="module")
def _psnr(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str, int], list[float]]:
    """Display PSNR of one at a sample, and between the two, where gazing balls of two frames blend."""
    points = ({"azimuth_deg": 60.0}, {"azimuth_deg": 63.0})
    tracer = Tracer(scene())
    references = [
        tracer.view(SPACE.orbit.camera(point), spp=64, sample_count=1, seed=9, surroundings=True).layers
        for point in points
    ]

    @cache
    def of(name: str, size: int) -> list[float]:
        folder = tmp_path_factory.mktemp("pem") / name
        pem = open_pem(bake(scene(), folder, SPACE, parameterization=name, em_size=size, spp=16, distant="box"))
        assert {layer.parameterization.name for layer in pem.layers} == {name}
        renderer, found = Renderer(pem), []
        for layers in references:
            truth, coverage = object_radiance(layers)
            shown = straight(renderer.frame(layers.camera, what="object"))
            found.append(squared_error(truth, shown, coverage > 0.5).psnr)
        return found

    return of


@pytest.mark.parametrize("name", [
    "gazing_ball",
    # its maps are of the shells in tests/render/test_shells.py, and opened in tests/view/test_kinds.py
    pytest.param("dual_paraboloid", marks=pytest.mark.slow),
])  # fmt: skip
def test_each_is_as_good_as_the_cube(psnr: Callable[[str, int], list[float]], name: str) -> None:
    """Within 3 dB: the gazing ball of 64 rows has half the cube's texels. A face or an axis gone wrong costs 10 dB."""
    cubes, ours = psnr("cube", 32), psnr(name, SIZE)
    assert min(cubes) > 24.0
    assert all(one > another - 3.0 for one, another in zip(ours, cubes, strict=True)), (ours, cubes)


def test_a_bake_goes_on_in_its_own_parameterization_only(tmp_path: Path) -> None:
    """As soon as it has begun."""

    def stop(_stage: str, done: int, _total: int) -> None:
        if done:
            raise StoppedError

    with pytest.raises(StoppedError):
        bake(scene(), tmp_path / "pem", SPACE, parameterization="octahedral", em_size=4, spp=1, progress=stop)
    with pytest.raises(RefletError, match='begun with parameterization "octahedral", not "cube"'):
        bake(scene(), tmp_path / "pem", SPACE, em_size=4, spp=1, resume=True)


def test_unknown_parameterizations_are_refused(tmp_path: Path) -> None:
    with pytest.raises(RefletError, match="mercator is none"):
        bake(scene(), tmp_path, parameterization="mercator")


def test_by_default_all_have_about_the_texels_of_a_cube_of_256() -> None:
    assert {name: default_size(each) for name, each in PARAMETERIZATIONS.items()} == {
        "cube": 256, "latlong": 512, "dual_paraboloid": 512, "gazing_ball": 512, "angular": 512, "octahedral": 512,
        "equal_area_octahedral": 512,
    }  # fmt: skip
