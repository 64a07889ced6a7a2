"""The frame of a layered, blended PEM beside frames with one cube lookup: same mesh, same samples a pixel.

    .venv/bin/python benchmarks/frame_time.py [PEM or MESH.glb]

Without an argument a torus of 40,000 triangles is drawn; of a mesh file, its metallic parts. 512² pixels, maps of
256² texels a face (a PEM has its own), two layers and two blended samples, on the fast and on the exact path, against
*plain*, the plainest shader there is: one map at infinity, interpolated normals, the LOD of the hardware; it draws
the same triangles in the same passes into the same textures.

Then the distant light alone, from one set of maps for all viewpoints: two shells with reliefs (of a PEM that has
shells, its own) and one relief against *one box*, by all three ways to draw.

Last, own meshes traced, with five hits and with two, over two shells, against *layered*: one sample a pixel.

Rough parts, of roughness 0.3, whose local light is on the surface where mirrors' is traced, and of 0.15, which are
traced, against the same as *mirrors*: layers blended, and two shells with five hits.

Last, samples where they count: 16 and 64 where those disagree, and 64 everywhere, against *16* everywhere; then 4 and
16 where those disagree, and 16 everywhere, against *4*; each with the share of the object's pixels that take more.

Frames alternate and medians count, so that a busy machine changes the ratios little. Prints milliseconds a frame, by
the clock and of processor time, and the ratios.
"""

import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from unittest.mock import patch

import numpy as np

from reflet.envmap.env_map import EnvMap
from reflet.envmap.geometry import Box, Ellipsoid, InfiniteSphere
from reflet.envmap.mip_chain import MipChain
from reflet.envmap.parameterizations.cube import texel_directions
from reflet.envmap.relief import Relief, inverse_chebyshev
from reflet.envmap.shapes import FAR_AWAY
from reflet.pem.container import open_pem
from reflet.pem.pem import Layer, ParameterizedEnvironmentMap
from reflet.render.playback.renderer import Renderer
from reflet.scene.bounds import object_positions
from reflet.scene.bvh.build import build_bvh
from reflet.scene.material import Material
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.meshes.primitives import torus_mesh
from reflet.scene.readers.gltf.read import read_gltf
from reflet.scene.roughness import TRACED_ROUGHNESS
from reflet.scene.scene import Part, ReflectiveObject, Scene
from reflet.scene.surfaces.hull import hull_triangles
from reflet.scene.surfaces.irradiance import IrradianceMap
from reflet.scene.surfaces.surface_layer import SIDES, SurfaceLayer
from reflet.scene.views.camera import Camera
from reflet.scene.views.parameter_space import Axis, Orbit, ParameterSpace
from reflet.scene.views.sample_pattern import AT_REST, IN_MOTION
from reflet.shaders.link import link_text

ROUNDS = 9
PLAIN = link_text(Path(__file__).with_name("plain_lookup.wgsl").read_text())


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
    """The last distant map of each part at infinity, in one sample."""
    layers = tuple(replace(pem.layers[i], geometry=InfiniteSphere(), begin=0.0) for i in last_shells(pem))
    maps = tuple(static_maps(pem)[i] for i in last_shells(pem))
    space = ParameterSpace((Axis("azimuth_deg", (60.0,)),), pem.space.orbit)
    return replace(pem, layers=layers, maps=[maps], space=space, base=())


def plain_frame(renderer: Renderer, camera: Camera, samples: int) -> np.ndarray:
    """Of a `plain_pem`, drawn by the plain program."""
    with patch("reflet.render.playback.passes.link", lambda program: PLAIN):
        return renderer.frame(camera, samples=samples)


def last_shells(pem: ParameterizedEnvironmentMap) -> list[int]:
    """Indices of the layers that hide all behind them."""
    return [i for i in pem.distant_layers if pem.layers[i].end == np.inf]


def static_maps(pem: ParameterizedEnvironmentMap) -> dict[int, EnvMap]:
    """Maps of the distant layers, for all viewpoints or for the first."""
    maps = pem.base or [pem.maps[0][i] for i in pem.distant_layers]
    return dict(zip(pem.distant_layers, maps, strict=True))


