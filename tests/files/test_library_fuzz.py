"""Damaged files that libraries read for us: in a process of its own, which must neither crash nor hang nor swell."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import OpenEXR
import pytest
from PIL import Image
from test_color_profile import SWAPPED
from test_ktx2_container import uastc_file
from test_panorama import crop_xmp
from test_png import sixteen_bit_png

from reflet.files.pictures.exr import write_exr
from reflet.files.pictures.png import write_png

READER = """
import pickle, resource, sys
sys.path.insert(0, {folder!r})
from fuzz import damaged, with_binary_numbers
import numpy as np
from reflet.errors import RefletError
from reflet.files.{module} import {function} as read

def peak():
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024

def outcome(data):
    with open({path!r}, "wb") as file:
        file.write(data)
    try:
        read({path!r})
        return "read"
    except RefletError as error:
        assert str(error).endswith("."), error
        return "refused"

valid = open({path!r}, "rb").read()
assert outcome(valid) == "read"
outcome(valid[:100])
before = peak()
files = [*damaged(valid, {header}, np.random.default_rng(5), 25), *with_binary_numbers(valid, {header})][::{every}]
outcomes = [outcome(data) for data in files]
print(outcomes.count("read"), outcomes.count("refused"), peak() - before)
"""


def image(height=24, width=48):
    return np.random.default_rng(1).random((height, width, 3)).astype(np.float32)


def scanlines(path):
    write_exr(path, image())


def tiles(path):
    header = {"compression": OpenEXR.PIZ_COMPRESSION, "type": OpenEXR.tiledimage, "tiles": OpenEXR.TileDescription()}
    with OpenEXR.File(header, {"RGB": image(70, 90).astype(np.float16)}) as file:
        file.write(str(path))


def parts(path):
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    one = OpenEXR.Part(dict(header), {"Z": np.ascontiguousarray(image()[..., 0])}, "depth")
    with OpenEXR.File([one, OpenEXR.Part(dict(header), {"RGB": image()}, "beauty")]) as file:
        file.write(str(path))


def eight_bit(path):
    write_png(path, (255.0 * image()).astype(np.uint8))


def profiled(path):
    """A JPEG, whose bytes no checksum guards, with a colour profile."""
    Image.fromarray((255.0 * image()).astype(np.uint8)).save(path, "JPEG", icc_profile=SWAPPED)


def panorama(path):
    """A JPEG that says where it lies in a panorama."""
    xmp = crop_xmp((64, 32), (48, 24), 8, 4, PoseHeadingDegrees="12")
    Image.fromarray((255.0 * image()).astype(np.uint8)).save(path, "JPEG", xmp=xmp.encode())


def basis(path):
    pytest.importorskip("opengl_basisu")
    uastc_file(path, [(1, 2, 3)] * 6)


def sixteen_bit(path):
    path.write_bytes(sixteen_bit_png((65535.0 * image()).astype(np.uint16)))


@pytest.mark.parametrize(
    ("make", "module", "function", "header", "every"),
    # every so many of the damaged files: a few hundred of each
    [(scanlines, "pictures.exr", "read_exr", 320, 5), (tiles, "pictures.exr", "read_exr", 350, 5),
     (parts, "pictures.exr", "read_exr", 600, 9), (eight_bit, "pictures.png", "read_linear_picture", 40, 1),
     (profiled, "pictures.png", "read_linear_picture", 400, 18),
     (panorama, "env_image_file", "read_env_image", 700, 24),
     (sixteen_bit, "pictures.png", "read_linear_picture", 40, 1),
     (basis, "textures.ktx2_container", "read_texture", 148, 3)],
)  # fmt: skip
def test_damaged_files(tmp_path, make, module, function, header, every):
    path = tmp_path / f"a.{'exr' if module.endswith('exr') else 'ktx2' if make is basis else 'png'}"
    make(path)
    script = READER.format(
        folder=str(Path(__file__).parent), path=str(path), module=module, function=function, header=header, every=every
    )
    # a hang is what takes a hundred times as long as this does
    result = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=900, check=False)
    assert result.returncode == 0, f"{result.returncode}: {result.stderr[-2000:]}"
    read, refused, grown = map(int, result.stdout.split()[-3:])
    assert read > 2 and refused > 5 and read + refused > 100  # PNG has checksums of everything, JPEG of nothing
    # libraries allocate buffers before they know that there is not so much: a few scan lines, or a tile, of any length
    assert grown < 200e6
