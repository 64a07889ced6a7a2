"""From a traced layer to its env map."""

from collections.abc import Collection, Sequence
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float

from reflet.envmap.geometry import Geometry
from reflet.envmap.mip_chain import MipChain
from reflet.infer.records import Rows, Solution
from reflet.infer.regularization import MipPenalty
from reflet.infer.rendering_matrix import rendering_matrix
from reflet.infer.solve import SolverSettings, solve
from reflet.scene.surfaces.gbuffer import GBuffer
from reflet.trace.layers import SegmentedLayers

_HIDDEN = 0.02  # weight of a distant row that its local layer, or a nearer shell, hides altogether

Kind = Literal["distant", "local", "combined"]

# Local maps are asked for several values by one texel: their fit is worth more than their smoothness.
_SETTINGS = {
    "distant": SolverSettings(regularization=0.02),
    "local": SolverSettings(regularization=0.005),
    "combined": SolverSettings(regularization=0.02),
}


def infer_layer(
    kind: Kind,
    gbuffer: GBuffer,
    layers: SegmentedLayers,
    parts: Sequence[int],
    geometry: Geometry,
    chain: MipChain,
    lod_bias: float,
    *,
    shell: int = 0,
    channels: Literal[3, 4] = 3,
    prior: Float[np.ndarray, "texels channels"] | None = None,
    on_hull: Bool[np.ndarray, "triangles"] | None = None,
    map_from_world: Float[np.ndarray, "3 3"] | None = None,
    settings: SolverSettings | None = None,
) -> Solution:
    """The env map of ``geometry`` that shows one traced layer of some parts best, at the layers' viewpoint.

    Implements [Hakura01, sec. 4, "EM Inference"]. Texels that no sample sees keep ``prior`` (zero if none is given),
    changed as their coarser neighbourhood was. All else is as of `layer_rows`.
    """
    rows = layer_rows(
        kind,
        gbuffer,
        layers,
        parts,
        geometry,
        chain,
        lod_bias,
        shell=shell,
        channels=channels,
        on_hull=on_hull,
        map_from_world=map_from_world,
    )
    if prior is None:
        prior = np.zeros((chain.texel_count, rows.target.shape[1]), np.float32)
    return infer_map([rows], prior, chain, settings or _SETTINGS[kind])


def infer_map(
    rows: Collection[Rows],
    prior: Float[np.ndarray, "texels channels"],
    chain: MipChain,
    settings: SolverSettings = _SETTINGS["distant"],
) -> Solution:
    """The env map that shows all blocks of rows best: those of one viewpoint, or of many."""
    brightest = max([float(block.target[:, :3].max(initial=0.0)) for block in rows] + [float(prior[:, :3].max())])
    upper = np.array([brightest] * 3 + [1.0] * (prior.shape[1] - 3))
    return solve(rows, prior, upper, MipPenalty(chain), settings)


def layer_rows(
    kind: Kind,
    gbuffer: GBuffer,
    layers: SegmentedLayers,
    parts: Sequence[int],
    geometry: Geometry,
    chain: MipChain,
    lod_bias: float,
    *,
    shell: int = 0,
    channels: Literal[3, 4] = 3,
    on_hull: Bool[np.ndarray, "triangles"] | None = None,
    map_from_world: Float[np.ndarray, "3 3"] | None = None,
) -> Rows:
    """What the pixels of one view ask of the map of one layer.

    ``distant`` and ``local`` are the two layers of a layered PEM, ``combined`` is all incident radiance, L + (1 -
    alpha)·D, for a PEM of one layer. Of the distant layer it is one ``shell``, of 3 ``channels`` if it is the last,
    else of 4: premultiplied radiance and alpha, as local maps have. Triangles of ``on_hull`` do not look the local map
    up. ``gbuffer`` and ``layers`` may come from different sub-samples: rows are matched by pixel and part.
    ``map_from_world`` gives the frame of a view-dependent map (`Layer.map_from_world`).
    """
    select = looking_up(gbuffer, parts, on_hull if kind == "local" else None)
    matrix = rendering_matrix(gbuffer, chain, geometry, lod_bias, select, map_from_world)
    wanted = _target(kind, layers, shell, channels)
    target = np.zeros((len(gbuffer.row_pixel), wanted.shape[1]), np.float32)
    weights = np.zeros(len(gbuffer.row_pixel), np.float32)
    rows, traced = common_rows(gbuffer, layers)
    target[rows] = wanted[traced]
    weights[rows] = _row_weights(kind, layers, shell)[traced]
    weights[np.diff(matrix.starts) == 0] = 0.0
    return Rows(matrix, target, weights)


def looking_up(
    gbuffer: GBuffer, parts: Sequence[int], on_hull: Bool[np.ndarray, "triangles"] | None = None
) -> Bool[np.ndarray, "samples"]:
    """The sub-samples that look up a layer of some parts: all that see them; for a local layer, whose ``on_hull`` is
    given, all but those on triangles that cannot reflect their own object [Hakura01, sec. 4]."""
    select = np.isin(gbuffer.row_part, parts)[gbuffer.row_of_sample]
    if on_hull is not None:
        select &= ~on_hull[gbuffer.triangle]
    return select


def common_rows(gbuffer: GBuffer, layers: SegmentedLayers) -> tuple[np.ndarray, np.ndarray]:
    """Indices of the rows (pixel and part) that both have, in the G-buffer and in the layers."""
    parts = 1 + max(gbuffer.row_part.max(initial=0), layers.part.max(initial=0))
    ours = gbuffer.row_pixel.astype(np.int64) * parts + gbuffer.row_part
    theirs = layers.pixel.astype(np.int64) * parts + layers.part
    _, rows, traced = np.intersect1d(ours, theirs, assume_unique=True, return_indices=True)
    return rows, traced


def _target(kind: Kind, layers: SegmentedLayers, shell: int, channels: int) -> Float[np.ndarray, "rows channels"]:
    match kind:
        case "distant":
            return layers.shells[:, shell, :channels]
        case "local":
            return np.concatenate([layers.local, layers.alpha[:, None]], 1)
        case "combined":
            return layers.local + (1.0 - layers.alpha[:, None]) * layers.distant


def _row_weights(kind: Kind, layers: SegmentedLayers, shell: int) -> Float[np.ndarray, "rows"]:
    """Coverage/(1 + b)² with b the brightest channel of all light that comes in: displays saturate, and lights ring
    otherwise.

    Errors of the distant layer count as much as they show through the local one, (1 - alpha)², and through nearer
    shells, but never nothing: from other viewpoints more of them may show.
    """
    shown = layers.distant if kind == "distant" else _target("combined", layers, 0, 3)
    weight = layers.coverage / (1.0 + shown.max(1, initial=0.0)) ** 2
    if kind == "distant":
        weight = weight * ((1.0 - layers.alpha) ** 2 + _HIDDEN)
        for nearer in range(shell):
            weight = weight * ((1.0 - layers.shells[:, nearer, 3]) ** 2 + _HIDDEN)
    return weight
