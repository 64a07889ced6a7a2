"""Light and gloss that change in every frame: all prefiltered maps are made anew, on the device.

Run it with the folder to write to::

    python examples/live_materials.py out/live

Three lamps circle a teapot on a terrace at dusk. Each frame draws what surrounds the pot into a cube, filters that for
the material of the moment, and draws the pot with it; no texel leaves the device. ``live.webp`` plays four seconds:
on the left Phong's reflection over matte paint, its exponent running from 3 to 300 and back, on the right brushed gold
by GGX, as rough as it is. ``strip.png`` shows five moments of both; below them a measured paint, dusty satin from the
table of ``brdf_table.py``, and what is matte alone.

What correct looks like: each highlight moves with its lamp, opposite to it over the pot, in the lamp's colour; it
shrinks and brightens as the exponent grows, and at last shows the lamps' discs and the horizon. The satin's stays as
wide as it is and moves alike. Where the lamps shine, matte paint is tinted, smoothly, with nothing jumping from frame
to frame.
"""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
from brdf_table import measured
from PIL import Image

from reflet.envmap.parameterizations.latlong import LatLong
from reflet.files.atomic import atomic_path
from reflet.files.pictures.png import write_png
from reflet.pipelines.shade import frame_mesh, load_mesh
from reflet.reflectance.lobes.lobes import fit_lobes
from reflet.reflectance.materials.material import BLACK, GlossyGgx, GlossyPhong, SurfaceMaterial
from reflet.reflectance.materials.measured_material import Measured
from reflet.render.capture.capture import EnvironmentCapture
from reflet.render.device.device import shared_device
from reflet.render.filters.live_environment import LiveEnvironment
from reflet.render.materials.material_renderer import MaterialRenderer
from reflet.report.measures import picture_srgb
from reflet.report.plate import plate
from reflet.scene.builtin.solids import box
from reflet.scene.material import EnvironmentLight, Material, Texture
from reflet.scene.meshes.corners import weld
from reflet.scene.meshes.primitives import sphere_mesh
from reflet.scene.scene import Part, Scene
from reflet.scene.sky_light import SkyLight

SECONDS, RATE = 4, 20
LIGHT = SkyLight((0.10, 0.12, 0.22), (0.06, 0.05, 0.05), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0))
LAMPS = ((30.0, 7.0, 1.5), (1.5, 12.0, 30.0), (24.0, 2.5, 12.0))
EXPONENTS = 3.0, 300.0
PAINT, PLASTER = (0.16, 0.15, 0.14), (0.5, 0.5, 0.5)
GOLD = (1.0, 0.77, 0.34)


def dusk() -> EnvironmentLight:
    """A last glow in the west, deep blue above."""
    direction = LatLong().texel_directions(64)[0][0]
    height = direction[..., 1:2]
    glow = np.exp(-7.0 * np.abs(height)) * (0.5 + 0.5 * direction[..., :1])
    sky = np.array([0.05, 0.08, 0.20]) + glow * np.array([1.1, 0.45, 0.15])
    return EnvironmentLight(np.where(height > 0.0, sky, np.array([0.03, 0.03, 0.035])).astype(np.float32))


def surroundings(radius: float) -> Scene:
    """A chequered terrace, and the lamps about a thing of this size."""
    squares = np.indices((16, 16)).sum(0) % 2
    pixels = np.where(squares[..., None] == 1, [[[190, 180, 165, 255]]], [[[60, 70, 85, 255]]]).astype(np.uint8)
    board = box((0.0, -1.2 * radius, 0.0), (16.0 * radius, 0.1 * radius, 16.0 * radius), 0)
    terrace = Material(
        "terrace", metallic=0.0, base_color_texture_srgb=Texture(np.repeat(np.repeat(pixels, 16, 0), 16, 1))
    )
    parts = [Part("terrace", weld(board.corners, board.normals, board.uv), terrace)]
    for number, radiance in enumerate(LAMPS):
        lamp = Material(base_color=BLACK, metallic=0.0, emission=radiance)
        parts.append(Part(f"lamp {number}", sphere_mesh(0.4 * radius, around=48), lamp))
    return Scene(tuple(parts), (), dusk())


def places(centre: np.ndarray, radius: float, share: float) -> np.ndarray:
    """Rigid transforms of all parts: lamps circle once, at different heights and paces."""
    out = np.tile(np.eye(4), (1 + len(LAMPS), 1, 1))
    out[0, :3, 3] = centre
    for k in range(len(LAMPS)):
        angle = 2.0 * np.pi * ((1.0, -1.0, 2.0)[k] * share + k / len(LAMPS))
        height = (0.9, 1.7, 0.3)[k]
        out[1 + k, :3, 3] = centre + radius * np.array([2.8 * np.cos(angle), height, -2.8 * np.sin(angle)])
    return out


def exponent(share: float) -> float:
    """From the least to the largest and back, evenly in its logarithm."""
    low, high = np.log(EXPONENTS)
    return float(np.exp(low + (high - low) * (1.0 - abs(1.0 - 2.0 * share))))


def materials(share: float, satin: Measured) -> tuple[SurfaceMaterial, ...]:
    """Phong, GGX, measured, matte. GGX of alpha² = 2/(N + 2) has a highlight about as wide, from above [Walter07]."""
    phong_exponent = exponent(share)
    return (
        GlossyPhong(phong_exponent, (0.55, 0.55, 0.55), PAINT),
        GlossyGgx(GOLD, 1.0, float((2.0 / (phong_exponent / 4.0 + 2.0)) ** 0.25)),
        satin,
        GlossyPhong(1.0, BLACK, PLASTER),
    )


def main(
    out: Path, size: int = 256, frames: int = SECONDS * RATE, map_rows: int = 128, samples: int = 4, angles: int = 12
) -> None:
    """Writes ``strip.png`` and ``live.webp``, of pictures ``size`` pixels wide and high."""
    mesh = load_mesh("teapot")
    orbit = frame_mesh(mesh, elevation_deg=24.0, image_size=size)
    camera = replace(orbit, distance=0.93 * orbit.distance).camera()
    centre = 0.5 * (mesh.positions.min(0) + mesh.positions.max(0)).astype(float)
    radius = 0.5 * float(np.ptp(mesh.positions, axis=0).max())
    capture = EnvironmentCapture(shared_device(), surroundings(radius), map_rows, light=LIGHT, near=0.01 * radius)
    live = LiveEnvironment(map_rows)
    renderer = MaterialRenderer(mesh, live)
    satin = Measured(fit_lobes(measured(), angles=angles))

    def pictures(share: float, count: int) -> list[np.ndarray]:
        live.show(capture.frame(places(centre, radius, share), (centre[0], centre[1], centre[2])))
        return [
            picture_srgb(renderer.picture(each, camera, samples=samples)[..., :3])
            for each in materials(share, satin)[:count]
        ]

    out.mkdir(parents=True, exist_ok=True)
    moments = [k / 10 for k in range(1, 6)]
    rows = list(zip(*(pictures(share, 4) for share in moments), strict=True))
    titles = [f"N = {exponent(share):.0f}" for share in moments]
    write_png(out / "strip.png", plate([list(row) for row in rows], titles, ["Phong", "GGX", "measured", "matte"]))
    film = [Image.fromarray(np.concatenate(pictures(k / frames, 2), 1)) for k in range(frames)]
    with atomic_path(out / "live.webp") as path:
        film[0].save(path, "WEBP", save_all=True, append_images=film[1:], duration=1000 // RATE, loop=0, quality=80)
    print(f"Look at strip.png in {out}, and open live.webp in a browser.")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
