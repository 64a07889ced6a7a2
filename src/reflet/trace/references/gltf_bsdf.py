"""glTF's metallic-roughness material as a BSDF of Mitsuba's, for the path traced reference.

glTF 2.0, appendix B, with KHR_materials_ior, _specular and _clearcoat: with Schlick's F = f0 + (f90 - f0)·(1 - v·h)⁵,
both f's mixed by metallic from the dielectric's (((n - 1)/(n + 1))²·specular_color·specular, specular) to the metal's
(base colour, 1),

    f·n·l = F·D·V·n·l + (1 - metallic)·(1 - max F_dielectric)·base_color·n·l/π,

all of it times 1 - c under a clear coat that adds c·D·V·n·l of its own roughness, c = clearcoat·F(n·v) of index 1.5.

**Energy.** Appendix B counts light that meets one microfacet only: a white metal of roughness 1 reflects 31 % of white
light seen along the normal, 76 % at n·v = 0.1 (A + B of `reflet.reflectance.brdfs.dfg`). And its diffuse share depends
on v·h, so that a smooth white dielectric reflects more than it gets at grazing angles. Therefore the BSDF by default is
what our playback, `GlossyGgx`, draws: F·D·V gets the factor 1 + f0·(1/(A + B) - 1) [Turquin19], and diffuse is what the
dielectric's albedo at n·v leaves. White then stays white, but reciprocity is lost. ``single_scattering`` takes appendix
B to the letter. The coat has no such factor.

**Normals.** Normal maps and bent rays as in CONVENTIONS.md: see `GlossyLobe`. Diffuse light comes from above both the
shading and the geometric normal.
"""

from dataclasses import dataclass
from functools import cache
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from reflet.reflectance.brdfs.dfg import dfg
from reflet.scene.material import COAT_F0
from reflet.trace.lobe import GlossyLobe, schlick
from reflet.trace.references.sides import sides, turned

TABLE_SIZE, TABLE_SAMPLES = 48, 2048
LEAST_SHARE = 0.1  # of the samples, for each lobe that there is


@dataclass
class _Hit:
    """The material where rays meet it. ``shares`` of the samples: coat's, specular's, diffuse's."""

    ng: Any
    n: Any
    visible: Any
    specular: GlossyLobe
    coat: GlossyLobe | None
    f0: Any
    f90: Any
    gained: tuple[Any, Any]  # f0 and f90 times what bounces between microfacets
    diffuse: Any  # base_color·(1 - metallic), and what the dielectric's reflection leaves of it, but by v·h
    below: Any  # share of light that gets through the coat
    coat_fresnel: Any
    shares: tuple[Any, Any, Any]


