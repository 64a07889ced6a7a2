"""Four ways to the same prefiltered map: Figure 13 of Environment Maps and Their Applications (2000).

Run it with the folder to write to, and if you like with an environment of your own::

    python examples/filtering_methods.py out/methods [studio.hdr]

A dual paraboloid of 2 × 128² texels, filtered with Phong's lobe of exponent 100: unfiltered; by the *classic* method,
each texel a sum over all; the *hierarchical* one, sums over a quadtree; the notes' *hardware* method, two plane filters
on mip levels, blended by d²; and, which the notes could not have, 37 *taps* from a smooth pyramid. ``methods.png``
shows the front's map, a sphere and a teapot that reflect with it, and how far each is from the classic method, as a
share of the map's mean radiance: black is none, white a half. Printed are the L1 error over all directions and times.

What correct looks like: all four blur alike, without a seam; the hierarchical method's error is black. The hardware
method makes a sun a disc with a ragged edge: it cuts the lobe off at a tenth of its height, in a filter of 7² texels.
The taps make it soft, a little out of round.
"""

import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from matplotlib import colormaps

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.parameterizations.dual_paraboloid import DualParaboloid
from reflet.envmap.resampling.mip_reduction import mip_images
from reflet.envmap.resampling.resample import radiance_at, resample
from reflet.files.env_image_file import read_env_image
from reflet.files.pictures.png import write_png
from reflet.pipelines.shade import frame_mesh, load_mesh
from reflet.reflectance.brdfs.phong import PhongKernel
from reflet.reflectance.brdfs.quadrature import filtered_reference
from reflet.reflectance.materials.material import GlossyPhong
from reflet.reflectance.prefilter.prefilter import Prefilter
from reflet.render.device.device import shared_device
from reflet.render.filters.live_environment import LiveEnvironment
from reflet.render.filters.phong_paraboloid import PhongParaboloidFilter
from reflet.render.maps.env_map_texture import upload_env_map
from reflet.render.materials.env_map_renderer import EnvMapRenderer
from reflet.report.measures import picture_srgb
from reflet.report.plate import plate
from reflet.scene.builtin.labelled_court import labelled_court

EXPONENT = 100.0
PARABOLOID = DualParaboloid()
WHITE_ERROR = 0.5  # of the mean radiance
ERRORS = colormaps["magma"]


def classic(image: EnvImage) -> EnvImage:
    """By brute force."""
    direction, _ = PARABOLOID.texel_directions(image.size)
    texels = filtered_reference(image, PhongKernel(EXPONENT), direction.reshape(-1, 3))
    return EnvImage(PARABOLOID, texels.reshape(*PARABOLOID.shape(image.size), 3).astype(np.float32))


def hierarchical(image: EnvImage) -> EnvImage:
    """By a quadtree of the environment."""
    return Prefilter(image).map(PhongKernel(EXPONENT), PARABOLOID, image.size)


def hardware(image: EnvImage) -> EnvImage:
    """By render passes, with the notes' border of an eighth."""
    device = shared_device()
    source = upload_env_map(device, mip_images(image))
    encoder = device.create_command_encoder()
    passes = PhongParaboloidFilter(device, image.size, border=image.size // 8)
    filtered = passes.refilter(encoder, source, PhongKernel(EXPONENT))
    device.queue.submit([encoder.finish()])
    return EnvImage(PARABOLOID, filtered.read().texels[..., :3])


def taps(image: EnvImage) -> EnvImage:
    """By taps of a cube's pyramid; the filtered cube has half as many rows as the paraboloid."""
    live = LiveEnvironment(image.size)
    live.show(image)
    cube = live.maps(GlossyPhong(EXPONENT)).reflected.read()
    direction, _ = PARABOLOID.texel_directions(image.size)
    return EnvImage(PARABOLOID, radiance_at(cube, direction)[..., :3].astype(np.float32))


METHODS: dict[str, Callable[[EnvImage], EnvImage]] = {
    "unfiltered": lambda image: image, "classic": classic, "hierarchical": hierarchical, "hardware": hardware,
    "taps": taps,
}  # fmt: skip


def main(
    out: Path, source: Path | None = None, map_rows: int = 128, picture: int = 256, samples: int = 16
) -> dict[str, float]:
    """Writes ``methods.png``, each of its pictures ``picture``² pixels, and returns the L1 errors."""
    environment = read_env_image(source) if source else labelled_court(2 * map_rows)
    image = resample(environment, PARABOLOID, map_rows)
    maps: dict[str, EnvImage] = {}
    errors: dict[str, float] = {}
    for name, method in METHODS.items():
        start = time.perf_counter()
        maps[name] = method(image)
        took = time.perf_counter() - start
        solid_angle = PARABOLOID.texel_solid_angle(map_rows)[..., None]
        mean = float((solid_angle * maps["unfiltered"].texels).sum() / (3.0 * solid_angle.sum()))
        if name != "unfiltered":
            off = np.abs(maps[name].texels - maps["classic"].texels)
            errors[name] = float((solid_angle * off).sum() / (solid_angle * maps["classic"].texels).sum())
            print(f"{name:>12s}: L1 error {errors[name]:.3f} of the classic method's light, {took:.2f} s all in all")

    def enlarged(pixels: np.ndarray) -> np.ndarray:
        index = np.arange(picture) * map_rows // picture
        return pixels[index][:, index]

    def difference(name: str) -> np.ndarray:
        off = np.abs(maps[name].texels - maps["classic"].texels)[0].mean(-1) / mean
        return (255.0 * ERRORS(np.minimum(off / WHITE_ERROR, 1.0))[..., :3]).astype(np.uint8)

    inside = PARABOLOID.texel_directions(map_rows)[1][0, ..., None]
    rows = [[enlarged(np.where(inside, picture_srgb(each.texels[0]), 255)) for each in maps.values()]]
    backdrop = upload_env_map(shared_device(), mip_images(resample(environment, CUBE, map_rows)))
    textures = [upload_env_map(shared_device(), mip_images(each)) for each in maps.values()]
    for mesh in (load_mesh("sphere"), load_mesh("teapot")):
        renderer = EnvMapRenderer(mesh)
        camera = frame_mesh(mesh, image_size=picture).camera()
        drawn = [renderer.picture(each, camera, samples=samples, backdrop=backdrop) for each in textures]
        rows.append([picture_srgb(each[..., :3]) for each in drawn])
    rows.append([enlarged(np.where(inside, difference(name), 255)) for name in maps])
    out.mkdir(parents=True, exist_ok=True)
    titles = ["the map, z ≥ 0", "a sphere", "a teapot", "the map's distance to the classic one"]
    write_png(out / "methods.png", plate([[each.astype(np.uint8) for each in row] for row in rows], list(maps), titles))
    print(f"Look at methods.png in {out}.")
    return errors


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]) if len(sys.argv) > 2 else None)
