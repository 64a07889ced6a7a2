"""The maps that are on the device: a bounded set of the parameter space's samples, the least recently used go first."""

from collections import OrderedDict
from collections.abc import Sequence

import wgpu

from reflet.envmap.env_map import EnvMap
from reflet.envmap.mip_chain import MipChain
from reflet.errors import RefletError
from reflet.pem.pem import Layer
from reflet.render.layouts import LARGEST_BLEND
from reflet.render.textures import create_cube_array, half_texels, write_cube

MOST_SLOTS = 42  # cubes in one cube array: WebGPU's default of 256 array layers


class ResidentMaps:
    """One cube array a layer; a resident sample has the same slot in all of them."""

    def __init__(
        self, device: wgpu.GPUDevice, layers: Sequence[Layer], maps: Sequence[tuple[EnvMap, ...]], memory: int
    ) -> None:
        """``memory`` bounds the cube arrays, in bytes; the samples of one blend always find room."""
        self._device, self._layers, self._maps = device, layers, maps
        bytes_per_slot = sum(8 * MipChain(layer.size).texel_count for layer in layers)
        slots = min(MOST_SLOTS, max(LARGEST_BLEND, memory // max(bytes_per_slot, 1)), len(maps))
        self.arrays = [create_cube_array(device, layer.size, slots) for layer in layers]
        self._free = list(range(slots))
        self._slot_of_sample: OrderedDict[int, int] = OrderedDict()

    def slots(self, samples: Sequence[int]) -> list[int]:
        """The slots of samples, which are uploaded where missing."""
        for sample in samples:
            if sample in self._slot_of_sample:
                self._slot_of_sample.move_to_end(sample)
        for sample in samples:
            if sample not in self._slot_of_sample:
                slot = self._free.pop() if self._free else self._slot_of_sample.popitem(last=False)[1]
                self._upload(sample, slot)
                self._slot_of_sample[sample] = slot
        return [self._slot_of_sample[sample] for sample in samples]

    def _upload(self, sample: int, slot: int) -> None:
        for layer, array, env_map in zip(self._layers, self.arrays, self._maps[sample], strict=True):
            if env_map.chain.size != layer.size:
                raise RefletError(
                    f"The map of layer {layer.name} at sample {sample} has {env_map.chain.size}² texels a face, not "
                    f"{layer.size}² as the layer says; bake the PEM again."
                )
            write_cube(self._device, array, slot, env_map.chain, half_texels(env_map.texels))
