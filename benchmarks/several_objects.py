"""What it would gain to look up the shells of the mirror that a ray leaves last, not of the one where it began.

    python benchmarks/several_objects.py FOLDER [--gap 0.6] [--radius 0.12] [--image-size 256] [--em-size 128]

Bakes the built-in room with a mirror ball and a ring beside the teapot, ``gap`` metres away, into FOLDER (or opens the
bake that is there): static shells. Prints display PSNR in dB against ray tracing at three azimuths each at the orbit's
elevation, 10° and 25° above, as played, and with each sub-sample taken from a picture in which all look up the shells
of the object that its ray leaves last; of all objects' pixels, and of the share of them where this makes a difference.
"""

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np

from reflet.pem.container import open_pem
from reflet.pem.pem import ParameterizedEnvironmentMap
from reflet.pipelines.bake import bake
from reflet.render.playback.renderer import Renderer
from reflet.report.measures import SquaredError, squared_error
from reflet.scene.assemble import assemble
from reflet.scene.builtin.teapot_room import teapot_room
from reflet.scene.material import MIRROR
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.meshes.primitives import sphere_mesh, torus_mesh
from reflet.scene.scene import Part, Scene
from reflet.scene.views.framing import frame_orbit
from reflet.scene.views.parameter_space import orbit_space
from reflet.trace.compose import object_radiance
from reflet.trace.tracer import Tracer

SIDE = 4  # sub-samples along a pixel's side: pictures of one a pixel, so many times as fine
SPP = 128


def scene_of(gap: float, radius: float) -> Scene:
    ring = moved(torus_mesh(0.09, 0.035, around=96, sides=48), (-0.6 * gap, 0.05, 0.8 * gap))
    ball = sphere_mesh(radius, (gap, radius, 0.1), 48)
    return assemble([*teapot_room().parts, Part("ball", ball, MIRROR), Part("ring", ring, MIRROR)])


def moved(mesh: Mesh, by: tuple[float, float, float]) -> Mesh:
    return replace(mesh, positions=mesh.positions + np.float32(by))


def with_shells_of(pem: ParameterizedEnvironmentMap, index: int) -> ParameterizedEnvironmentMap:
    """All objects look up the maps of one."""
    everything = tuple(sorted(part for item in pem.scene.objects for part in item.parts))
    kept = [k for k, layer in enumerate(pem.layers) if layer.parts == pem.scene.objects[index].parts]
    layers = tuple(replace(pem.layers[k], parts=everything) for k in kept)
    return replace(pem, layers=layers, base=tuple(pem.base[k] for k in kept))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    for name, default in (("gap", 0.6), ("radius", 0.12), ("image-size", 256), ("em-size", 128)):
        parser.add_argument(f"--{name}", type=type(default), default=default)
    asked = parser.parse_args()
    if not asked.folder.exists():
        scene = scene_of(asked.gap, asked.radius)
        space = orbit_space(replace(frame_orbit(scene), image_size=asked.image_size), views=0, spacing_deg=2.0)
        bake(scene, asked.folder, space, em_size=asked.em_size, static=True)
    pem = open_pem(asked.folder)
    owner = np.repeat(pem.scene.object_of_part, np.diff(pem.scene.triangle_offsets))
    played = Renderer(pem)
    of_each = [Renderer(with_shells_of(pem, index)) for index in range(len(pem.scene.objects))]
    tracer = Tracer(pem.scene, irradiance=pem.irradiance)
    orbit = pem.space.orbit
    for above in (0.0, 10.0, 25.0):
        errors = {name: SquaredError() for name in ("played", "its own", "played there", "its own there")}
        changed = pixels = 0
        for beside in (0.0, 120.0, 240.0):
            angles = {"azimuth_deg": orbit.azimuth_deg + beside, "elevation_deg": orbit.elevation_deg + above}
            camera = orbit.camera(angles)
            truth, coverage = object_radiance(tracer.view(camera, spp=SPP, sample_count=1).layers)
            fine = replace(camera, width=SIDE * camera.width, height=SIDE * camera.height)
            met = played.met_triangles(fine, 1, 0).reshape(-1, 4).astype(np.int64)
            rows, hits = np.arange(len(met)), (met > 0).sum(1)
            last = np.where(hits > 0, owner[met[rows, np.maximum(hits, 1) - 1] - 1], -1)
            now = played.frame(fine, samples=1, what="object").reshape(-1, 4)
            pictures = np.stack([each.frame(fine, samples=1, what="object").reshape(-1, 4) for each in of_each])
            own = np.where(last[:, None] >= 0, pictures[np.maximum(last, 0), rows], now)

            def by_pixel(values: np.ndarray, camera=camera) -> np.ndarray:  # type: ignore[no-untyped-def]
                return values.reshape(camera.height, SIDE, camera.width, SIDE, -1).mean((1, 3))

            mask = coverage > 0.0
            there = mask & (by_pixel((np.abs(own - now).max(1) > 1e-6).astype(float))[..., 0] > 0.0)
            for name, image in (("played", by_pixel(now)), ("its own", by_pixel(own))):
                shown = (image[..., :3] / np.maximum(image[..., 3:], np.float32(1e-6))).astype(np.float32)
                errors[name] += squared_error(truth, shown, mask)
                errors[f"{name} there"] += squared_error(truth, shown, there)
            changed, pixels = changed + int(there.sum()), pixels + int(mask.sum())
        told = ", ".join(f"{name} {error.psnr:.2f}" for name, error in errors.items())
        print(f"+{above:g}°: {told} dB; there: {changed / pixels:.1%} of the pixels", flush=True)


if __name__ == "__main__":
    main()
