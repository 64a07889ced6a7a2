"""Seconds and memory to read large OBJ files, turn by turn with trimesh in one run.

`python benchmarks/obj_time.py [--triangles N] [--repeat N] [--no-peer]`. A sphere of two million triangles is written
three times: positions alone (normals come from creases), with texture coordinates and normals, and as quads. Each is
read in processes of their own. Memory is the peak over what the process held before, over that of the file plus three
times the arrays of the mesh: 1 is the bound we set ourselves. Medians are printed as JSON. The first run compiles.
"""

import argparse
import json
import multiprocessing
import statistics
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import psutil
import trimesh

from reflet.scene.readers.obj.read import read_obj

WARM_UP = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"


def write_spheres(folder: Path, triangles: int) -> dict[str, Path]:
    """The sphere in three spellings, of about as many triangles."""
    n = int(np.sqrt(triangles / 2))
    theta, phi = np.meshgrid(np.linspace(0.1, 3.0, n + 1), np.arange(n) * 2 * np.pi / n, indexing="ij")
    at = np.stack([np.sin(theta) * np.cos(phi), np.cos(theta), -np.sin(theta) * np.sin(phi)], -1).reshape(-1, 3)
    row, column = np.meshgrid(np.arange(n), np.arange(n), indexing="ij")
    a, b = (row * n + column).ravel() + 1, (row * n + (column + 1) % n).ravel() + 1
    quads = np.column_stack([a, a + n, b + n, b])
    cut = quads[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)
    paths = {name: folder / f"{name}.obj" for name in ("positions", "all", "quads")}
    for name, path in paths.items():
        with path.open("w") as file:
            np.savetxt(file, at, "v %.6f %.6f %.6f")
            if name == "all":
                np.savetxt(file, at[:, :2], "vt %.6f %.6f")
                np.savetxt(file, at, "vn %.6f %.6f %.6f")
                np.savetxt(file, np.repeat(cut, 3, axis=1), "f %d/%d/%d %d/%d/%d %d/%d/%d")
            else:
                np.savetxt(file, quads if name == "quads" else cut, "f" + " %d" * (4 if name == "quads" else 3))
    return paths


def ours(path: Path) -> int:
    (part,) = read_obj(path)
    mesh = part.mesh
    return sum(a.nbytes for a in (mesh.positions, mesh.normals, mesh.triangles, mesh.uv) if a is not None)


def peers(path: Path) -> int:
    return trimesh.load(path, process=False).vertices.nbytes


def measured(read: Callable[[Path], int], path: Path, warm_up: Path) -> tuple[float, float, int]:
    """Seconds, bytes at the peak over those before, and bytes of the arrays."""
    read(warm_up)
    before, start = psutil.Process().memory_info().rss, time.perf_counter()
    arrays = read(path)
    seconds = time.perf_counter() - start
    high = next(line for line in Path("/proc/self/status").read_text().splitlines() if line.startswith("VmHWM"))
    return seconds, int(high.split()[1]) * 1024 - before, arrays


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--triangles", type=int, default=2_000_000)
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--no-peer", action="store_true")
    arguments = parser.parse_args()
    report = {}
    with tempfile.TemporaryDirectory() as name:
        warm_up = Path(name) / "warm_up.obj"
        warm_up.write_text(WARM_UP)
        readers = {"reflet": ours} | ({} if arguments.no_peer else {"trimesh": peers})
        for spelling, path in write_spheres(Path(name), arguments.triangles).items():
            runs: dict[str, list[tuple[float, float, int]]] = {reader: [] for reader in readers}
            for _ in range(arguments.repeat):
                for reader, read in readers.items():
                    with multiprocessing.get_context("spawn").Pool(1) as pool:
                        runs[reader].append(pool.apply(measured, (read, path, warm_up)))
            bound = path.stat().st_size + 3 * runs["reflet"][0][2]
            report[spelling] = {"file_mb": round(path.stat().st_size / 1e6)} | {
                reader: {
                    "seconds": round(statistics.median(run[0] for run in of_reader), 2),
                    "peak_mb": round(statistics.median(run[1] for run in of_reader) / 1e6),
                    "peak_over_bound": round(statistics.median(run[1] for run in of_reader) / bound, 2),
                }
                for reader, of_reader in runs.items()
            }
    print(json.dumps(report, indent=2))


if __name__ == "__main__":
    main()
