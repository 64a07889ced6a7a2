"""The browser decodes coded maps to the bits that Python does, and says in a sentence what it cannot decode."""

import json
import re

import numpy as np
import pytest
from browser import drive, need_built_viewer
from coded_light import light

from reflet.envmap.mip_chain import MipChain
from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS
from reflet.pem.coding.coded_map import (
    read_coded_environment,
    read_coded_map,
    write_coded_environment,
    write_coded_map,
)

# (file, parameterization, rows, channels, radiance of the sun): with a gain and without, all sizes of small levels.
MAPS = [
    *((f"{name}-{channels}", name, 16, channels, 4e4) for name in PARAMETERIZATIONS for channels in (3, 4)),
    *((f"cube of {size}", "cube", size, 4, 3.0) for size in (1, 2, 4, 64)),
]
ROWS, COLUMNS = 17, 30  # an environment may be of any size
BROKEN = {
    "half": lambda file: file[: len(file) // 2],
    "all but one": lambda file: file[:-1],
    "empty": lambda file: b"",
    "other": lambda file: b"\xabKTX 20\xbb\r\n\x1a\n" + bytes(80),
    "huge": lambda file: re.sub(rb"ispe.{12}", b"ispe" + b"\0\0\0\0" + 2 * b"\0\0\xff\xff", file, flags=re.S),
    "picture": lambda file: file[: file.index(b"mdat") + 30] + b"\xff" * 90 + file[file.index(b"mdat") + 120 :],
}


def dim(chain, channels):
    """Nothing brighter than 1: no gain."""
    return light(chain, channels) / np.float32(4e4)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    need_built_viewer()
    folder = tmp_path_factory.mktemp("coded")
    files = []
    for file, name, size, channels, sun in MAPS:
        chain = MipChain(size, PARAMETERIZATIONS[name])
        write_coded_map(folder / file, chain, light(chain, channels, sun))
        shape = {"parameterization": name, "size": size}
        files.append({"file": file, "map": {"shape": shape, "channels": channels}})
    chain = MipChain(32)
    shape = {"parameterization": "cube", "size": 32}
    write_coded_map(folder / "dim", chain, dim(chain, 4))
    files.append({"file": "dim", "map": {"shape": shape, "channels": 4}})
    for damage, broken in BROKEN.items():
        (folder / damage).write_bytes(broken((folder / "dim").read_bytes()))
        files.append({"file": damage, "map": {"shape": shape, "channels": 4}})
    (folder / "of another size").write_bytes((folder / "cube of 4").read_bytes())
    files.append({"file": "of another size", "map": {"shape": shape, "channels": 4}})
    sky = np.linspace(0.0, 30.0, 3 * ROWS * COLUMNS, dtype=np.float32).reshape(ROWS, COLUMNS, 3)
    write_coded_environment(folder / "sky", sky)
    files.append({"file": "sky", "picture": {"rows": ROWS, "columns": COLUMNS}})
    (folder / "files.json").write_text(json.dumps(files))
    drive("coded-maps.mjs", folder)
    return folder


def browsers(folder, file):
    """The browser's half floats, RGBA."""
    return np.fromfile(folder / f"{file}.u16", "<u2").reshape(-1, 4)


def pythons(texels):
    """Python's, likewise: alpha is 1 where there is none."""
    return np.pad(texels, ((0, 0), (0, 4 - texels.shape[1])), constant_values=1.0).astype("<f2").view("<u2")


@pytest.mark.parametrize(("file", "name", "size", "channels"), [each[:4] for each in MAPS] + [("dim", "cube", 32, 4)])
def test_maps_are_decoded_to_the_same_bits(folder, file, name, size, channels):
    chain = MipChain(size, PARAMETERIZATIONS[name])
    np.testing.assert_array_equal(browsers(folder, file), pythons(read_coded_map(folder / file, chain, channels)))


def test_environments_are_decoded_to_the_same_bits(folder):
    sky = read_coded_environment(folder / "sky", ROWS, COLUMNS).reshape(-1, 3)
    np.testing.assert_array_equal(browsers(folder, "sky"), pythons(sky))


@pytest.mark.parametrize("damage", [*BROKEN, "of another size"])
def test_what_cannot_be_decoded_is_one_sentence(folder, damage):
    said = json.loads((folder / "said.json").read_text())
    wanted = {
        "huge": "does not hold what scene.gltf says",
        "of another size": "does not hold what scene.gltf says",
        "picture": "is damaged, or this browser knows no AVIF",
    }
    assert said[damage].startswith(damage) and said[damage].endswith(".")
    assert wanted.get(damage, "is truncated") in said[damage]
