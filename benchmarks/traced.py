"""Mirrors that trace their own mesh beside the paper's layers, on any model and on two that see themselves a lot.

    python benchmarks/traced.py chain|knot|MODEL FOLDER [--environment HDR] [--azimuth A] [--f0 0.9] [--roughness 0.3] …

Bakes the scene by default options into FOLDER (and goes on with a bake that is there) and prints the display PSNR of
what the bake plays, of static shells traced, and of the paper's layers inferred for the same viewpoints, at the
viewpoints, between, above and all around; and the seconds that the bake took and the bytes it wrote. ``chain`` is five
links, ``knot`` a trefoil, both smooth and under the environment.
"""

import argparse
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from reflet.files.atomic import atomic_write
from reflet.files.environment import read_environment
from reflet.pem.container import open_pem
from reflet.pipelines.bake import bake
from reflet.pipelines.compare import compare
from reflet.pipelines.load import load_scene
from reflet.report.comparison import METHODS, PLACES
from reflet.report.figure import comparison_figure
from reflet.scene.assemble import assemble
from reflet.scene.material import MIRROR, EnvironmentLight
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.meshes.primitives import torus_mesh
from reflet.scene.scene import Part, Scene
from reflet.scene.views.framing import frame_orbit
from reflet.scene.views.parameter_space import orbit_space


def chain(environment: EnvironmentLight) -> Scene:
    """Five links, each turned a quarter against its neighbours, in a bow that hangs between its ends."""
    link = torus_mesh(0.1, 0.028, around=96, sides=40)
    parts = []
    for number in range(5):
        quarter = np.radians(90.0 * (number % 2))
        turn = np.array([[1, 0, 0], [0, np.cos(quarter), -np.sin(quarter)], [0, np.sin(quarter), np.cos(quarter)]])
        along = (number - 2) * 0.135
        stretch = np.array([1.25, 1.0, 1.0])
        positions = (link.positions * stretch) @ turn.T + np.array([along, 0.35 * along**2, 0.0])
        normals = (link.normals / stretch) @ turn.T
        normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
        mesh = replace(link, positions=positions.astype(np.float32), normals=normals.astype(np.float32))
        parts.append(Part(f"link {number}", mesh, MIRROR))
    return assemble(parts, environment=environment)


def knot(environment: EnvironmentLight) -> Scene:
    """A trefoil: a tube along (sin t + 2 sin 2t, cos t − 2 cos 2t, −sin 3t), which passes itself three times."""
    around, sides, radius = 480, 48, 0.42
    tube = torus_mesh(1.0, radius, around=around, sides=sides)
    t = np.linspace(0.0, 2.0 * np.pi, around + 1)

    def derivative(order: int) -> np.ndarray:
        phase = order * np.pi / 2.0
        terms = (np.sin(t + phase) + 2.0**(1 + order) * np.sin(2.0 * t + phase),
                 np.cos(t + phase) - 2.0**(1 + order) * np.cos(2.0 * t + phase),
                 -(3.0**order) * np.sin(3.0 * t + phase))  # fmt: skip
        return np.stack(terms, -1)

    def unit(x: np.ndarray) -> np.ndarray:
        return x / np.linalg.norm(x, axis=-1, keepdims=True)

    along = unit(derivative(1))
    across = unit(np.cross(along, derivative(2)))
    angle = np.linspace(0.0, 2.0 * np.pi, sides + 1)[:, None, None]
    normals = np.cos(angle) * across + np.sin(angle) * np.cross(along, across)
    positions = derivative(0) + radius * normals
    scaled = 0.1 * positions.reshape(-1, 3)
    triangles = tube.triangles
    a, b, c = (scaled[triangles[0, corner]] for corner in range(3))
    if np.dot(np.cross(b - a, c - a), normals.reshape(-1, 3)[triangles[0, 0]]) < 0.0:
        triangles = triangles[:, ::-1]
    mesh = Mesh(scaled.astype(np.float32), normals.reshape(-1, 3).astype(np.float32), np.ascontiguousarray(triangles))
    return assemble([Part("knot", mesh, MIRROR)], environment=environment)


SCENES = {"chain": chain, "knot": knot}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene")
    parser.add_argument("folder", type=Path)
    parser.add_argument("--environment")
    parser.add_argument("--reflect", action="append", default=[])
    parser.add_argument("--azimuth", type=float)
    parser.add_argument("--f0", type=float)
    parser.add_argument("--roughness", type=float, help="of all that reflects")
    parser.add_argument("--image-size", type=int, default=512)
    parser.add_argument("--em-size", type=int, default=256)
    parser.add_argument("--samples", default="16")
    parser.add_argument("--spp", type=int, default=256)
    parser.add_argument("--no-rivals", action="store_true")
    asked = parser.parse_args()

    if asked.scene in SCENES:
        if asked.environment is None:
            parser.error(f"the {asked.scene} needs light: add --environment HDR")
        scene = SCENES[asked.scene](EnvironmentLight(read_environment(asked.environment)))
    else:
        scene = load_scene(asked.scene, environment=asked.environment, reflect=asked.reflect)
    if asked.f0 is not None:
        scene = _with(scene, base_color=(asked.f0,) * 3)
    if asked.roughness is not None:
        scene = _with(scene, perceptual_roughness=asked.roughness)
    orbit = replace(frame_orbit(scene, azimuth_deg=asked.azimuth), image_size=asked.image_size)
    begun = time.perf_counter()
    resume = asked.folder.exists()
    bake(scene, asked.folder, orbit_space(orbit, 0, 2.0), em_size=asked.em_size, resume=resume)
    size = sum(path.stat().st_size for path in asked.folder.rglob("*") if path.is_file())
    seconds = "" if resume else f"{time.perf_counter() - begun:.1f} s, "
    print(f"{scene.triangle_offsets[-1]} triangles, {seconds}{size / 1e6:.2f} MB")
    samples = int(asked.samples) if asked.samples.isdigit() else asked.samples
    pem = open_pem(asked.folder)
    comparison = compare(pem, samples=samples, reference_spp=asked.spp, rivals=not asked.no_rivals)
    atomic_write(asked.folder.with_suffix(".png"), comparison_figure(comparison))
    print(f"{'':28}" + "".join(f"{words:>17}" for words in PLACES.values()))
    for method in comparison.methods:
        if not method.startswith(("single", "distant")):
            values = (comparison.result(place, method).psnr_display for place in PLACES)
            print(f"{METHODS[method]:28}" + "".join(f"{value:17.2f}" for value in values), flush=True)


def _with(scene: Scene, **changes: Any) -> Scene:
    """All that reflects of a changed material."""
    parts = (replace(it, material=replace(it.material, **changes)) if it.reflective else it for it in scene.parts)
    return replace(scene, parts=tuple(parts))


if __name__ == "__main__":
    main()
