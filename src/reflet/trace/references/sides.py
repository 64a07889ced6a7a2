"""What the project's BSDFs share: which side of a surface is seen."""

import drjit as dr
import mitsuba as mi


def sides(si, double_sided: bool, active):  # type: ignore[no-untyped-def]
    """Unit direction to the viewer, the geometric and the interpolated normal, both turned there, and what is not
    black: the backs of single-sided faces are."""
    towards = si.to_world(si.wi)
    front = dr.dot(si.n, towards) > 0.0
    ng = dr.select(front, si.n, -si.n)
    return towards, ng, turned(si.sh_frame.n, ng), active & (front | mi.Bool(double_sided))


def turned(n, ng):  # type: ignore[no-untyped-def]
    """A shading normal on the side of the geometric one."""
    return dr.select(dr.dot(n, ng) < 0.0, -n, n)