def static_pem(pem: ParameterizedEnvironmentMap, layers: dict[Layer, EnvMap]) -> ParameterizedEnvironmentMap:
    """The same scene with distant layers alone, whose maps serve all viewpoints."""
    space = ParameterSpace((Axis("azimuth_deg", ()),), pem.space.orbit)
    return replace(pem, layers=tuple(layers), maps=[], base=tuple(layers.values()), space=space)


def one_box(pem: ParameterizedEnvironmentMap) -> ParameterizedEnvironmentMap:
    """Of each object one distant layer, its geometry a box."""
    maps = static_maps(pem)
    return static_pem(
        pem, {replace(pem.layers[i], geometry=box_of(pem, i), begin=0.0): maps[i] for i in last_shells(pem)}
    )


def box_of(pem: ParameterizedEnvironmentMap, number: int) -> Box:
    """The box of a layer: its own, or that where its searches start."""
    geometry = pem.layers[number].geometry
    if isinstance(geometry, Box | Relief) and max(map(abs, (*geometry.lower, *geometry.upper))) < FAR_AWAY:
        return Box(geometry.lower, geometry.upper, geometry.origin)
    positions = np.concatenate([part.mesh.positions for part in pem.scene.parts])
    return Box(tuple(positions.min(0)), tuple(positions.max(0)), tuple(positions.mean(0)))


def reliefs_of(box: Box) -> tuple[Relief, Relief]:
    """The box with a table in it, and without."""
    direction = texel_directions(128)
    walls = np.linalg.norm(box.lookup_direction(np.broadcast_to(box.origin, direction.shape), direction), axis=-1)
    below = -direction[..., 1]
    table = np.where(below > 0.3, 0.2 / np.maximum(below, 0.3), walls)
    near, far = (inverse_chebyshev(distance).astype(np.float16) for distance in (np.minimum(table, walls), walls))
    return Relief(near, box.lower, box.upper, box.origin), Relief(far, box.lower, box.upper, box.origin)


def with_reliefs(pem: ParameterizedEnvironmentMap, count: int) -> ParameterizedEnvironmentMap:
    """Of each object so many shells, their geometries reliefs; a nearer one's map covers what lies below."""
    layers: dict[Layer, EnvMap] = {}
    for i in last_shells(pem):
        last, env_map = pem.layers[i], static_maps(pem)[i]
        near, far = reliefs_of(box_of(pem, i))
        if count == 2:
            shell = replace(last, geometry=near, begin=0.0, end=1.0)
            direction = [shell.parameterization.texel_directions(n)[0].reshape(-1, 3) for n in shell.chain.level_sizes]
            alpha = np.concatenate(direction)[:, 1:2] < -0.3
            texels = np.concatenate([env_map.texels * alpha, alpha], 1).astype(np.float16)
            layers[shell] = EnvMap(shell.chain, texels, near)
        layers[replace(last, geometry=far, begin=float(count - 1))] = env_map
    return static_pem(pem, layers)


def two_shells(pem: ParameterizedEnvironmentMap) -> ParameterizedEnvironmentMap:
    """The PEM's own shells, or two that are made up."""
    if len(last_shells(pem)) == len(pem.distant_layers):
        return with_reliefs(pem, 2)
    return static_pem(pem, {pem.layers[i]: env_map for i, env_map in static_maps(pem).items()})


def roughened(pem: ParameterizedEnvironmentMap, roughness: float) -> ParameterizedEnvironmentMap:
    """The PEM with all that reflects of this roughness, and local light for it where rays are not traced for it."""
    parts = (replace(part, material=replace(part.material, perceptual_roughness=roughness)) for part in pem.scene.parts)
    out = replace(pem, scene=replace(pem.scene, parts=tuple(parts)))
    return replace(out, surface=dark_surface(out.scene)) if pem.most_hits and roughness > TRACED_ROUGHNESS else out


def dark_surface(scene: Scene) -> SurfaceLayer:
    """Nothing to see, at a site for each vertex of what reflects."""
    counts = [len(part.mesh.triangles) for part in scene.parts]
    starts = np.cumsum([0] + [len(part.mesh.positions) for part in scene.parts])
    shines = np.repeat([part.reflective for part in scene.parts], counts)
    corners = np.concatenate([part.mesh.triangles + first for part, first in zip(scene.parts, starts, strict=False)])
    return SurfaceLayer(
        resolution=shines.astype(np.uint32),
        offset=(3 * np.arange(len(shines))).astype(np.uint32),
        site=corners.ravel().astype(np.uint32),
        light=np.zeros((starts[-1], SIDES[0] ** 2, 4), np.float16),
    )


