"""Geometry and number of shells, chosen in surroundings where the right ones are known."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from small_scenes import ball, beside_a_block, in_a_room, orbit, square, under_the_sky

from reflet.errors import RefletError
from reflet.pipelines.baking import held_back
from reflet.pipelines.baking.choose_distant import AUTO, DistantChoice, check_choice, choose_distant
from reflet.pipelines.baking.held_back import trial_views
from reflet.scene.assemble import assemble
from reflet.scene.material import EnvironmentLight
from reflet.scene.scene import Part, Scene
from reflet.scene.surfaces.irradiance import IrradianceMap
from reflet.trace.layers import Shells
from reflet.trace.tracer import Tracer


@pytest.fixture(autouse=True, scope="module")
def small_trials() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        for name, value in {"_TRIAL_IMAGE_SIZE": 64, "_TRIAL_SPP": 4, "_TRIAL_SAMPLE_COUNT": 4}.items():
            patch.setattr(held_back, name, value)
        yield


def choice(scene: Scene, distant: str = AUTO, shells: int | None = None, views: int = 1) -> DistantChoice:
    none = np.zeros(scene.triangle_offsets[-1], np.uint32)
    tracer = Tracer(scene, irradiance=IrradianceMap(none, none, np.zeros((1, 3), np.float32)))
    space = orbit(views, image_size=40)
    (chosen,) = choose_distant(tracer, space, trial_views(tracer, space), distant, shells)
    return chosen


def test_the_sky_alone_is_infinitely_far_and_costs_no_search() -> None:
    chosen = choice(under_the_sky())
    assert (chosen.kinds, chosen.shells.ends) == (("infinite_sphere",), ())
    assert not chosen.trials  # of a hemisphere either, which some picture may seem to speak for


def test_a_room_is_its_box() -> None:
    chosen = choice(in_a_room())
    assert (chosen.kinds, chosen.shells.ends) == (("box",), ())
    found = {trial.kinds: trial.psnr for trial in chosen.trials}
    assert found[("box",)] > found[("infinite_sphere",)] + 3.0
    assert found[("box",)] > found[("relief",)] - 0.3  # more is not gained by the search


@pytest.fixture(name="divided", scope="module")
def _divided() -> DistantChoice:
    return choice(beside_a_block())


def test_what_stands_near_in_a_room_is_a_shell_of_its_own(divided: DistantChoice) -> None:
    """The screen is 0.6 to 1.04 m away, the walls at least 2."""
    assert divided.kinds in (("relief", "box"), ("relief", "relief"))
    (end,) = divided.shells.ends
    assert 1.04 < end <= 2.0
    best = next(trial for trial in divided.trials if trial.kinds == divided.kinds)
    alone = max(trial.psnr for trial in divided.trials if len(trial.kinds) == 1)
    assert best.psnr > alone + 0.3
    assert best.psnr >= max(trial.psnr for trial in divided.trials) - 0.3
    costs = {trial.kinds: trial.fetches for trial in divided.trials}
    assert costs[("relief", "box")] == 6 and costs[("relief", "relief")] == 10 and costs[("box",)] == 1


def test_what_is_asked_for_is_taken(divided: DistantChoice) -> None:
    scene = beside_a_block()
    assert choice(scene, "box") == DistantChoice(Shells(divided.shells.origin), ("box",))
    assert choice(scene, "ellipsoid", 1).kinds == ("ellipsoid",)
    one, two, three = (choice(scene, "relief", shells) for shells in (1, 2, 3))
    assert (one.kinds, one.shells.ends, one.trials) == (("relief",), (), ())
    assert (two.kinds, two.shells.ends) == (("relief", "relief"), divided.shells.ends)
    assert three == two  # there is one gap: fewer shells than asked for
    single = choice(scene, AUTO, 1)
    assert single.shells.ends == () and {len(trial.kinds) for trial in single.trials} == {1}
    double = choice(scene, AUTO, 2)
    assert double.shells == divided.shells and {len(trial.kinds) for trial in double.trials} == {2}


def test_without_samples_it_is_tried_at_the_orbits_own_place() -> None:
    assert choice(in_a_room(), views=0).kinds == ("box",)


def test_things_under_the_sky_end_in_a_shell_infinitely_far() -> None:
    """Of a shell of nothing but sky the relief and the box are the sphere at infinity, which can be fitted again."""
    screen = square("screen", (-0.6, -0.5, -0.6), (0.0, 0.0, 1.1), (0.0, 0.9, 0.0), (1.0, 0.9, 0.2), 5)
    scene = assemble([ball(), screen], environment=under_the_sky().environment)
    chosen = choice(scene, AUTO, 2)
    assert chosen.kinds == ("relief", "infinite_sphere") and len(chosen.shells.ends) == 1
    assert [trial.kinds for trial in chosen.trials] == [chosen.kinds]
    assert choice(scene, "relief", 2).shells == chosen.shells


@pytest.mark.parametrize("radiance", [0.0, 0.5])
def test_where_all_candidates_are_perfect_numbers_stay_finite(radiance: float) -> None:
    """A scene without light, or of the same light everywhere: nothing differs."""
    scene = assemble([ball()], environment=EnvironmentLight(np.full((4, 8, 3), radiance, np.float32)))
    chosen = choice(scene)
    assert chosen.kinds == ("infinite_sphere",)
    assert all(30.0 < trial.psnr <= 99.0 for trial in chosen.trials)


def test_every_object_has_a_choice_of_its_own() -> None:
    """One stands beside the screen, which is far from the other."""
    here, screen, *room = beside_a_block().parts
    small = replace(here.mesh, positions=here.mesh.positions * np.float32(0.3) + np.float32([1.2, 0.0, 0.0]))
    moved = Part("moved", small, here.material)
    scene = assemble([here, moved, screen, *room])
    none = np.zeros(scene.triangle_offsets[-1], np.uint32)
    tracer = Tracer(scene, irradiance=IrradianceMap(none, none, np.zeros((1, 3), np.float32)))
    choices = choose_distant(tracer, orbit(image_size=24), [], "relief", 2)
    assert [len(each.kinds) for each in choices] == [2] * len(scene.objects)
    assert len({each.shells.origin for each in choices}) == len(scene.objects)


@pytest.mark.parametrize(
    ("distant", "shells", "said"),
    [
        ("box", 2, "box has none. Choose relief or auto, or one shell"),
        ("auto", 4, "1 to 3 shells, not 4"),
        ("relief", 0, "1 to 3 shells, not 0"),
        ("cylinder", None, "cylinder is none"),
    ],
)
def test_what_cannot_be_is_one_sentence(distant: str, shells: int | None, said: str) -> None:
    with pytest.raises(RefletError, match=said):
        check_choice(distant, shells)
