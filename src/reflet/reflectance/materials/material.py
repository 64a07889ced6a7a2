"""Environment-mapped materials: what a smooth or glossy surface makes of an environment at infinity.

Each is a sum of two lookups in prefiltered maps [Heidrich00, secs 3.1 to 3.2],

    radiance = specular(n·v)·L_r(r) + diffuse(n·v)·L_d(n),

with r the mirrored view ray, L_r the environment itself or filtered by the material's lobe (`material_maps`), and L_d
filtered diffusely. A material is its two weights; `shaders/material.wgsl` is the twin.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cache
from typing import ClassVar

import numpy as np
from jaxtyping import Float, Float32

from reflet.errors import RefletError
from reflet.reflectance.brdfs.dfg import dfg, energy_compensation
from reflet.reflectance.brdfs.fresnel import fresnel_conductor, fresnel_dielectric
from reflet.reflectance.brdfs.ggx_lobe import ggx_lobe

Rgb = tuple[float, float, float]
Cosine = Float[np.ndarray, "*batch"]
Weights = tuple[Float[np.ndarray, "*batch 3"], Float[np.ndarray, "*batch 3"]]

_DFG_ROWS, _DFG_COLUMNS, _DFG_SAMPLES = 32, 48, 2048
_LEAST_ROUGHNESS = 0.01  # alpha 1e-4: below, GGX is a mirror to float32
DIELECTRIC_F0 = 0.04

WHITE: Rgb = (1.0, 1.0, 1.0)
BLACK: Rgb = (0.0, 0.0, 0.0)


class SurfaceMaterial(ABC):
    """A material by its weights. ``kind`` is its number in shaders; ``diffuses`` whether it needs the diffuse map."""

    kind: ClassVar[int]
    diffuses: ClassVar[bool] = False

    @abstractmethod
    def weights(self, n_dot_v: Cosine) -> Weights:
        """(specular, diffuse) for cosines in [0, 1]."""


def _check_albedo(name: str, color: Rgb) -> None:
    if not all(0.0 <= channel <= 1.0 for channel in color):
        raise RefletError(f"A material's {name} is a share of light, three numbers from 0 to 1, not {color}.")


def _check_index(index: float) -> None:
    if not 0.0 < index < np.inf:
        raise RefletError(f"An index of refraction is a number greater than 0, not {index}; glass has 1.5.")


def _rgb(value: Float[np.ndarray, "*batch"], color: Rgb = WHITE) -> Float[np.ndarray, "*batch 3"]:
    return np.asarray(value)[..., None] * np.asarray(color)


@dataclass(frozen=True)
class Mirror(SurfaceMaterial):
    """Reflects the same share, ``reflectance``, at all angles."""

    kind = 0
    reflectance: Rgb = WHITE

    def __post_init__(self) -> None:
        _check_albedo("reflectance", self.reflectance)

    def weights(self, n_dot_v: Cosine) -> Weights:
        """See the class."""
        return _rgb(np.ones_like(n_dot_v), self.reflectance), _rgb(np.zeros_like(n_dot_v))


@dataclass(frozen=True)
class Dielectric(SurfaceMaterial):
    """F·Lm: glass or water of this index of refraction, and nothing below it. Implements [Heidrich00, eq. 13]."""

    kind = 1
    index: float

    def __post_init__(self) -> None:
        _check_index(self.index)

    def weights(self, n_dot_v: Cosine) -> Weights:
        """See the class."""
        return _rgb(fresnel_dielectric(n_dot_v, self.index)), _rgb(np.zeros_like(n_dot_v))


@dataclass(frozen=True)
class _OverDiffuse(SurfaceMaterial):
    """A dielectric of this index of refraction over a diffuse surface."""

    diffuses = True
    index: float
    albedo: Rgb = WHITE

    def __post_init__(self) -> None:
        _check_index(self.index)
        _check_albedo("albedo", self.albedo)


@dataclass(frozen=True)
class DielectricOverDiffuse(_OverDiffuse):
    """F·Lm + albedo·Ld [Heidrich00, sec. 3.1.1], simply added: may reflect more than came in."""

    kind = 2

    def weights(self, n_dot_v: Cosine) -> Weights:
        """See the class."""
        return _rgb(fresnel_dielectric(n_dot_v, self.index)), _rgb(np.ones_like(n_dot_v), self.albedo)


@dataclass(frozen=True)
class Coated(_OverDiffuse):
    """F·Lm + (1 - F)·albedo·Ld [Heidrich00, sec. 3.1.1]: a clear coat over diffuse paint; white paint stays white."""

    kind = 3

    def weights(self, n_dot_v: Cosine) -> Weights:
        """See the class."""
        fresnel = fresnel_dielectric(n_dot_v, self.index)
        return _rgb(fresnel), _rgb(1.0 - fresnel, self.albedo)


@dataclass(frozen=True)
class Conductor(SurfaceMaterial):
    """F·Lm for polished metal, of complex index n - ik for each channel (`spectral.index_rgb` finds it)."""

    kind = 4
    n: Rgb
    k: Rgb

    def __post_init__(self) -> None:
        if min(self.n) <= 0.0 or min(self.k) < 0.0 or not np.isfinite([*self.n, *self.k]).all():
            raise RefletError(f"A metal has n > 0 and k ≥ 0 in every channel, not n = {self.n} and k = {self.k}.")

    def weights(self, n_dot_v: Cosine) -> Weights:
        """See the class."""
        fresnel = fresnel_conductor(np.asarray(n_dot_v)[..., None], np.asarray(self.n), np.asarray(self.k))
        return fresnel, _rgb(np.zeros_like(n_dot_v))


@dataclass(frozen=True)
class GlossyPhong(SurfaceMaterial):
    """specular·Lp + diffuse·Ld, with Lp filtered by Phong's lobe. Implements [Heidrich00, eq. 17].

    ``phong_exponent`` > 0. As a lobe stands for its whole share of light, specular + diffuse ≤ 1 keeps energy.
    """

    kind = 5
    diffuses = True
    phong_exponent: float
    specular: Rgb = WHITE
    diffuse: Rgb = BLACK

    def __post_init__(self) -> None:
        if not 0.0 < self.phong_exponent < np.inf:
            raise RefletError(f"A Phong exponent is a number greater than 0, not {self.phong_exponent}.")
        _check_albedo("specular share", self.specular)
        _check_albedo("diffuse share", self.diffuse)

    def weights(self, n_dot_v: Cosine) -> Weights:
        """See the class."""
        ones = np.ones_like(n_dot_v)
        return _rgb(ones, self.specular), _rgb(ones, self.diffuse)


@dataclass(frozen=True)
class GlossyGgx(SurfaceMaterial):
    """glTF's metallic-roughness material, by the split sum [Karis13] with energy compensation [Turquin19].

    It is a mixture, by metallic, of a metal of f0 = base_color and a dielectric of f0 = 0.04 over base_color. Of both
    specular = (f0·A + B)·(1 + f0·(1/(A + B) - 1)), A and B from `dfg_table`; diffuse is what that leaves the
    dielectric, so that white keeps all light. All parameters lie in [0, 1].
    """

    kind = 6
    diffuses = True
    base_color: Rgb = WHITE
    metallic: float = 0.0
    perceptual_roughness: float = 0.5

    def __post_init__(self) -> None:
        _check_albedo("base colour", self.base_color)
        for name in ("metallic", "perceptual_roughness"):
            if not 0.0 <= getattr(self, name) <= 1.0:
                raise RefletError(f"A material's {name} lies between 0 and 1, not at {getattr(self, name)}.")

    @property
    def diffuse_color(self) -> Rgb:
        """base_color·(1 - metallic)."""
        r, g, b = (channel * (1.0 - self.metallic) for channel in self.base_color)
        return r, g, b

    def weights(self, n_dot_v: Cosine) -> Weights:
        """See the class."""
        table = dfg_lookup(n_dot_v, self.perceptual_roughness)
        dielectric = specular_albedo(np.full(3, DIELECTRIC_F0), table)
        metal = specular_albedo(np.asarray(self.base_color), table)
        specular = dielectric + self.metallic * (metal - dielectric)
        return specular, (1.0 - dielectric) * np.asarray(self.diffuse_color)

    def lobe(self, n_dot_v: Cosine) -> tuple[Float[np.ndarray, "*batch"], Float[np.ndarray, "*batch"]]:
        """(lean, perceptual_roughness) of the lookup, which is along normalize(mix(r, n, lean)); see `ggx_lobe`."""
        table = dfg_lookup(n_dot_v, self.perceptual_roughness)
        return table[..., 2], self.perceptual_roughness * table[..., 3]


def specular_albedo(
    f0: Float[np.ndarray, "*#batch 3"], table: Float[np.ndarray, "*#batch 4"]
) -> Float[np.ndarray, "*#batch 3"]:
    """Share of white light that GGX of this f0 reflects, with all that bounces between microfacets; of `dfg_lookup`."""
    a, b = table[..., :1], table[..., 1:2]
    return np.asarray((f0 * a + b) * energy_compensation(f0, a + b))


@cache
def dfg_table() -> Float32[np.ndarray, "rows columns 4"]:
    """A and B of the split sum, lean and widening of `ggx_lobe`, as half floats hold them.

    Rows by perceptual_roughness, columns by √(n·v): B bends most near the horizon. Both run from 0 in the middle of the
    first entry to 1 in the middle of the last; of (0, 0) A and B stand for a mirror and the horizon as nearly as `dfg`
    can. Linear in between, f0·A + B is good to 3e-3 of itself.
    """
    n_dot_v = np.maximum(np.linspace(0.0, 1.0, _DFG_COLUMNS), 0.01) ** 2
    leaning = np.minimum(n_dot_v, 0.99)  # along the normal nothing leans: 0/0
    rows = [
        np.hstack([dfg(n_dot_v, alpha, _DFG_SAMPLES), ggx_lobe(leaning, alpha)])
        for alpha in np.maximum(np.linspace(0.0, 1.0, _DFG_ROWS), _LEAST_ROUGHNESS) ** 2
    ]
    return np.stack(rows).astype(np.float16).astype(np.float32)


def dfg_lookup(n_dot_v: Cosine, perceptual_roughness: Cosine | float) -> Float[np.ndarray, "*batch 4"]:
    """`dfg_table`, bilinear, for both in [0, 1], one roughness for all or one each, as shaders do it
    (`ggx_table.wgsl`)."""
    table = dfg_table().astype(np.float64)
    row, below, down = _taps(np.ravel(perceptual_roughness), len(table))
    column, right, across = _taps(np.sqrt(np.ravel(n_dot_v)), table.shape[1])
    across, down = across[:, None], down[:, None]
    upper = table[row, column] * (1.0 - across) + table[row, right] * across
    lower = table[below, column] * (1.0 - across) + table[below, right] * across
    return np.asarray(upper * (1.0 - down) + lower * down).reshape(*np.shape(n_dot_v), 4)


def _taps(at: np.ndarray, size: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Two neighbouring entries around a coordinate in [0, 1], and the second one's share."""
    place = at * (size - 1)
    low = np.minimum(np.floor(place).astype(int), size - 2)
    return low, low + 1, place - low
