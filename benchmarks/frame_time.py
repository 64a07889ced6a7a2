"""The frame of a layered, blended PEM beside frames with one cube lookup: same mesh, same samples a pixel.

    .venv/bin/python benchmarks/frame_time.py

512² pixels, 40,000 triangles, maps of 256² texels a face; two layers and two blended samples against one lookup. Of two
rivals *plain* is the plainest shader there is, with interpolated normals and the LOD of the hardware; *static* is one
map at infinity drawn by the same renderer, with the same exact path and LOD. Frames alternate and the fastest of each
counts, so that a busy machine changes the ratios little. Prints milliseconds a frame and both ratios.
"""

import time
from dataclasses import replace
from pathlib import Path
from unittest.mock import patch

import numpy as np

from reflet.envmap.env_map import EnvMap
from reflet.envmap.geometry import Box, Ellipsoid, InfiniteSphere
from reflet.envmap.mip_chain import CubeMipChain
from reflet.pem.pem import Layer, ParameterizedEnvironmentMap
from reflet.render.renderer import Renderer
from reflet.scene.irradiance import IrradianceMap
from reflet.scene.material import Material
from reflet.scene.mesh import Mesh
from reflet.scene.parameter_space import Axis, Orbit, ParameterSpace
from reflet.scene.scene import Part, ReflectiveObject, Scene
from reflet.shaders.link import link_text

ROUNDS = 7
PLAIN = Path(__file__).with_name("plain_lookup.wgsl")


def torus(rings: int = 200, sides: int = 100, major: float = 0.3, minor: float = 0.12) -> Mesh:
    """Around the y axis; 2·rings·sides triangles."""
    u, v = np.meshgrid(np.arange(rings) * 2 * np.pi / rings, np.arange(sides) * 2 * np.pi / sides, indexing="ij")
    normals = np.stack([np.cos(v) * np.cos(u), np.sin(v), np.cos(v) * np.sin(u)], -1)
    positions = minor * normals + major * np.stack([np.cos(u), np.zeros_like(u), np.sin(u)], -1)
    i, j = np.meshgrid(np.arange(rings), np.arange(sides), indexing="ij")
    a, b = i * sides + j, (i + 1) % rings * sides + j
    c, d = (i + 1) % rings * sides + (j + 1) % sides, i * sides + (j + 1) % sides
    triangles = np.stack([a, c, b, a, d, c], -1).reshape(-1, 3)
    as_float = positions.reshape(-1, 3).astype(np.float32), normals.reshape(-1, 3).astype(np.float32)
    return Mesh(*as_float, triangles.astype(np.uint32))


def layered_pem(size: int = 256) -> ParameterizedEnvironmentMap:
    """A mirror torus with two samples of random maps; its outer half is on the convex hull."""
    mesh = torus()
    box, ellipsoid = Box((-2,) * 3, (2,) * 3, (0, 0, 0)), Ellipsoid((0, 0, 0), (0.5, 0.2, 0.5), (0, 0, 0))
    chain, random = CubeMipChain(size), np.random.default_rng(0)

    def env_map(channels: int, geometry: Box | Ellipsoid) -> EnvMap:
        return EnvMap(chain, random.uniform(0, 1, (chain.texel_count, channels)).astype(np.float16), geometry)

    centre = mesh.positions[mesh.triangles].mean(1)
    count = len(mesh.triangles)
    none = np.zeros(count, np.uint32)
    mirror = Material(base_color=(0.65,) * 3, metallic=1.0, perceptual_roughness=0.0)
    return ParameterizedEnvironmentMap(
        scene=Scene((Part("torus", mesh, mirror, True),), (ReflectiveObject("torus", (0,)),)),
        irradiance=IrradianceMap(none, none, np.zeros((1, 3), np.float32)),
        space=ParameterSpace((Axis("azimuth_deg", (60.0, 62.0)),), Orbit((0, 0, 0), 60.0, 22.0, 1.25)),
        layers=(Layer("distant", "distant", (0,), box, size), Layer("local", "local", (0,), ellipsoid, size)),
        maps=[(env_map(3, box), env_map(4, ellipsoid)) for _ in range(2)],
        on_hull=np.hypot(centre[:, 0], centre[:, 2]) > 0.3,
        lod_bias=-1.5,  # as baked
        sample_count=16,
    )


def static_pem(pem: ParameterizedEnvironmentMap) -> ParameterizedEnvironmentMap:
    """One map at infinity, one sample."""
    env_map = replace(pem.maps[0][0], geometry=InfiniteSphere())
    layer = replace(pem.layers[0], geometry=InfiniteSphere())
    space = ParameterSpace((Axis("azimuth_deg", (60.0,)),), pem.space.orbit)
    return replace(pem, layers=(layer,), maps=[(env_map,)], space=space)


def main() -> None:
    pem = layered_pem()
    camera = pem.space.orbit.camera({"azimuth_deg": 61.0})
    layered, plain, static = Renderer(pem), Renderer(static_pem(pem)), Renderer(static_pem(pem))
    with patch("reflet.render.passes.link", lambda program: link_text(PLAIN.read_text())):
        plain.frame(camera, samples=1)  # builds the pipeline from the plain program
    for samples in (16, 4):
        times = np.empty((ROUNDS, 3))
        for i in range(ROUNDS):
            for j, renderer in enumerate((layered, plain, static)):
                start = time.perf_counter()
                renderer.frame(camera, samples=samples)
                times[i, j] = 1000 * (time.perf_counter() - start)
        a, b, c = times.min(0)
        print(
            f"{samples:2d} samples a pixel: layered {a:.0f} ms, plain {b:.0f} ms, static {c:.0f} ms; "
            f"layered/plain {a / b:.2f}, layered/static {a / c:.2f}"
        )


if __name__ == "__main__":
    main()
