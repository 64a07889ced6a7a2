"""What large meshes cost: loading GLB and OBJ, and a whole bake of one small view, each in a process of its own.

    python benchmarks/large_meshes.py [--triangles N ...] [--metallic 0.7]

Prints JSON. The mesh is a torus with bumps, a mirror; with ``--metallic`` below 1 it shows diffuse light too, which is
traced first. Of a load: seconds, processor seconds, and the memory it took beyond what was imported, over that of the
scene's arrays. Of a bake: the same, seconds of each stage, and processor microseconds a triangle beyond the first
number of triangles: what grows with the mesh, whatever is done once a bake. Functions are compiled before any of it.
"""

import argparse
import json
import os
import resource
import struct
import subprocess
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

IMAGE_SIZE, EM_SIZE = 128, 64
WARM_UP = 2000  # triangles of a mesh that is taken first


def bumpy_torus(triangles: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Positions, normals (of the smooth torus) and triangles."""
    rows = int((triangles / 8) ** 0.5)
    columns = triangles // (2 * rows)
    v, u = np.meshgrid(np.arange(rows) / rows, np.arange(columns) / columns, indexing="ij")
    t, p = 2.0 * np.pi * v, -2.0 * np.pi * u
    outward = np.stack([np.cos(p), 0.0 * p, np.sin(p)], -1)
    normals = np.sin(t)[..., None] * outward + np.cos(t)[..., None] * np.array([0.0, 1.0, 0.0])
    radius = 0.3 + 0.01 * np.sin(23.0 * t) * np.sin(61.0 * p)
    i, j = np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij")
    down, right = (i + 1) % rows, (j + 1) % columns
    a, b, c, d = (row * columns + column for row, column in ((i, j), (i, right), (down, j), (down, right)))
    faces = np.stack([a, d, b, a, c, d], -1).reshape(-1, 3)
    positions = (0.7 * outward + radius[..., None] * normals).reshape(-1, 3)
    return positions.astype(np.float32), normals.reshape(-1, 3).astype(np.float32), faces.astype(np.uint32)


def write_glb(path: Path, positions: np.ndarray, normals: np.ndarray, triangles: np.ndarray, metallic: float) -> None:
    """One mesh, one material."""
    arrays, views, offset = (positions, normals, triangles.reshape(-1)), [], 0
    for array in arrays:
        views.append({"buffer": 0, "byteOffset": offset, "byteLength": array.nbytes})
        offset += array.nbytes
    bounds = {"min": positions.min(0).tolist(), "max": positions.max(0).tolist()}
    surface = {"baseColorFactor": [0.65, 0.65, 0.65, 1.0], "metallicFactor": metallic, "roughnessFactor": 0.0}
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "name": "torus"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1}, "indices": 2, "material": 0}]}],
        "materials": [{"pbrMetallicRoughness": surface}],
        "buffers": [{"byteLength": offset}],
        "bufferViews": views,
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": len(positions), "type": "VEC3", **bounds},
            {"bufferView": 1, "componentType": 5126, "count": len(normals), "type": "VEC3"},
            {"bufferView": 2, "componentType": 5125, "count": triangles.size, "type": "SCALAR"},
        ],
    }
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    with path.open("wb") as file:
        file.write(struct.pack("<4sII", b"glTF", 2, 12 + 8 + len(text) + 8 + offset))
        file.write(struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", offset, b"BIN\0"))
        for array in arrays:
            file.write(array.tobytes())


def write_obj(path: Path, positions: np.ndarray, normals: np.ndarray, triangles: np.ndarray) -> None:
    """Positions, normals and faces that name both."""
    with path.open("w") as file:
        np.savetxt(file, positions, "v %.6f %.6f %.6f")
        np.savetxt(file, normals, "vn %.6f %.6f %.6f")
        np.savetxt(file, np.repeat(triangles.astype(np.int64) + 1, 2, axis=1), "f %d//%d %d//%d %d//%d")


def peak_bytes() -> int:
    """Of this process so far."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


def measure(mesh: str, environment: str, out: str | None) -> dict:
    """In a process of its own: one load, and the bake into ``out`` where one is given."""
    import reflet
    import reflet.pipelines.bake  # what is imported is not the mesh's cost

    reflet.load_scene(Path(mesh).with_stem(str(WARM_UP)), environment=environment)
    before, wall, processor = peak_bytes(), time.perf_counter(), time.process_time()
    scene = reflet.load_scene(mesh, environment=environment)
    arrays = [a for part in scene.parts for a in vars(part.mesh).values() if a is not None]
    held = sum(a.nbytes for a in arrays)
    found = {
        "triangles": sum(len(part.mesh.triangles) for part in scene.parts),
        "load seconds": round(time.perf_counter() - wall, 2),
        "load processor seconds": round(time.process_time() - processor, 2),
        "load bytes over arrays": round((peak_bytes() - before) / held, 2),
    }
    if out is None:
        return found
    stages: dict[str, float] = {}
    began = wall = time.perf_counter()
    processor = time.process_time()
    running = "prepare"

    def progress(stage: str, done: int, total: int) -> None:
        nonlocal began, running
        now = time.perf_counter()
        stages[running] = stages.get(running, 0.0) + now - began
        began, running = now, stage

    orbit = reflet.scene.views.framing.frame_orbit(scene, image_size=IMAGE_SIZE)
    space = reflet.scene.views.parameter_space.orbit_space(orbit, 1, 2.0)
    reflet.bake(scene, out, space, em_size=EM_SIZE, progress=progress)
    progress("", 1, 1)
    return found | {
        "bake seconds": round(time.perf_counter() - wall, 2),
        "bake processor seconds": round(time.process_time() - processor, 2),
        "peak bytes a triangle": round((peak_bytes() - before) / found["triangles"]),
        "stages": {name: round(seconds, 2) for name, seconds in stages.items()},
    }


def in_a_process(*arguments: str) -> dict:
    """What `measure` says there."""
    command = [sys.executable, __file__, "--measure", *arguments]
    return json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE, env=os.environ).stdout)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--triangles", type=int, nargs="+", default=[20_000, 500_000, 2_000_000])
    parser.add_argument("--metallic", type=float, default=1.0)
    parser.add_argument("--no-obj", action="store_true", help="Leave the loads of OBJ files out.")
    parser.add_argument("--measure", nargs="+", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.measure:
        mesh, environment, *out = options.measure
        print(json.dumps(measure(mesh, environment, out[0] if out else None)))
        return
    results: list[dict] = []
    with TemporaryDirectory(prefix="large-meshes-") as folder:
        sky = Path(folder) / "sky.hdr"
        sky.write_bytes(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 8 +X 16\n" + bytes([128, 128, 128, 129]) * 128)
        for number, triangles in enumerate([WARM_UP, *options.triangles]):
            torus = bumpy_torus(triangles)
            mesh = Path(folder) / f"{triangles}.glb"
            write_glb(mesh, *torus, options.metallic)
            found = in_a_process(str(mesh), str(sky), str(Path(folder) / f"{number}.pem"))
            if not options.no_obj:
                write_obj(mesh.with_suffix(".obj"), *torus)
                loaded = in_a_process(str(mesh.with_suffix(".obj")), str(sky))
                found["obj"] = {name: value for name, value in loaded.items() if name.startswith("load")}
            if number == 0:
                continue  # functions are compiled now
            if results:
                more = found["bake processor seconds"] - results[0]["bake processor seconds"]
                beyond = found["triangles"] - results[0]["triangles"]
                found["bake processor microseconds a triangle"] = round(1e6 * more / beyond, 2)
            results.append(found)
            print(json.dumps(found, indent=1), flush=True)


if __name__ == "__main__":
    main()
