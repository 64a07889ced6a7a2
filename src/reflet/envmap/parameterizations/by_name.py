"""All parameterizations, by name."""

from reflet.envmap.parameterizations.angular import Angular
from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.parameterizations.dual_paraboloid import DualParaboloid
from reflet.envmap.parameterizations.equal_area_octahedral import EqualAreaOctahedral
from reflet.envmap.parameterizations.gazing_ball import GazingBall
from reflet.envmap.parameterizations.latlong import LatLong
from reflet.envmap.parameterizations.octahedral import Octahedral
from reflet.envmap.parameterizations.parameterization import Parameterization
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
