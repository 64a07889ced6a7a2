"""Layers of colours in an OpenEXR file: which channels belong together, and which layer is meant."""

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from reflet.errors import RefletError

_ROLES = {"R": "R", "RED": "R", "G": "G", "GREEN": "G", "B": "B", "BLUE": "B", "A": "A", "ALPHA": "A"}
_ROLES |= {role: role for role in ("Y", "RY", "BY")}
_MOST_NAMES = 12  # in a sentence


@dataclass(frozen=True)
class ExrLayer:
    """Channels of one picture: ``channels`` are names in the file by R, G, B, A, Y, RY and BY, as far as there are.

    ``name`` is what stands before the channels' last dot (``ViewLayer.Combined`` of ``ViewLayer.Combined.R``), or the
    part's name where nothing does. ``is_plain`` tells the latter.
    """

    name: str
    part: int
    channels: Mapping[str, str]
    is_plain: bool


def color_layers(parts: Sequence[tuple[str, Sequence[str]]]) -> list[ExrLayer]:
    """The layers that hold R, G and B, or Y, of parts given as (name, channels); plain ones first in each part.

    X, Y and Z together are a vector, and no luminance.
    """
    layers = []
    for number, (part_name, channels) in enumerate(parts):
        grouped: dict[str, dict[str, str]] = {}
        vectors = {channel.rpartition(".")[0] for channel in channels if channel.rpartition(".")[2].upper() in "XZ"}
        for channel in channels:
            prefix, _, last = channel.rpartition(".")
            role = _ROLES.get(last.upper())
            if role and not (role == "Y" and prefix in vectors):
                grouped.setdefault(prefix, {}).setdefault(role, channel)
        layers += [
            ExrLayer(prefix or part_name, number, held, not prefix)
            for prefix, held in sorted(grouped.items())
            if {"R", "G", "B"} <= set(held) or "Y" in held
        ]
    return layers


def chosen_layer(
    path: str | os.PathLike[str], parts: Sequence[tuple[str, Sequence[str]]], name: str | None
) -> tuple[ExrLayer, tuple[str, ...]]:
    """The layer called ``name``, or the one that is meant where None is named; and doubts about that, as sentences.

    Meant is the first layer whose channels have plain names, or the only one there is. A name may have its part's
    before it (``part.layer``). Raises RefletError where there is no such layer, or where none is named and several
    are there.
    """
    layers = color_layers(parts)
    names = list(dict.fromkeys(layer.name for layer in layers))
    if not layers:
        held = ", ".join(channel for _, channels in parts for channel in sorted(channels))
        raise RefletError(
            f"{path} holds the channels {held[:200]}; expected R, G, B or Y, alone or behind a layer's name "
            "(ViewLayer.Combined.R)."
        )
    if name is not None:
        for layer in layers:
            if name in (layer.name, f"{parts[layer.part][0]}.{layer.name}"):
                return layer, ()
        if not any(names):
            raise RefletError(f"{path} has no layer {name}: its one picture has no name; leave the layer out.")
        raise RefletError(f"{path} has no layer {name} of colours; it has {_listed([n for n in names if n])}.")
    plain = [layer for layer in layers if layer.is_plain]
    if not plain and len(layers) > 1:
        raise RefletError(f"{path} holds the layers {_listed(names)}; write one out by reflet convert --layer NAME.")
    if len(plain) > 1:
        other = _listed([layer.name or "one without a name" for layer in plain[1:]])
        first = plain[0].name or "the first"
        said = (
            f"{path} holds several pictures; {first} is read, not {other}; reflet convert --layer NAME writes one out."
        )
        return plain[0], (said,)
    return (plain or layers)[0], ()


def _listed(names: Sequence[str]) -> str:
    more = f" and {len(names) - _MOST_NAMES} more" if len(names) > _MOST_NAMES else ""
    return ", ".join(names[:_MOST_NAMES]) + more
