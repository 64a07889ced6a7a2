"""The geometries of an object's shells."""

from collections.abc import Sequence

from reflet.envmap.geometry import Geometry
from reflet.envmap.relief import Relief
from reflet.envmap.shapes import InfiniteSphere
from reflet.infer.fit_geometry import fit
from reflet.infer.fit_relief import last_relief, median_box, near_relief
from reflet.scene.scene import Scene
from reflet.trace.layers import StaticProbe


def fit_shells(kinds: Sequence[str], scene: Scene, parts: Sequence[int], probe: StaticProbe) -> list[Geometry]:
    """A geometry of each kind for the probe's shells, nearest first, around ``parts``.

    One shell alone is fitted as `fit` says. Of several, the nearer ones are reliefs, and the last is a relief, the box
    that holds what it shows, or the sphere at infinity; this one too where nothing of it is nearer. Raises ValueError
    for other kinds.
    """
    if len(kinds) == 1:
        return [fit(kinds[0], scene, parts, probe)]
    if set(kinds[:-1]) != {Relief.kind} or kinds[-1] not in (Relief.kind, "box", "infinite_sphere"):
        raise ValueError(f"shells have reliefs, and the last may have a box or the sphere at infinity: {kinds}")
    room = fit("box", scene, parts, probe)
    near = [near_relief(shell.distance, probe.origin, room) for shell in probe.shells[:-1]]
    if kinds[-1] == InfiniteSphere.kind:
        return [*near, InfiniteSphere()]
    distance = probe.shells[-1].distance
    beyond = median_box(distance, probe.origin)
    return [*near, last_relief(distance, probe.origin, beyond) if kinds[-1] == Relief.kind else beyond]
