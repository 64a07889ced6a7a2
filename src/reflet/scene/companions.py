"""What stands close to an object that mirrors, without reflecting itself: rays meet it where it truly is."""

from collections.abc import Collection

import numpy as np

from reflet.scene.bounds import object_positions
from reflet.scene.scene import Scene

GROWTH = 1.0  # on every side, in units of the object's largest side


def companions(scene: Scene) -> tuple[int, ...]:
    """Indices of the parts that do not reflect and lie, whole, within some object's bounding box, grown on every side
    by its largest side: the rest of its model, but neither the room around it nor the table beneath. And the scene's
    own floor, which begins where the model ends.

    An env map shows from one point what is so near, so mirrored rays meet these parts' own meshes.
    """
    others = [number for number, part in enumerate(scene.parts) if not part.reflective and len(part.mesh.positions)]
    if not others:
        return ()
    low = np.array([scene.parts[number].mesh.positions.min(axis=0) for number in others])
    high = np.array([scene.parts[number].mesh.positions.max(axis=0) for number in others])
    near = np.zeros(len(others), bool)
    for index, item in enumerate(scene.objects):
        if set(scene.floor) & set(item.parts):
            continue
        positions = object_positions(scene, index)
        lower, upper = positions.min(axis=0), positions.max(axis=0)
        margin = GROWTH * float((upper - lower).max())
        near |= (low >= lower - margin).all(axis=1) & (high <= upper + margin).all(axis=1)
    near |= np.isin(others, scene.floor)
    return tuple(number for number, is_near in zip(others, near.tolist(), strict=True) if is_near)


def traced_parts(scene: Scene, beside: Collection[int] | None = None) -> tuple[int, ...]:
    """Indices of all parts that mirrored rays may meet: those that reflect, and the companions ``beside`` them, by
    default all that there are."""
    met = set(companions(scene) if beside is None else beside)
    return tuple(number for number, part in enumerate(scene.parts) if part.reflective or number in met)
