"""How irradiance changes as a normal map bends the normal."""

import drjit as dr


def gradient_of(n, direction):  # type: ignore[no-untyped-def]
    """Gradient by the normal of the irradiance that light from a unit direction above n causes, over the irradiance
    at n.

    With c = n·direction, u what is left of direction across n: ((1 + 2c - c²)/2·u + (10c - 3 - 3c²)/4·n)/c. That is
    within 3 % what comes closest, in the least squares, to max(m·direction, 0) for normals m around n, of which those
    8° and 16° from n count three times as much as those 45° from it, and five times those at 60°. Across n, light along
    n counts in full and grazing light half: half of the normals turn away from it. Along n it is less: tilted normals
    lose light along n, and see more of what grazes. Of uniform light (1 + m·n)/2 is seen.
    """
    c = dr.maximum(dr.dot(n, direction), 1e-3)
    across = 0.5 + c - 0.5 * dr.square(c)
    along = 2.5 * c - 0.75 - 0.75 * dr.square(c)
    return ((direction - n * c) * across + n * along) / c
