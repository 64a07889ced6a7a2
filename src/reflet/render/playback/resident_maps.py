"""The maps that are on the device: a bounded set of the parameter space's samples, the least recently used go first."""

from collections import OrderedDict
from collections.abc import Sequence

import wgpu

from reflet.envmap.env_map import EnvMap
from reflet.errors import RefletError
from reflet.pem.pem import Layer
from reflet.render.device.textures import create_map_array, half_texels, write_map
from reflet.render.playback.layouts import LARGEST_BLEND

MOST_ARRAY_LAYERS = 256  # WebGPU's default: 42 cubes


class ResidentMaps:
    """One array a layer; a resident sample has the same slot in all of them."""

    def __init__(
        self, device: wgpu.GPUDevice, layers: Sequence[Layer], maps: Sequence[tuple[EnvMap, ...]], memory: int
    ) -> None:
        """``memory`` bounds the arrays, in bytes; the samples of one blend always find room."""
        self._device, self._layers, self._maps = device, layers, maps
        bytes_per_slot = sum(8 * layer.chain.texel_count for layer in layers)
        most = MOST_ARRAY_LAYERS // max((layer.parameterization.face_count for layer in layers), default=1)
        slots = min(most, max(LARGEST_BLEND, memory // max(bytes_per_slot, 1)), len(maps))
        self.arrays = [create_map_array(device, layer.chain, slots) for layer in layers]
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
            if env_map.chain != layer.chain:
                raise RefletError(
                    f"The map of layer {layer.name} at sample {sample} is a {env_map.chain.parameterization} of "
                    f"{env_map.chain.size} rows, not a {layer.parameterization} of {layer.size} as the layer says; "
                    "bake the PEM again."
                )
            write_map(self._device, array, slot, env_map.chain, half_texels(env_map.texels))