def measure(title: str, frames: dict[str, Callable[[], object]]) -> None:
    """Prints the times of frames, the last of which the others are compared with."""
    times = np.empty((ROUNDS + 1, len(frames), 2))
    for i in range(len(times)):
        for j, draw in enumerate(frames.values()):
            start = time.perf_counter(), time.process_time()
            draw()
            times[i, j] = 1000 * (time.perf_counter() - start[0]), 1000 * (time.process_time() - start[1])
    medians = np.median(times[1:], 0)  # the first frames build pipelines
    *_, reference = frames
    print(title)
    for name, (wall, processor), ratio in zip(frames, medians, medians / medians[-1], strict=True):
        print(
            f"  {name:15s} {wall:6.0f} ms ({processor:6.0f} ms of processors), "
            f"{ratio[0]:.2f} ({ratio[1]:.2f}) times {reference}"
        )


def main() -> None:
    pem = pem_of(Path(sys.argv[1]) if len(sys.argv) > 1 else None)
    between = {axis.name: float(np.mean(axis.values[:2])) for axis in pem.space.axes if axis.values}
    camera = pem.space.orbit.camera(between)
    layered, plain = Renderer(pem), Renderer(plain_pem(pem))
    for samples in (16, 4):
        frames: dict[str, Callable[[], object]] = {
            "layered, fast": partial(layered.frame, camera, samples=samples, exact=False),
            "layered, exact": partial(layered.frame, camera, samples=samples),
            "plain": partial(plain_frame, plain, camera, samples),
        }
        measure(f"{samples} samples a pixel", frames)
    kinds = {"two shells": two_shells(pem), "one relief": with_reliefs(pem, 1), "one box": one_box(pem)}
    renderers = {name: Renderer(kind) for name, kind in kinds.items()}
    for title, way in (
        ("4 samples a pixel, exact", {"samples": 4}),
        ("4 samples a pixel, fast", {"samples": 4, "exact": False}),
        ("4 samples a pixel in one pass, fast", {"samples": 4, "exact": False, "multisampled": True}),
    ):
        measure(title, {name: partial(renderer.frame, camera, **way) for name, renderer in renderers.items()})
    tree = build_bvh(pem.scene, pem.on_hull)
    traced = {f"traced, {hits}": Renderer(replace(two_shells(pem), most_hits=hits, bvh=tree)) for hits in (5, 2)}
    for title, exact in (("1 sample a pixel, exact", True), ("1 sample a pixel, fast", False)):
        frames = {name: partial(it.frame, camera, samples=1, exact=exact) for name, it in traced.items()}
        measure(title, {**frames, "layered": partial(layered.frame, camera, samples=1, exact=exact)})
    for title, mirrored in (
        ("layered, 4 samples a pixel, fast", pem),
        ("traced, 4 samples a pixel, fast", replace(two_shells(pem), most_hits=5, bvh=tree)),
    ):
        kinds = {f"rough, {roughness}": roughened(mirrored, roughness) for roughness in (0.3, 0.15)}
        rough = {name: Renderer(kind) for name, kind in {**kinds, "mirrors": roughened(mirrored, 0.0)}.items()}
        measure(title, {name: partial(it.frame, camera, samples=4, exact=False) for name, it in rough.items()})
    for samples in (AT_REST, IN_MOTION):
        frames = {
            f"adaptive, {samples}": partial(layered.frame, camera, samples=samples),
            f"{samples.most}": partial(layered.frame, camera, samples=samples.most),
            f"{samples.first}": partial(layered.frame, camera, samples=samples.first),
        }
        covered = layered.frame(camera, samples=samples, what="object")[..., 3] > 0.5
        share = (layered.samples_taken()[covered] == samples.most).mean()
        measure(f"samples where they count: {100 * share:.1f} % of the object's pixels take {samples.most}", frames)


if __name__ == "__main__":
    main()
