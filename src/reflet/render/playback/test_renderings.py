"""The rendering matrix, measured: what weight the graphics system gives each texel in each pixel.

Implements the idea of [Hakura01, sec. 4, "EM Inference"], test renderings of coloured texels, with some ten renderings
a sub-sample position instead of one a texel: texels that no lookup weighs together share a rendering, and the colour a
pixel shows says which of them it was (`coloring`).
"""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import product
from typing import Literal

import numpy as np
import scipy.sparse as sp
from jaxtyping import Float32, Int32

from reflet.errors import RefletError
from reflet.infer.records import RenderingMatrix
from reflet.render.device.textures import create_map_array, write_map
from reflet.render.playback.coloring import Coloring, coloring
from reflet.render.playback.renderer import Renderer
from reflet.scene.surfaces.visibility import Visibility

# Below this weight names cannot be told: see `Coloring`. Less than the least difference verification looks for.
SMALLEST_WEIGHT = 1e-6


@dataclass(frozen=True)
class _Lookups:
    """The sub-samples of one layer: where they are in the pictures, their matrix row and their share of it."""

    pixel: Int32[np.ndarray, "samples"]
    sub_sample: Int32[np.ndarray, "samples"]
    row: Int32[np.ndarray, "samples"]
    share: Float32[np.ndarray, "samples"]


def measured_rendering_matrices(
    renderer: Renderer,
    visibility: Visibility,
    kind: Literal["distant", "local"],
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> tuple[dict[int, RenderingMatrix], int]:
    """The rendering matrices of all layers of a kind, by layer index, and how many renderings they were read off.

    Shells are measured one by one, the others hidden: a matrix says what texels weigh before they are composited.
    Rows are those of the G-buffer of ``visibility``, whose sub-samples must be among those that the rasterizer sees;
    local lookups of triangles on the hull are left out. ``progress`` is told (done, total) renderings. Scratch memory:
    about 24 bytes a tap, 8 taps a lookup.

    Raises `RefletError` where the device cannot filter float maps.
    """
    device, pem = renderer.device, renderer.pem
    if "float32-filterable" not in device.features:
        raise RefletError(
            "Verifying needs a graphics adapter that filters float textures (float32-filterable), which this one does "
            "not; try a software adapter, such as Mesa's lavapipe."
        )
    chosen = {i: _lookups(renderer, visibility, i) for i, layer in enumerate(pem.layers) if layer.kind == kind}
    maps = {stack.chain: max(len(it.layers) for it in renderer.stacks if it.chain == stack.chain)
            for stack in renderer.stacks}  # fmt: skip
    arrays = {chain: create_map_array(device, chain, count, "rgba32float") for chain, count in maps.items()}
    groups = renderer.bind_maps([arrays[stack.chain] for stack in renderer.stacks])
    found: dict[int, list[tuple[np.ndarray, ...]]] = {i: [] for i in chosen}
    color_count = max(coloring(pem.layers[i].chain).color_count for i in chosen)
    shells = [stack.layers for stack in renderer.stacks if stack.kind == kind]
    steps = list(product(range(max(map(len, shells))), range(visibility.sample_count)))
    for color in range(color_count):
        for chain in {pem.layers[i].chain for i in chosen}:
            if color < coloring(chain).color_count:
                names = coloring(chain).names(color)
                for map_number in range(maps[chain]):
                    write_map(device, arrays[chain], map_number, chain, names)
        for step, (shell, k) in enumerate(steps):
            picture = renderer.raw_lookup(visibility.camera, kind, visibility.sample_count, k, groups, shell)
            for i in (layers[shell] for layers in shells if shell < len(layers)):
                known, lookups = coloring(pem.layers[i].chain), chosen[i]
                if color < known.color_count:
                    here = np.flatnonzero(lookups.sub_sample == k)
                    shown = picture.reshape(-1, 4)[lookups.pixel[here]]
                    lookup, texel, weight = _read_off(shown, known, color)
                    found[i].append((lookups.row[here][lookup], texel, weight * lookups.share[here][lookup]))
            progress(color * len(steps) + step + 1, color_count * len(steps))
    rows = len(np.unique(_row_keys(renderer, visibility)))
    matrices = {i: _matrix(entries, rows, pem.layers[i].chain.texel_count) for i, entries in found.items()}
    return matrices, color_count * len(steps)


def _row_keys(renderer: Renderer, visibility: Visibility) -> np.ndarray:
    """A number that orders sub-samples by pixel, then part."""
    scene = renderer.pem.scene
    part = np.searchsorted(scene.triangle_offsets, visibility.triangle, side="right") - 1
    return visibility.pixel.astype(np.int64) * len(scene.parts) + part


def _lookups(renderer: Renderer, visibility: Visibility, layer_index: int) -> _Lookups:
    layer, keys = renderer.pem.layers[layer_index], _row_keys(renderer, visibility)
    row, samples = np.unique(keys, return_inverse=True, return_counts=True)[1:]
    share = (1.0 / samples[row]).astype(np.float32)
    select = np.isin(keys % len(renderer.pem.scene.parts), layer.parts)
    if layer.kind == "local":
        select &= ~renderer.pem.on_hull[visibility.triangle]
    return _Lookups(
        visibility.pixel[select], visibility.sub_sample[select], row[select].astype(np.int32), share[select]
    )


def _read_off(
    shown: Float32[np.ndarray, "samples 4"], known: Coloring, color: int
) -> tuple[Int32[np.ndarray, "entries"], Int32[np.ndarray, "entries"], Float32[np.ndarray, "entries"]]:
    """Which samples show a texel of the present colour, which texel, and its weight."""
    sample = np.flatnonzero(shown[:, 0] > SMALLEST_WEIGHT)
    weight = shown[sample, 0]
    texel = known.texels_of(color, shown[sample, 1:] / weight[:, None])
    named = texel >= 0
    return sample[named].astype(np.int32), texel[named], weight[named]


def _matrix(entries: list[tuple[np.ndarray, ...]], rows: int, texel_count: int) -> RenderingMatrix:
    row, texel, weight = (np.concatenate(each) for each in zip(*entries, strict=True))
    merged = sp.csr_matrix((weight, (row, texel)), shape=(rows, texel_count), dtype=np.float32)
    merged.sort_indices()
    return RenderingMatrix(merged.indptr.astype(np.int32), merged.indices.astype(np.int32), merged.data, texel_count)
