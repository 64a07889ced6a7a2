"""The rendering matrix, measured: what weight the graphics system gives each texel in each pixel.

Implements the idea of [Hakura01, sec. 4, "EM Inference"], test renderings of coloured texels, with twelve renderings a
sub-sample position instead of one a texel: texels that no lookup weighs together share a rendering, and the colour a
pixel shows says which of them it was (`coloring`).
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
import scipy.sparse as sp
import wgpu
from jaxtyping import Float32, Int32

from reflet.envmap.mip_chain import MipChain
from reflet.errors import RefletError
from reflet.infer.records import RenderingMatrix
from reflet.render.coloring import COLOR_COUNT, texel_colors, texel_names, texels_from_names
from reflet.render.renderer import Renderer
from reflet.render.textures import create_cube_array, write_cube
from reflet.scene.visibility import Visibility

# Below this weight names cannot be told: see `texel_names`. Less than the least difference verification looks for.
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
) -> dict[int, RenderingMatrix]:
    """The rendering matrices of all layers of a kind, by layer index, read off 12 renderings a sub-sample position.

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
    chains = {size: MipChain(size) for size in {layer.size for layer in pem.layers}}
    arrays = {size: create_cube_array(device, size, 1, "rgba32float") for size in chains}
    groups = renderer.bind_maps([arrays[layer.size] for layer in pem.layers])
    found: dict[int, list[sp.csr_matrix]] = {i: [] for i in chosen}
    total = COLOR_COUNT * visibility.sample_count
    for color in range(COLOR_COUNT):
        for size, chain in chains.items():
            _show_color(device, arrays[size], chain, color)
        for k in range(visibility.sample_count):
            picture = renderer.raw_lookup(visibility.camera, kind, visibility.sample_count, k, groups).reshape(-1, 4)
            for i, lookups in chosen.items():
                here = np.flatnonzero(lookups.sub_sample == k)
                chain = chains[pem.layers[i].size]
                lookup, texel, weight = _read_off(picture[lookups.pixel[here]], chain, color)
                found[i].append((lookups.row[here][lookup], texel, weight * lookups.share[here][lookup]))
            progress(color * visibility.sample_count + k + 1, total)
    rows = len(np.unique(_row_keys(renderer, visibility)))
    return {i: _matrix(entries, rows, chains[pem.layers[i].size].texel_count) for i, entries in found.items()}


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


def _show_color(device: wgpu.GPUDevice, array: wgpu.GPUTexture, chain: MipChain, color: int) -> None:
    """Fills slot 0 of a cube array with the names of one colour's texels, zero elsewhere."""
    names = texel_names(chain)
    names[texel_colors(chain) != color] = 0.0
    write_cube(device, array, 0, chain, names)


def _read_off(
    shown: Float32[np.ndarray, "samples 4"], chain: MipChain, color: int
) -> tuple[Int32[np.ndarray, "entries"], Int32[np.ndarray, "entries"], Float32[np.ndarray, "entries"]]:
    """Which samples show a texel of the present colour, which texel, and its weight."""
    sample = np.flatnonzero(shown[:, 0] > SMALLEST_WEIGHT)
    weight = shown[sample, 0]
    texel = texels_from_names(chain, color, shown[sample, 1:] / weight[:, None])
    known = texel >= 0
    return sample[known].astype(np.int32), texel[known], weight[known]


def _matrix(entries: list[tuple[np.ndarray, ...]], rows: int, texel_count: int) -> RenderingMatrix:
    row, texel, weight = (np.concatenate(each) for each in zip(*entries, strict=True))
    merged = sp.csr_matrix((weight, (row, texel)), shape=(rows, texel_count), dtype=np.float32)
    merged.sort_indices()
    return RenderingMatrix(merged.indptr.astype(np.int32), merged.indices.astype(np.int32), merged.data, texel_count)
