"""Which parts are rough, and how rough."""

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from reflet.scene.material import COAT_F0
from reflet.scene.scene import Part, Scene
from reflet.scene.surface_mean import surface_area, surface_texels, texels_on

LEAST_ROUGHNESS = 0.03
"""Below this perceptual_roughness a lobe is taken for a mirror: half of what it shows lies within 2α = 1.8 mrad of the
mirrored direction, less than a texel of a cube of 512² (3.1 mrad) and a pixel of most pictures."""

TRACED_ROUGHNESS = 0.2
"""Up to this perceptual roughness playback traces rays along the peak of a surface's lobe through the object's own
mesh; twin: `TRACED_ROUGHNESS` of gloss.wgsl."""

_FEW = 0.01  # of the surface, that may be smoother than what counts as the least: texels by seams, dust


def is_rough(part: Part) -> bool:
    """Whether a part reflects by a lobe, be it here and there or in its coat; glass is clear."""
    lobes = part.reflective and part.material.refraction is None
    return lobes and (part.material.perceptual_roughness >= LEAST_ROUGHNESS or part.is_coated)


def least_roughness(parts: Collection[Part]) -> float:
    """The least perceptual_roughness on the surfaces of some reflective parts; 0 where one of them is a mirror."""
    return min((_least(part) if is_rough(part) else 0.0 for part in parts), default=0.0)


def _least(part: Part) -> float:
    least = float(np.quantile(_on_surface(part), _FEW))
    return min(least, float(np.quantile(_on_coat(part), _FEW))) if part.is_coated else least


def most_roughness(parts: Collection[Part]) -> float:
    """The largest perceptual_roughness on the surfaces of some parts, beneath their coats."""
    return max((float(np.quantile(_on_surface(part), 1.0 - _FEW)) for part in parts), default=0.0)


def share_smoother(parts: Collection[Part], roughness: float) -> float:
    """Of the light that some reflective parts mirror, in the mean over their surface and seen along its normal, the
    share of what is smoother than a perceptual roughness."""
    smooth, all_of_it = 0.0, 0.0
    for part in parts:
        texels, material = surface_texels(part), part.material
        metallic = material.metallic * (np.ones(1) if texels is None else texels[:, 2] / 255.0)
        metal, dielectric = (float(np.mean(color)) for color in (material.base_color, material.dielectric_f0))
        area = surface_area(part.mesh)
        mirrored = area * (dielectric + metallic * (metal - dielectric))
        smooth += float(np.mean(mirrored * (_on_surface(part) < roughness)))
        all_of_it += float(np.mean(mirrored))
        if part.is_coated:
            by_coat = area * COAT_F0 * material.clearcoat
            smooth += by_coat * float(np.mean(_on_coat(part) < roughness))
            all_of_it += by_coat
    return smooth / all_of_it if all_of_it > 0.0 else 0.0


def has_wide_lobes(part: Part) -> bool:
    """Whether a part reflects by lobes too wide to be traced by a ray, be it here and there."""
    return is_rough(part) and float(np.quantile(_on_surface(part), 1.0 - _FEW)) > TRACED_ROUGHNESS


def narrowest_wide_lobes(part: Part) -> float:
    """The perceptual_roughness of a part's narrowest lobes that are not traced, but for a tenth of them."""
    roughness = _on_surface(part)
    return float(np.quantile(roughness[roughness > TRACED_ROUGHNESS], 0.1))


def as_mirrors(scene: Scene) -> Scene:
    """The scene with all that reflects made perfectly smooth, without coats."""
    return replace(scene, parts=tuple(_smooth(part) if is_rough(part) else part for part in scene.parts))


def _on_surface(part: Part) -> np.ndarray:
    texels = surface_texels(part)
    return part.material.perceptual_roughness * (np.ones(1) if texels is None else texels[:, 1] / 255.0)


def _on_coat(part: Part) -> np.ndarray:
    texels = texels_on(part.mesh, part.material.clearcoat_roughness_texture)
    return part.material.clearcoat_roughness * (np.ones(1) if texels is None else texels[:, 1] / 255.0)


def _smooth(part: Part) -> Part:
    return replace(part, material=replace(part.material, perceptual_roughness=0.0, clearcoat=0.0))
