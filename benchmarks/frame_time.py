"""The frame of a layered, blended PEM beside frames with one cube lookup: same mesh, same samples a pixel.

    .venv/bin/python benchmarks/frame_time.py [PEM or MESH.glb]

Without an argument a torus of 40,000 triangles is drawn; of a mesh file, its metallic parts. 512² pixels, maps of
256² texels a face (a PEM has its own), two layers and two blended samples, on the fast and on the exact path, against
*plain*, the plainest shader there is: one map at infinity, interpolated normals, the LOD of the hardware; it draws
the same triangles in the same passes into the same textures. Frames alternate and medians count, so that a busy machine
changes the ratios little. Prints milliseconds a frame, by the clock and of processor time, and the ratios.
"""

import sys
import time
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from unittest.mock import patch

import numpy as np

from reflet.envmap.env_map import EnvMap
from reflet.envmap.geometry import Box, Ellipsoid, InfiniteSphere
from reflet.envmap.mip_chain import MipChain
from reflet.pem.container import open_pem
from reflet.pem.pem import Layer, ParameterizedEnvironmentMap
from reflet.render.playback.renderer import Renderer
from reflet.scene.bounds import object_positions
from reflet.scene.material import Material
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.meshes.primitives import torus_mesh
from reflet.scene.readers.gltf.read import read_gltf
from reflet.scene.scene import Part, ReflectiveObject, Scene
from reflet.scene.surfaces.hull import hull_triangles
from reflet.scene.surfaces.irradiance import IrradianceMap
from reflet.scene.views.parameter_space import Axis, Orbit, ParameterSpace
from reflet.shaders.link import link_text

ROUNDS = 9
PLAIN = Path(__file__).with_name("plain_lookup.wgsl")


def mirrors(meshes: Sequence[Mesh]) -> Scene:
    """One object of touching mirrors."""
    mirror = Material(base_color=(0.65,) * 3, metallic=1.0, perceptual_roughness=0.0)
    parts = tuple(Part(f"part-{i}", mesh, mirror, True) for i, mesh in enumerate(meshes))
    return Scene(parts, (ReflectiveObject("object", tuple(range(len(parts)))),))


def layered_pem(scene: Scene, size: int = 256) -> ParameterizedEnvironmentMap:
    """Two samples of random maps."""
    positions = object_positions(scene, 0)
    centre, half = (positions.max(0) + positions.min(0)) / 2, np.ptp(positions, axis=0) / 2
    box = Box(tuple(centre - 4 * half), tuple(centre + 4 * half), tuple(centre))
    ellipsoid = Ellipsoid(tuple(centre), tuple(np.sqrt(3) * half), tuple(centre))
    chain, random = MipChain(size), np.random.default_rng(0)

    def env_map(channels: int, geometry: Box | Ellipsoid) -> EnvMap:
        return EnvMap(chain, random.uniform(0, 1, (chain.texel_count, channels)).astype(np.float16), geometry)

    parts = scene.objects[0].parts
    none = np.zeros(scene.triangle_offsets[-1], np.uint32)
    distance = 2.9 * float(np.linalg.norm(half))  # the bench teapot, 0.43 m from its middle to a corner, at 1.25 m
    return ParameterizedEnvironmentMap(
        scene=scene,
        irradiance=IrradianceMap(none, none, np.zeros((1, 3), np.float32)),
        space=ParameterSpace((Axis("azimuth_deg", (60.0, 62.0)),), Orbit(tuple(centre), 60.0, 22.0, distance)),
        layers=(Layer("distant", "distant", parts, box, size), Layer("local", "local", parts, ellipsoid, size)),
        maps=[(env_map(3, box), env_map(4, ellipsoid)) for _ in range(2)],
        on_hull=hull_triangles(scene),
        lod_bias=-1.5,  # as baked
        sample_count=16,
    )


def pem_of(path: Path | None) -> ParameterizedEnvironmentMap:
    """What is drawn."""
    if path is None:
        return layered_pem(mirrors([torus_mesh(0.3, 0.12, around=200, sides=100)]))
    if path.is_dir():
        return open_pem(path)
    return layered_pem(mirrors([part.mesh for part in read_gltf(path) if part.material.metallic > 0.5]))


def plain_pem(pem: ParameterizedEnvironmentMap) -> ParameterizedEnvironmentMap:
    """The first distant map of each part at infinity, in one sample."""
    kept = [i for i, layer in enumerate(pem.layers) if layer.kind == "distant"]
    maps = tuple(replace(pem.maps[0][i], geometry=InfiniteSphere()) for i in kept)
    layers = tuple(replace(pem.layers[i], geometry=InfiniteSphere()) for i in kept)
    axes = tuple(Axis(axis.name, axis.values[:1]) for axis in pem.space.axes)
    return replace(pem, layers=layers, maps=[maps], space=ParameterSpace(axes, pem.space.orbit))


def main() -> None:
    pem = pem_of(Path(sys.argv[1]) if len(sys.argv) > 1 else None)
    between = {axis.name: float(np.mean(axis.values[:2])) for axis in pem.space.axes}
    camera = pem.space.orbit.camera(between)
    layered, plain = Renderer(pem), Renderer(plain_pem(pem))
    with patch("reflet.render.playback.passes.link", lambda program: link_text(PLAIN.read_text())):
        plain.frame(camera, samples=1)  # builds the pipeline from the plain program
    frames = (
        ("layered, fast", partial(layered.frame, camera, exact=False)),
        ("layered, exact", partial(layered.frame, camera)),
        ("plain", partial(plain.frame, camera)),
    )
    for samples in (16, 4):
        times = np.empty((ROUNDS + 1, len(frames), 2))
        for i in range(len(times)):
            for j, (_, draw) in enumerate(frames):
                start = time.perf_counter(), time.process_time()
                draw(samples=samples)
                times[i, j] = 1000 * (time.perf_counter() - start[0]), 1000 * (time.process_time() - start[1])
        medians = np.median(times[1:], 0)  # the first frames build pipelines
        print(f"{samples} samples a pixel")
        for (name, _), (wall, processor), ratio in zip(frames, medians, medians / medians[-1], strict=True):
            print(
                f"  {name:15s} {wall:6.0f} ms ({processor:6.0f} ms of processors), "
                f"{ratio[0]:.2f} ({ratio[1]:.2f}) times plain"
            )


if __name__ == "__main__":
    main()