@cache
def _register(variant: str) -> None:
    class Gltf(mi.BSDF):  # type: ignore[name-defined, misc]
        """See the module. Textures are ``base_color``, ``metallic``, ``perceptual_roughness`` and, at will,
        ``clearcoat`` with ``clearcoat_roughness``, and ``normal`` and ``clearcoat_normal`` (texels from 0 to 1), whose
        mesh has attributes ``vertex_tangent`` and ``face_handedness``."""

        def __init__(self, properties: "mi.Properties") -> None:
            super().__init__(properties)
            self.base_color, self.metallic = properties["base_color"], properties["metallic"]
            self.perceptual_roughness = properties["perceptual_roughness"]
            self.double_sided = properties.get("double_sided", False)
            self.normal = properties.get("normal", None)
            self.normal_scale = properties.get("normal_scale", 1.0)
            index = properties.get("ior", 1.5)
            self.specular = properties.get("specular", 1.0)
            tint = mi.ScalarColor3f(properties.get("specular_color", mi.ScalarColor3f(1.0)))
            self.dielectric_f0 = dr.minimum(((index - 1.0) / (index + 1.0)) ** 2 * tint, 1.0) * self.specular
            self.clearcoat = properties.get("clearcoat", None)
            self.clearcoat_roughness = properties.get("clearcoat_roughness", None)
            self.clearcoat_normal = properties.get("clearcoat_normal", None)
            self.clearcoat_normal_scale = properties.get("clearcoat_normal_scale", 1.0)
            if self.normal is not None or self.clearcoat_normal is not None:
                self.tangent = mi.load_dict({"type": "mesh_attribute", "name": "vertex_tangent"})
                self.handedness = mi.load_dict({"type": "mesh_attribute", "name": "face_handedness"})
            self.single_scattering = properties.get("single_scattering", False)
            self.table = mi.Texture2f(mi.TensorXf(_albedos()), wrap_mode=dr.WrapMode.Clamp)
            both = mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide
            kinds = (mi.BSDFFlags.DiffuseReflection, mi.BSDFFlags.GlossyReflection, mi.BSDFFlags.DeltaReflection)
            self.m_components = [kind | both for kind in kinds]
            self.m_flags = self.m_components[0] | self.m_components[1] | self.m_components[2]

        def sample(self, context, si, sample1, sample2, active=True):  # type: ignore[no-untyped-def]
            """Of one lobe, weighted by all that are no mirrors."""
            hit = self._hit(si, active)
            coat_share, specular_share, diffuse_share = hit.shares
            coats = sample1 < coat_share
            glossy = ~coats & (sample1 < coat_share + specular_share)
            direction = mi.Frame3f(hit.n).to_world(mi.warp.square_to_cosine_hemisphere(sample2))
            direction = dr.select(glossy, hit.specular.sample(sample2), direction)
            mirrors = glossy & hit.specular.smooth
            whole = hit.below * schlick(hit.f0, hit.f90, hit.specular.n_dot_v)
            if hit.coat is not None:
                direction = dr.select(coats, hit.coat.sample(sample2), direction)
                mirrors |= coats & hit.coat.smooth
                whole = dr.select(coats, hit.coat_fresnel, whole)
            share = dr.select(coats, coat_share, dr.select(glossy, specular_share, diffuse_share))
            value, density = self._of(hit, direction)

            drawn = dr.zeros(mi.BSDFSample3f, dr.width(si.p))
            drawn.wo = si.to_local(direction)
            drawn.pdf = dr.select(mirrors, share, density)
            drawn.eta = mi.Float(1.0)
            kind = dr.select(coats | glossy, mi.UInt32(1), mi.UInt32(0))
            drawn.sampled_component = dr.select(mirrors, mi.UInt32(2), kind)
            names = mi.BSDFFlags.GlossyReflection, mi.BSDFFlags.DiffuseReflection, mi.BSDFFlags.DeltaReflection
            glossy_name, diffuse_name, delta_name = (mi.UInt32(+name) for name in names)
            drawn.sampled_type = dr.select(mirrors, delta_name, dr.select(coats | glossy, glossy_name, diffuse_name))
            value = dr.select(mirrors, whole, value)
            found = hit.visible & (drawn.pdf > 0.0)
            return drawn, dr.select(found, value / dr.select(found, drawn.pdf, 1.0), 0.0)

        def eval(self, context, si, wo, active=True):  # type: ignore[no-untyped-def]
            """All but mirrors, times the cosine."""
            return self.eval_pdf(context, si, wo, active)[0]

        def pdf(self, context, si, wo, active=True):  # type: ignore[no-untyped-def]
            """Density of the samples, but of those that mirror."""
            return self.eval_pdf(context, si, wo, active)[1]

        def eval_pdf(self, context, si, wo, active=True):  # type: ignore[no-untyped-def]
            """Both at once."""
            return self._of(self._hit(si, active), si.to_world(wo))

        def _of(self, hit: _Hit, direction):  # type: ignore[no-untyped-def]
            coat_share, specular_share, diffuse_share = hit.shares
            shape, density, v_dot_h = hit.specular.evaluate(direction)
            cosine = dr.maximum(dr.dot(hit.n, direction), 0.0) * dr.inv_pi
            left = 1.0
            if self.single_scattering:
                left = 1.0 - schlick(float(dr.max(self.dielectric_f0)), self.specular, v_dot_h)
            value = schlick(*hit.gained, v_dot_h) * shape + hit.diffuse * left * cosine
            value, density = hit.below * value, specular_share * density + diffuse_share * cosine
            if hit.coat is not None:
                shape, own, _ = hit.coat.evaluate(direction)
                value, density = value + hit.coat_fresnel * shape, density + coat_share * own
            lit = hit.visible & (dr.dot(hit.ng, direction) > 0.0)
            return dr.select(lit, value, 0.0), dr.select(lit, density, 0.0)

        def _hit(self, si, active) -> _Hit:  # type: ignore[no-untyped-def]
            towards, ng, smooth_normal, visible = sides(si, self.double_sided, active)
            n = smooth_normal
            if self.normal is not None:
                n = turned(self._bumped(si, visible, ng, self.normal, self.normal_scale), ng)
            color, metallic = self.base_color.eval(si, visible), self.metallic.eval_1(si, visible)
            roughness = self.perceptual_roughness.eval_1(si, visible)
            lobe = GlossyLobe(towards, n, ng, roughness)
            f0 = dr.lerp(mi.Color3f(self.dielectric_f0), color, metallic)
            f90 = dr.lerp(mi.Float(self.specular), 1.0, metallic)
            diffuse = color * (1.0 - metallic)
            gained, albedo = (f0, f90), schlick(f0, f90, lobe.n_dot_v)
            if not self.single_scattering:
                grazing = dr.power(1.0 - lobe.n_dot_v, 5)
                inset = (TABLE_SIZE - 1.0) / TABLE_SIZE
                place = mi.Point2f(dr.sqrt(lobe.n_dot_v), roughness) * inset + 0.5 / TABLE_SIZE
                a, b = self.table.eval(place)
                a, b = dr.select(lobe.smooth, 1.0 - grazing, a), dr.select(lobe.smooth, grazing, b)
                lost = 1.0 / (a + b) - 1.0
                paint, metal = self.dielectric_f0, color
                paint_gain, metal_gain = 1.0 + paint * lost, 1.0 + metal * lost
                gained = (
                    dr.lerp(paint * paint_gain, metal * metal_gain, metallic),
                    dr.lerp(self.specular * paint_gain, metal_gain, metallic),
                )
                albedo = gained[0] * a + gained[1] * b
                diffuse *= 1.0 - (paint * a + self.specular * b) * paint_gain
            coat, fresnel = None, mi.Float(0.0)
            if self.clearcoat is not None:
                above = smooth_normal
                if self.clearcoat_normal is not None:
                    bumped = self._bumped(si, visible, ng, self.clearcoat_normal, self.clearcoat_normal_scale)
                    above = turned(bumped, ng)
                coat = GlossyLobe(towards, above, ng, self.clearcoat_roughness.eval_1(si, visible))
                fresnel = self.clearcoat.eval_1(si, visible) * schlick(mi.Float(COAT_F0), 1.0, coat.n_dot_v)
            shares = _shares(fresnel, (1.0 - fresnel) * dr.mean(albedo), (1.0 - fresnel) * dr.mean(diffuse))
            return _Hit(
                ng, n, visible, lobe, coat, f0, f90, gained, diffuse, 1.0 - fresnel, fresnel, shares
            )  # fmt: skip

        def _bumped(self, si, active, ng, normal, scale):  # type: ignore[no-untyped-def]
            """The shading normal of a normal map; of the mesh's own side."""
            n, tangent = si.sh_frame.n, self.tangent.eval_3(si, active)
            along = _unit(mi.Vector3f(tangent), mi.Vector3f(0.0))
            across = dr.cross(n, along) * self.handedness.eval_1(si, active)
            local = 2.0 * mi.Vector3f(normal.eval_3(si, active)) - 1.0
            return _unit(scale * (local.x * along + local.y * across) + local.z * n, ng)

    mi.register_bsdf("reflet_gltf", Gltf)


