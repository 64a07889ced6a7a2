"""All parameterizations, by name."""

from reflet.envmap.angular import Angular
from reflet.envmap.cube import CUBE
from reflet.envmap.dual_paraboloid import DualParaboloid
from reflet.envmap.equal_area_octahedral import EqualAreaOctahedral
from reflet.envmap.gazing_ball import GazingBall
from reflet.envmap.latlong import LatLong
from reflet.envmap.octahedral import Octahedral
from reflet.envmap.parameterization import Parameterization
from reflet.errors import RefletError

PARAMETERIZATIONS: dict[str, Parameterization] = {
    each.name: each
    for each in (
        CUBE,
        LatLong(),
        DualParaboloid(),
        GazingBall(),
        Angular(),
        Octahedral(),
        EqualAreaOctahedral(),
    )
}


def parameterization(name: str) -> Parameterization:
    """The parameterization of this name. Raises RefletError where there is none."""
    if name not in PARAMETERIZATIONS:
        raise RefletError(f"A parameterization is one of {', '.join(PARAMETERIZATIONS)}; {name} is none.")
    return PARAMETERIZATIONS[name]
