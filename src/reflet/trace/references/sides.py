"""What the project's BSDFs share: which side of a surface is seen, and where its mirror sends the viewer."""

import drjit as dr
import mitsuba as mi

LEAST_CLIMB = 1e-3  # of a mirrored ray above the geometric surface


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


def mirrored(towards, n, ng):  # type: ignore[no-untyped-def]
    """The viewer's direction mirrored at n, bent above the surface as CONVENTIONS.md says; and whether it was bent."""
    straight = 2.0 * dr.dot(towards, n) * n - towards
    climb = dr.dot(straight, ng)
    bends = climb < LEAST_CLIMB
    return dr.select(bends, dr.normalize(straight + (LEAST_CLIMB - climb) * ng), straight), bends
