"""A scene small enough to bake within a test."""

from pathlib import Path

import numpy as np
import pytest

from reflet.files.pictures.exr import write_exr


def write_torus(path: Path, rings: int = 24, sides: int = 12) -> None:
    """A ring that mirrors itself, as an OBJ without a material."""
    u, v = np.meshgrid(2 * np.pi * np.arange(rings) / rings, 2 * np.pi * np.arange(sides) / sides, indexing="ij")
    across = 0.5 + 0.2 * np.cos(v)
    points = np.stack([across * np.cos(u), 0.2 * np.sin(v) + 0.2, across * np.sin(u)], -1).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(rings), np.arange(sides), indexing="ij")

    def vertex(ring: np.ndarray, side: np.ndarray) -> np.ndarray:
        return (ring % rings * sides + side % sides + 1).ravel()

    quads = np.stack([vertex(i, j), vertex(i, j + 1), vertex(i + 1, j + 1), vertex(i + 1, j)], -1)
    lines = [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in points] + [f"f {a} {b} {c} {d}" for a, b, c, d in quads]
    path.write_text("o ring\n" + "\n".join(lines) + "\n")


@pytest.fixture(scope="session")
def scene_files(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """A ring, and a sky that is brighter on one side."""
    folder = tmp_path_factory.mktemp("scene")
    write_torus(folder / "ring.obj")
    y, x = np.mgrid[:16, :32]
    sky = np.stack([0.3 + 0.02 * x, np.full(x.shape, 0.4), 0.9 - 0.04 * y], -1).astype(np.float32)
    write_exr(folder / "sky.exr", sky)
    return folder / "ring.obj", folder / "sky.exr"
