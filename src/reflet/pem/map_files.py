"""The files of a PEM's maps, by codec: a map's file says by its suffix how it is to be read."""

from pathlib import Path

import numpy as np

from reflet.envmap.env_map import EnvMap
from reflet.envmap.mip_chain import MipChain
from reflet.errors import RefletError
from reflet.files.textures.ktx2 import read_ktx2, write_ktx2
from reflet.pem import layout
from reflet.pem.coding.coded_map import check_codable, read_coded_map, write_coded_map
from reflet.pem.layout import CODECS, SUFFIXES, Codec
from reflet.pem.pem import Layer


def codec_named(name: str) -> Codec:
    """The codec of that name. Raises RefletError where there is none."""
    for codec in CODECS:
        if codec == name:
            return codec
    raise RefletError(f"Maps are coded by av1, or not at all (none); there is no codec {name}.")


def check_chain(chain: MipChain, codec: Codec) -> None:
    """Raises RefletError where maps of this kind are too large for a codec."""
    if codec == "av1":
        check_codable(chain)


def write_map(path: Path, env_map: EnvMap) -> None:
    """Write a map as its file's suffix says. Raises RefletError as `write_ktx2` and `write_coded_map` do."""
    write = write_coded_map if path.suffix == SUFFIXES["av1"] else write_ktx2
    write(path, env_map.chain, env_map.texels)


def read_map(path: Path, layer: Layer) -> EnvMap:
    """Read a map of a layer. Raises RefletError where its file is missing, damaged, or of another kind of map."""
    if path.suffix == SUFFIXES["av1"]:
        return EnvMap(layer.chain, read_coded_map(path, layer.chain, layer.channels), layer.geometry)
    file = read_ktx2(path)
    if file.chain != layer.chain:
        raise RefletError(
            f"{path} is a {file.chain.parameterization.name} of {file.chain.size} rows, not the "
            f"{layer.parameterization.name} of {layer.size} that {layout.SCENE} says; copy the folder again."
        )
    return EnvMap(file.chain, file.texels()[:, : layer.channels].astype(np.float32), layer.geometry)
