"""Which maps share an array on the device: those of an object's shells, and those of each local layer."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import inf
from typing import Literal

from reflet.envmap.mip_chain import MipChain
from reflet.errors import RefletError
from reflet.pem.pem import MOST_SHELLS, Layer


@dataclass(frozen=True)
class Stack:
    """Layers whose maps lie one after the other in each slot of an array: an object's shells, nearest first, or one
    local layer. ``layers`` are indices into the PEM's."""

    kind: Literal["distant", "local"]
    layers: tuple[int, ...]
    parts: tuple[int, ...]
    chain: MipChain

    @property
    def array_layers(self) -> int:
        """How many layers of the array a slot takes."""
        return self.chain.parameterization.face_count * len(self.layers)


def stacks_of(layers: Sequence[Layer]) -> list[Stack]:
    """The stacks of a PEM's layers. Distant layers of the same parts are the shells of one object.

    Raises `RefletError` where they are none: see `Layer`.
    """
    shells: dict[tuple[int, ...], list[int]] = {}
    for i, layer in enumerate(layers):
        if layer.kind == "distant":
            shells.setdefault(layer.parts, []).append(i)
    of_objects = [_shells(layers, indices) for indices in shells.values()]
    parts = [part for stack in of_objects for part in stack.parts]
    if len(set(parts)) < len(parts):
        raise RefletError("A part has distant layers that it shares with different parts; bake the PEM again.")
    local = [Stack("local", (i,), it.parts, it.chain) for i, it in enumerate(layers) if it.kind == "local"]
    return of_objects + local


def _shells(layers: Sequence[Layer], indices: Sequence[int]) -> Stack:
    chosen = [layers[i] for i in indices]
    ends = [0.0, *(layer.end for layer in chosen)]
    if len(chosen) > MOST_SHELLS or any(b <= a for a, b in pairwise(ends)) or ends[-1] < inf:
        names = ", ".join(layer.name for layer in chosen)
        raise RefletError(
            f"The distant layers {names} are no shells: at most {MOST_SHELLS}, the nearest first and only the last "
            "without end; bake the PEM again."
        )
    if len({layer.chain for layer in chosen}) > 1:
        raise RefletError(
            f"The shells {', '.join(layer.name for layer in chosen)} differ in size or parameterization, which they "
            "have to share; bake the PEM again."
        )
    return Stack("distant", tuple(indices), chosen[0].parts, chosen[0].chain)
