"""The maps that are on the device: a bounded set of the parameter space's samples, the least recently used go first."""

from collections import OrderedDict
from collections.abc import Sequence

import wgpu

from reflet.envmap.env_map import EnvMap
from reflet.errors import RefletError
from reflet.pem.pem import ParameterizedEnvironmentMap
from reflet.render.device.textures import create_map_array, half_texels, write_map
from reflet.render.playback.layouts import LARGEST_BLEND
from reflet.render.playback.stacks import Stack

MOST_ARRAY_LAYERS = 256  # WebGPU's default: 42 cubes


class ResidentMaps:
    """One array a stack of layers; a resident sample has the same slot in all of them.

    The maps that serve every viewpoint lie in ``base_slot``, behind the slots of all samples; only the arrays of
    distant layers have it.
    """

    def __init__(
        self, device: wgpu.GPUDevice, pem: ParameterizedEnvironmentMap, stacks: Sequence[Stack], memory: int
    ) -> None:
        """``memory`` bounds the arrays, in bytes; the samples of one blend always find room."""
        self._device, self._pem, self._stacks = device, pem, stacks
        base_bytes = sum(8 * env_map.chain.texel_count for env_map in pem.base)
        bytes_per_slot = sum(8 * layer.chain.texel_count for layer in pem.layers)
        with_base = [stack.kind == "distant" and bool(pem.base) for stack in stacks]
        most = min(
            (MOST_ARRAY_LAYERS // stack.array_layers - has for stack, has in zip(stacks, with_base, strict=True)),
            default=MOST_ARRAY_LAYERS,
        )
        affordable = (memory - base_bytes) // max(bytes_per_slot, 1)
        self.base_slot = min(most, max(LARGEST_BLEND, affordable), len(pem.maps))
        # an array may not be empty
        self.arrays = [
            create_map_array(device, stack.chain, max(self.base_slot + has, 1) * len(stack.layers))
            for stack, has in zip(stacks, with_base, strict=True)
        ]
        self._free = list(range(self.base_slot))
        self._slot_of_sample: OrderedDict[int, int] = OrderedDict()
        self._upload(dict(zip(pem.distant_layers, pem.base, strict=False)), self.base_slot, "of every viewpoint")

    def slots(self, samples: Sequence[int]) -> list[int]:
        """The slots of samples, which are uploaded where missing."""
        for sample in samples:
            if sample in self._slot_of_sample:
                self._slot_of_sample.move_to_end(sample)
        for sample in samples:
            if sample not in self._slot_of_sample:
                slot = self._free.pop() if self._free else self._slot_of_sample.popitem(last=False)[1]
                self._upload(dict(enumerate(self._pem.maps[sample])), slot, f"at sample {sample}")
                self._slot_of_sample[sample] = slot
        return [self._slot_of_sample[sample] for sample in samples]

    def _upload(self, maps: dict[int, EnvMap], slot: int, which: str) -> None:
        """Writes maps, by the number of their layer."""
        for stack, array in zip(self._stacks, self.arrays, strict=True):
            for shell, number in enumerate(stack.layers):
                if number in maps:
                    layer, env_map = self._pem.layers[number], maps[number]
                    if env_map.chain != layer.chain:
                        raise RefletError(
                            f"The map of layer {layer.name} {which} is a {env_map.chain.parameterization} of "
                            f"{env_map.chain.size} rows, not a {layer.parameterization} of {layer.size} as the layer "
                            "says; bake the PEM again."
                        )
                    at = slot * len(stack.layers) + shell
                    write_map(self._device, array, at, env_map.chain, half_texels(env_map.texels))
