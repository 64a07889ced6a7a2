"""The project's mirror as a BSDF of Mitsuba's, for the path traced reference."""

from functools import cache

import drjit as dr
import mitsuba as mi

from reflet.trace.lobe import mirrored
from reflet.trace.references.sides import sides


@cache
def _register(variant: str) -> None:
    class Mirror(mi.BSDF):  # type: ignore[name-defined, misc]
        """Schlick's mirror over a diffuse base, exactly as CONVENTIONS.md says; not energy conserving."""

        def __init__(self, properties: "mi.Properties") -> None:
            super().__init__(properties)
            self.base_color = properties["base_color"]
            self.metallic = properties["metallic"]
            self.double_sided = properties["double_sided"]
            self.f0, self.f90 = mi.ScalarColor3f(properties["f0"]), properties["f90"]
            self.diffuse = 0.0 if properties["unlit"] else 1.0
            sides = mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide
            self.m_components = [mi.BSDFFlags.DeltaReflection | sides, mi.BSDFFlags.DiffuseReflection | sides]
            self.m_flags = self.m_components[0] | self.m_components[1]

        def sample(self, context, si, sample1, sample2, active=True):  # type: ignore[no-untyped-def]
            """Metals always mirror; of other samples half mirror and half are diffuse."""
            towards, ng, n, visible = sides(si, self.double_sided, active)
            color, metallic = self.base_color.eval(si, visible), self.metallic.eval_1(si, visible)
            share = self._mirror_share(metallic)
            mirrors = visible & (sample1 < share)
            f0 = color * metallic + self.f0 * (1.0 - metallic)
            f90 = metallic + self.f90 * (1.0 - metallic)
            reflected, _ = mirrored(towards, n, ng)
            cosine = dr.minimum(0.5 * dr.norm(towards + reflected), 1.0)
            fresnel = f0 + (f90 - f0) * dr.power(1.0 - cosine, 5)
            scattered = mi.Frame3f(n).to_world(mi.warp.square_to_cosine_hemisphere(sample2))

            drawn = dr.zeros(mi.BSDFSample3f, dr.width(si.p))
            drawn.wo = si.to_local(dr.select(mirrors, reflected, scattered))
            drawn.pdf = dr.select(mirrors, share, (1.0 - share) * dr.dot(n, scattered) * dr.inv_pi)
            drawn.eta = mi.Float(1.0)
            drawn.sampled_type = dr.select(
                mirrors, mi.UInt32(+mi.BSDFFlags.DeltaReflection), mi.UInt32(+mi.BSDFFlags.DiffuseReflection)
            )
            drawn.sampled_component = dr.select(mirrors, mi.UInt32(0), mi.UInt32(1))
            above = dr.dot(ng, scattered) > 0.0
            diffuse = dr.select(above, self.diffuse * color * (1.0 - metallic), 0.0)
            weight = dr.select(mirrors, fresnel / share, diffuse / dr.maximum(1.0 - share, 0.5))
            return drawn, dr.select(visible, weight, 0.0)

        def eval(self, context, si, wo, active=True):  # type: ignore[no-untyped-def]
            """The diffuse base times the cosine."""
            _, ng, n, visible = sides(si, self.double_sided, active)
            outgoing = si.to_world(wo)
            cosine = dr.dot(n, outgoing)
            lit = visible & (cosine > 0.0) & (dr.dot(ng, outgoing) > 0.0)
            diffuse = self.diffuse * self.base_color.eval(si, lit) * (1.0 - self.metallic.eval_1(si, lit))
            return dr.select(lit, diffuse * cosine * dr.inv_pi, 0.0)

        def pdf(self, context, si, wo, active=True):  # type: ignore[no-untyped-def]
            """Density of the diffuse samples."""
            _, _, n, visible = sides(si, self.double_sided, active)
            share = self._mirror_share(self.metallic.eval_1(si, visible))
            return dr.select(visible, (1.0 - share) * dr.maximum(dr.dot(n, si.to_world(wo)), 0.0) * dr.inv_pi, 0.0)

        def eval_pdf(self, context, si, wo, active=True):  # type: ignore[no-untyped-def]
            """Both at once."""
            return self.eval(context, si, wo, active), self.pdf(context, si, wo, active)

        def _mirror_share(self, metallic):  # type: ignore[no-untyped-def]
            return dr.select(metallic >= 1.0, mi.Float(1.0), 0.5)

    mi.register_bsdf("reflet_mirror", Mirror)


def register_mirror() -> None:
    """Make the BSDF ``reflet_mirror`` known to the current variant; ``base_color`` and ``metallic`` are textures."""
    _register(mi.variant())
