"""What two greedy paths show of glass, beside path tracing.

    python benchmarks/glass.py FOLDER [--scene teapot|over_metal] [--image-size 256] [--em-size 256] [--spp 256] …

Bakes the built-in room with a teapot of clear glass, and with a glass ball and a ring of glass over a mirror that lies
on the table, into FOLDER (and goes on with bakes that are there). Prints display PSNR and FLIP of the objects' pixels,
at the orbit's own viewpoint and 20° above and beside it, against the ray tracer's picture, in which light is reflected
or refracted at random up to 64 times, and writes the pictures, path tracing on the left. Beside them, the ray tracer
against Mitsuba's path integrator, which has the same glass and finds diffuse light anew: what differs there is noise
and caustics.
"""

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np

from reflet.files.pictures.png import write_png
from reflet.pem.container import open_pem
from reflet.pipelines.bake import bake
from reflet.render.playback.renderer import Renderer
from reflet.report.measures import display_psnr, flip, picture_srgb
from reflet.scene.assemble import assemble
from reflet.scene.builtin.solids import box
from reflet.scene.builtin.teapot_room import teapot_room
from reflet.scene.material import MIRROR, Material, Refraction
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.meshes.primitives import sphere_mesh, torus_mesh
from reflet.scene.scene import Part, Scene
from reflet.scene.views.framing import frame_orbit
from reflet.scene.views.parameter_space import orbit_space
from reflet.trace.compose import compose, object_coverage
from reflet.trace.references.path_reference import path_traced
from reflet.trace.tracer import Tracer

CLEAR = Material("clear", (1.0, 1.0, 1.0), 0.0, 0.0, refraction=Refraction(1.5))
GREEN = replace(CLEAR, refraction=Refraction(1.5, attenuation_color=(0.5, 0.9, 0.7), attenuation_distance=0.15))
SPP_OF_MITSUBA = 4  # times as many: it looks nothing up
PLACES = {"the orbit": (0.0, 0.0), "+20° up": (0.0, 20.0), "20° beside": (20.0, 0.0)}


def teapot() -> Scene:
    """The built-in teapot of clear glass, solid, as its surface has no thickness; off the cloth, which it would else
    coincide with, so that rounding would say on which side rays come out. Its lid does not close it: there rays leave
    without meeting glass, and what they are attenuated by would go on to the next wall."""
    parts = teapot_room().parts
    glass = [replace(part, material=CLEAR, mesh=lifted(part.mesh, 0.004)) for part in parts if part.reflective]
    return assemble([*glass, *(part for part in parts if not part.reflective)])


def over_metal() -> Scene:
    """A ball and a ring of glass over a mirror."""
    solid = box((0.0, 0.02, 0.0), (0.6, 0.04, 0.6), 0)
    triangles = np.arange(len(solid.corners), dtype=np.uint32).reshape(-1, 3)
    plate = Mesh(np.asarray(solid.corners, np.float32), np.asarray(solid.normals, np.float32), triangles)
    parts = [
        Part("plate", plate, MIRROR),
        Part("ball", sphere_mesh(0.11, (0.0, 0.2, 0.0)), CLEAR),
        Part("ring", lifted(torus_mesh(0.2, 0.04, around=128, sides=48), 0.1), GREEN),
    ]
    return assemble([*parts, *(part for part in teapot_room().parts if not part.reflective)])


def lifted(mesh: Mesh, height: float) -> Mesh:
    return replace(mesh, positions=mesh.positions + np.float32([0.0, height, 0.0]))


SCENES = {"teapot": teapot, "over_metal": over_metal}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--scene", choices=SCENES, action="append")
    parser.add_argument("--image-size", type=int, default=256)
    parser.add_argument("--em-size", type=int, default=256)
    parser.add_argument("--spp", type=int, default=256)
    parser.add_argument("--hits", type=int, default=5)
    asked = parser.parse_args()
    print(f"{'':34}{'PSNR':>8}{'FLIP':>8}")
    for name in asked.scene or SCENES:
        scene = SCENES[name]()
        orbit = replace(frame_orbit(scene), image_size=asked.image_size)
        folder = asked.folder / name
        bake(scene, folder, orbit_space(orbit, 0, 2.0), em_size=asked.em_size, resume=folder.exists())
        pem = replace(open_pem(folder), most_hits=asked.hits)
        renderer, tracer = Renderer(pem), Tracer(scene, irradiance=pem.irradiance)
        for number, (place, (azimuth, elevation)) in enumerate(PLACES.items()):
            point = {"azimuth_deg": orbit.azimuth_deg + azimuth, "elevation_deg": orbit.elevation_deg + elevation}
            camera = orbit.camera(point)
            layers = tracer.view(camera, spp=asked.spp, surroundings=True).layers
            truth, inside = compose(layers), object_coverage(layers) == 1.0
            shown = renderer.frame(camera, samples="adaptive")[..., :3]
            pictures = [truth, shown]
            measured = {f"{name}, {place}": (truth, shown)}
            if not number:
                path = path_traced(scene, camera, spp=SPP_OF_MITSUBA * asked.spp, max_depth=66)
                pictures.insert(0, path)
                measured["  path integrator, ray tracer"] = path, truth
            for what, (reference, picture) in measured.items():
                psnr, error = display_psnr(reference, picture, inside), flip(reference, picture, inside)
                print(f"{what:34}{psnr:8.2f}{error:8.3f}", flush=True)
            write_png(asked.folder / f"{name}_{number}.png", picture_srgb(np.concatenate(pictures, 1)))


if __name__ == "__main__":
    main()
