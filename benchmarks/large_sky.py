"""Time and memory of whole commands on a large sky.

`python benchmarks/large_sky.py [--rows N] [--repeat N]`. A lat-long sky of 2N×N pixels (N = 8192 by default), clouds,
leaves and a sun of 80,000, is written as .hdr into a temporary folder. Each command runs as a process of its own, as a
user starts it; of each the least seconds of all repeats, the peak of its resident memory in MB, that over the arrays
of its input and output in float32, and the seconds until it first says anything on a terminal are printed as JSON.
"""

import argparse
import json
import os
import pty
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from reflet.files.pictures.hdr import write_hdr

LARGEST = 8192
_COMMAND = "from reflet.cli.start import main; main()"


def sky(rows: int) -> np.ndarray:
    """Radiance of (rows, 2·rows, 3), float32."""
    random = np.random.default_rng(0)
    height = np.cos(np.pi * (np.arange(rows, dtype=np.float32) + 0.5) / rows)[:, None, None]
    out = np.exp(-4.0 * np.abs(height)) * np.array([0.6, 0.8, 1.0], np.float32)
    out = np.broadcast_to(out, (rows, 2 * rows, 3)).copy()
    for block in np.array_split(out, 64):
        block *= 0.5 + random.random(block.shape, np.float32)
    middle = rows // 4
    out[middle : middle + max(rows // 512, 2), rows : rows + max(rows // 512, 2)] = 8e4
    return out


def measured(*arguments: object) -> tuple[float, float, int]:
    """Seconds in all and until the first word on its terminal, and peak memory in bytes, of `reflet ARGUMENTS`."""
    began, first, said = time.perf_counter(), 0.0, b""
    pid, terminal = pty.fork()
    if not pid:
        os.environ["TERM"] = "xterm-256color"
        os.execv(sys.executable, [sys.executable, "-c", _COMMAND, *map(str, arguments)])
    while True:
        try:
            said += os.read(terminal, 1 << 16)
        except OSError:  # it has ended
            break
        first = first or time.perf_counter() - began
    _, status, used = os.wait4(pid, 0)
    if status:
        raise SystemExit(f"reflet {' '.join(map(str, arguments))} failed: {said[-400:].decode(errors='replace')}")
    return time.perf_counter() - began, first, 1024 * used.ru_maxrss


def main() -> None:
    parser = argparse.ArgumentParser(description="Time and memory of whole commands on a large sky.")
    parser.add_argument("--rows", type=int, default=LARGEST)
    parser.add_argument("--repeat", type=int, default=1)
    options = parser.parse_args()
    rows = options.rows
    source, cube = 24 * rows**2, 24 * (rows // 2) ** 2 * 3  # bytes in float32; a cube of rows/2 has 1.5 rows² texels
    results = []
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "sky.hdr"
        write_hdr(path, sky(rows))
        commands = {
            "info": (("info", path), source),
            "hdr to exr": (("convert", path, Path(folder) / "a.exr"), source),
            "hdr to cube, ktx2": (
                ("convert", path, Path(folder) / "a.ktx2", "--to", "cube", "--size", rows // 4),
                source + cube // 4,
            ),
            "hdr to octahedral, exr": (
                ("convert", path, Path(folder) / "b.exr", "--to", "octahedral", "--size", rows),
                source + 12 * rows**2,
            ),
        }
        for name, (arguments, arrays) in commands.items():
            runs = [measured(*arguments) for _ in range(options.repeat)]
            seconds, first, peak = (min(run[k] for run in runs) for k in range(3))
            results.append(
                {
                    "command": name,
                    "seconds": round(seconds, 2),
                    "first word after": round(first, 2),
                    "peak MB": round(peak / 1e6),
                    "peak over arrays": round(peak / arrays, 2),
                }
            )
    print(json.dumps({"pixels": f"{2 * rows}×{rows}", "commands": results}, indent=1, ensure_ascii=False))


if __name__ == "__main__":
    main()
