"""Which parts count as companions of mirrors."""

from dataclasses import replace

import numpy as np
import pytest

from reflet.scene.builtin.teapot_room import teapot_room
from reflet.scene.companions import companions, traced_parts
from reflet.scene.material import Material
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.scene import Part, ReflectiveObject, Scene


def block(name: str, low: tuple[float, float, float], high: tuple[float, float, float]) -> Part:
    """What spans a box, as far as boxes go: one triangle."""
    corners = np.float32([low, high, low])
    return Part(name, Mesh(corners, np.zeros_like(corners), np.uint32([[0, 1, 2]])), Material(name))


MIRROR = replace(block("mirror", (0, 0, 0), (1, 2, 1)), reflective=True)


@pytest.mark.parametrize(
    ("low", "high", "expected"),
    [
        ((0.4, 0.5, 0.4), (0.6, 0.7, 0.6), True),  # within
        ((-2, -2, -2), (3, 4, 3), True),  # as far as its largest side, on every side
        ((-2.01, 0, 0), (0, 1, 1), False),
        ((0, 0, 0), (1, 4.01, 1), False),
        ((5, 0, 0), (6, 1, 1), False),  # small, but far away
        ((-9, -9, -9), (9, 9, 9), False),  # a room
        ((-4, -0.1, -4), (4, 0, 4), False),  # the table beneath
    ],
)
def test_it_lies_whole_within_the_objects_box_grown_by_its_largest_side(low, high, expected) -> None:  # type: ignore[no-untyped-def]
    scene = Scene((block("part", low, high), MIRROR), (ReflectiveObject("mirror", (1,)),))
    assert companions(scene) == ((0,) if expected else ())
    assert traced_parts(scene) == ((0, 1) if expected else (1,))
    assert traced_parts(scene, ()) == (1,)


def test_any_object_may_have_them() -> None:
    """Each in units of its own size; a box around both is none."""
    small = replace(block("small", (50, 0, 0), (50.1, 0.1, 0.1)), reflective=True)
    parts = (MIRROR, block("its", (0, 3, 0), (1, 3, 1)), small, block("far", (51, 0, 0), (51, 1, 1)))
    own = block("own", (50, 0, 0.15), (50, 0.1, 0.2))
    objects = (ReflectiveObject("mirror", (0,)), ReflectiveObject("small", (2,)))
    between = block("between", (20, 0, 0), (21, 1, 1))
    assert companions(Scene((*parts, own, between), objects)) == (1, 4)


def test_the_built_in_teapot_has_none() -> None:
    """Its room, lamp and window stay in the shells."""
    assert companions(teapot_room()) == ()