@cache
def _albedos() -> np.ndarray:
    """A and B of `dfg`, rows by perceptual_roughness and columns by √(n·v), from 0 to 1 at the outer texels' centres.

    Finer than playback's `dfg_table`.
    """
    place = np.linspace(0.0, 1.0, TABLE_SIZE)
    n_dot_v = np.maximum(place, 1e-3) ** 2
    return np.stack([dfg(n_dot_v, float(r**2), TABLE_SAMPLES) for r in place]).astype(np.float32)


def _unit(vector, otherwise):  # type: ignore[no-untyped-def]
    squared = dr.squared_norm(vector)
    return dr.select(squared > 1e-24, vector * dr.rsqrt(dr.maximum(squared, 1e-30)), otherwise)


def _shares(*lights):  # type: ignore[no-untyped-def]
    """Of the samples, about as of the light, but none too few of what there is."""
    total = dr.maximum(sum(lights), 1e-6)
    wanted = [dr.select(light > 0.0, dr.maximum(light / total, LEAST_SHARE), 0.0) for light in lights]
    total = sum(wanted)
    return tuple(dr.select(total > 0.0, share / dr.maximum(total, 1e-6), 0.0) for share in wanted)


def register_gltf() -> None:
    """Make the BSDF ``reflet_gltf`` known to the current variant."""
    _register(mi.variant())
