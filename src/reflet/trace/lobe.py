"""What a surface mirrors, on the device: a single direction, or GGX's lobe about it."""

import drjit as dr
import mitsuba as mi

LEAST_CLIMB = 1e-3  # of a mirrored ray above the geometric surface, see CONVENTIONS.md
LEAST_ALPHA = 1e-4  # below, GGX is a mirror to float32


def mirrored(towards, n, ng):  # type: ignore[no-untyped-def]
    """The viewer's direction mirrored at n, bent above the surface as CONVENTIONS.md says; and whether it was bent."""
    straight = 2.0 * dr.dot(towards, n) * n - towards
    climb = dr.dot(straight, ng)
    bends = climb < LEAST_CLIMB
    return dr.select(bends, dr.normalize(straight + (LEAST_CLIMB - climb) * ng), straight), bends


def schlick(f0, f90, cosine):  # type: ignore[no-untyped-def]
    """Schlick's Fresnel term for the cosine v·h [Schlick94]."""
    return f0 + (f90 - f0) * dr.power(1.0 - cosine, 5)


class GlossyLobe:
    """The lobe D·V·n·l of one microfacet surface [Walter07, Heitz14], seen along the unit vectors ``towards``.

    It is turned about the ``normal`` that mirrors the viewer to where the project's mirror does: the shading normal n,
    but for rays bent above the surface of geometric normal ng, whose lobe would lie below it or have n·v < 0. Where
    ``alpha``, perceptual_roughness², is below `LEAST_ALPHA` the lobe is ``smooth``: a mirror along ``mirrored``, of
    which `evaluate` knows nothing. All directions are in world space.
    """

    def __init__(self, towards, n, ng, perceptual_roughness) -> None:  # type: ignore[no-untyped-def]
        self.mirrored, bends = mirrored(towards, n, ng)
        self.normal = dr.select(bends, dr.normalize(towards + self.mirrored), n)
        self.smooth = dr.square(perceptual_roughness) < LEAST_ALPHA
        self.alpha = dr.clip(dr.square(perceptual_roughness), LEAST_ALPHA, 1.0)
        self._distribution = mi.MicrofacetDistribution(mi.MicrofacetType.GGX, self.alpha, True)
        self._frame = mi.Frame3f(self.normal)
        self._view = self._frame.to_local(towards)
        self.n_dot_v = dr.clip(self._view.z, 1e-5, 1.0)

    def sample(self, point):  # type: ignore[no-untyped-def]
        """The viewer's direction mirrored at a visible normal; for a smooth lobe along ``mirrored``."""
        h, _ = self._distribution.sample(self._view, point)
        drawn = self._frame.to_world(2.0 * dr.dot(self._view, h) * h - self._view)
        return dr.select(self.smooth, self.mirrored, drawn)

    def draw(self, point):  # type: ignore[no-untyped-def]
        """A `sample`, its density per steradian, its weight G2/G1, which is 0 where it leaves the lobe's hemisphere,
        and v·h. Not of smooth lobes."""
        direction = self.sample(point)
        shape, density, v_dot_h = self.evaluate(direction)
        return direction, density, dr.select(density > 0.0, shape / dr.maximum(density, 1e-20), 0.0), v_dot_h

    def evaluate(self, direction):  # type: ignore[no-untyped-def]
        """D·V·n·l, what `sample` draws there per steradian, and v·h.

        Samples fall below the lobe's horizon too, where the first is 0 but other lobes may not be.
        """
        light = self._frame.to_local(direction)
        h = dr.normalize(self._view + light)
        v_dot_h = dr.clip(dr.dot(self._view, h), 0.0, 1.0)
        square, n_dot_l = dr.square(self.alpha), dr.maximum(light.z, 0.0)
        masking = n_dot_l * dr.sqrt(square + (1.0 - square) * dr.square(self.n_dot_v))
        shadowing = self.n_dot_v * dr.sqrt(square + (1.0 - square) * dr.square(n_dot_l))
        shape = self._distribution.eval(h) * 0.5 / dr.maximum(masking + shadowing, 1e-12) * n_dot_l
        density = self._distribution.pdf(self._view, h) / dr.maximum(4.0 * v_dot_h, 1e-12)
        lit, drawn = ~self.smooth & (light.z > 0.0), ~self.smooth & (h.z > 0.0)
        return dr.select(lit, shape, 0.0), dr.select(drawn, density, 0.0), v_dot_h
