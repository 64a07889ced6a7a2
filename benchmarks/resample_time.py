"""Seconds to resample env images, in one run with the same by scipy and with a memory copy of input plus output.

`python benchmarks/resample_time.py [--repeat N] [--small]`. The input is a lat-long map of 4096×2048 texels, float32,
of sky, noise and a sun of 80,000. Lat-long to cube 1024² is done three ways, turn by turn: by
`reflet.envmap.resampling.resample`; by `scipy.ndimage.map_coordinates` in plain NumPy, bilinear with a square grid of
sub-samples in each texel, as many as `resample` takes on the average or more; and as a copy of the same bytes. Other
pairs follow. The error is the RMS difference to the means over the texels' footprints (24 sub-samples per source texel
and axis), without the sun, over the standard deviation of those. Peak memory is that of a process of its own, input and
output included, over input plus output. Medians are printed as JSON.
"""

import argparse
import json
import multiprocessing
import re
import statistics
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numba
import numpy as np
import psutil
from scipy.ndimage import map_coordinates

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS, parameterization
from reflet.envmap.resampling.compiled_resample import footprint_means
from reflet.envmap.resampling.padding import padded
from reflet.envmap.resampling.resample import resample

SUN = 8e4
SUB_SAMPLES = 3  # of scipy's, per axis
PAIRS = (
    ("latlong", 2048, "octahedral", 2048),
    ("latlong", 2048, "dual_paraboloid", 1024),
    ("cube", 1024, "latlong", 2048),
    ("cube", 1024, "octahedral", 2048),
    ("latlong", 2048, "latlong", 512),
)


def sky(size: int) -> EnvImage:
    """A bright horizon, noise as of leaves, and a sun two texels wide."""
    latlong = parameterization("latlong")
    height = np.cos(np.pi * (np.arange(size) + 0.5) / size)[:, None, None]
    noise = np.random.default_rng(0).random((size, 2 * size, 3), np.float32)
    texels = (np.exp(-4.0 * np.abs(height)) * (0.5 + noise)).astype(np.float32)
    texels[size // 4 : size // 4 + 2, size : size + 2] = SUN
    return EnvImage(latlong, texels[None])


def by_scipy(image: EnvImage, size: int) -> np.ndarray:
    """Lat-long to cube, one face and sub-sample at a time."""
    cube = parameterization("cube")
    _, rows, columns, channels = image.texels.shape
    source = np.pad(image.texels[0], ((0, 0), (1, 1), (0, 0)), mode="wrap")
    out = np.zeros((*cube.shape(size), channels), np.float32)
    offset = (np.arange(SUB_SAMPLES) + 0.5) / SUB_SAMPLES
    for face in range(6):
        for down in offset:
            for right in offset:
                v, u = np.meshgrid((np.arange(size) + down) / size, (np.arange(size) + right) / size, indexing="ij")
                direction, _ = cube.direction_from_uv(np.full(u.shape, face), np.stack([u, v], -1))
                x, y, z = np.moveaxis(direction, -1, 0)
                at = np.stack(
                    [np.arccos(y) * (rows / np.pi) - 0.5, (np.arctan2(z, x) / (2 * np.pi) + 0.5) * columns + 0.5]
                )
                for channel in range(channels):
                    out[face, ..., channel] += map_coordinates(source[..., channel], at, order=1, mode="nearest")
    out /= SUB_SAMPLES**2
    return out


def without_sun(image: EnvImage) -> EnvImage:
    return EnvImage(image.parameterization, np.minimum(image.texels, 2.0))


def error(image: EnvImage, out: np.ndarray) -> float:
    """RMS difference to the exact footprint means on cube faces, over the standard deviation of those."""
    exact = np.empty_like(out)
    source = padded(image.parameterization, image.texels)
    footprint_means(source, image.parameterization.kind, PARAMETERIZATIONS["cube"].kind, np.eye(3), exact, 24.0)
    return float(np.sqrt(np.mean((out - exact) ** 2)) / exact.std())


def peak_memory(path: str, size: int) -> float:
    """Of the conversion of a saved lat-long map in this process, over the bytes of input and output."""
    cube = PARAMETERIZATIONS["cube"]
    resample(sky(64), cube, 32)  # compiles
    before = psutil.Process().memory_info().rss
    image = EnvImage(PARAMETERIZATIONS["latlong"], np.load(path))
    out = resample(image, cube, size)
    # Of this process's own memory: ru_maxrss begins with what the parent had.
    status = Path("/proc/self/status").read_text()
    peak = 1024 * int(re.search(r"VmHWM:\s+(\d+)", status)[1])  # type: ignore[index]
    return (peak - before) / (image.texels.nbytes + out.texels.nbytes)


def timed(call: Callable[[], object]) -> float:
    start = time.perf_counter()
    call()
    return time.perf_counter() - start


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--small", action="store_true", help="a quarter of the rows and columns")
    asked = parser.parse_args()
    shrink = 4 if asked.small else 1

    image, cube, size = sky(2048 // shrink), PARAMETERIZATIONS["cube"], 1024 // shrink
    resample(sky(64), cube, 32)  # compiles
    seconds: dict[str, list[float]] = {"reflet": [], "scipy": [], "copy": []}
    out = resample(image, cube, size)
    for _ in range(asked.repeat):
        seconds["reflet"].append(timed(lambda: resample(image, cube, size)))
        seconds["copy"].append(timed(lambda: (image.texels.copy(), out.texels.copy())))
        seconds["scipy"].append(timed(lambda: by_scipy(image, size)))
    medians = {name: statistics.median(runs) for name, runs in seconds.items()}
    calm = without_sun(image)
    with tempfile.NamedTemporaryFile(suffix=".npy") as file, multiprocessing.get_context("spawn").Pool(1) as pool:
        np.save(file.name, image.texels)
        memory = pool.apply(peak_memory, (file.name, size))
    report: dict[str, object] = {
        "threads": numba.get_num_threads(),
        "latlong_to_cube_s": {name: round(value, 3) for name, value in medians.items()},
        "times_faster_than_scipy": round(medians["scipy"] / medians["reflet"], 1),
        "times_a_copy": round(medians["reflet"] / medians["copy"], 1),
        "peak_memory_over_input_plus_output": round(memory, 2),
        "relative_error": {
            "reflet": round(error(calm, resample(calm, cube, size).texels), 4),
            "scipy": round(error(calm, by_scipy(calm, size)), 4),
        },
    }
    pairs = {}
    for name, rows, to_name, to_rows in PAIRS:
        source = resample(image, PARAMETERIZATIONS[name], rows // shrink)
        to = PARAMETERIZATIONS[to_name]
        made = resample(source, to, to_rows // shrink)
        pair, copies = [], []
        for _ in range(asked.repeat):
            pair.append(timed(lambda: resample(source, to, to_rows // shrink)))  # noqa: B023
            copies.append(timed(lambda: (source.texels.copy(), made.texels.copy())))  # noqa: B023
        pairs[f"{name} {source.size} to {to_name} {made.size}"] = {
            "s": round(statistics.median(pair), 3),
            "times_a_copy": round(statistics.median(pair) / statistics.median(copies), 1),
        }
    print(json.dumps({**report, "pairs": pairs}, indent=1))


if __name__ == "__main__":
    main()
