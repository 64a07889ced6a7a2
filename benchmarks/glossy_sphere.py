"""How far the split sum is from path tracing: a glossy sphere by both, by roughness.

`python benchmarks/glossy_sphere.py [ENV] [--out FOLDER] [--spp N]`; without a file, the labelled court with its sun.
The sphere absorbs nothing (F = 1). The reference is Mitsuba's path integrator with its GGX `roughconductor`, of single
scattering; ours is drawn by `MaterialRenderer` with `GlossyGgx`. "shown" is our picture as it is, which keeps the light
that bounces twice between microfacets; "single" is the same with the reference's loss, so that only the lobe's shape
differs. "n=v=r" is the plain split sum, with that loss too: filtered for this very roughness, not between levels, and
looked up in the mirrored direction.

Display PSNR is that of sRGB(1 - exp(-1.6·radiance)); the linear error is the root mean square difference over the
root mean square reference, both on the sphere's whole pixels. With --out pictures are written: path traced, n=v=r,
single and shown, for every other roughness.
"""

import argparse
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.latlong import LatLong
from reflet.envmap.resampling.resample import resample
from reflet.files.env_image_file import read_env_image
from reflet.files.pictures.png import write_png
from reflet.reflectance.brdfs.ggx import GgxKernel
from reflet.reflectance.materials.material import GlossyGgx
from reflet.reflectance.materials.material_maps import EnvironmentMaps
from reflet.reflectance.prefilter.prefilter import Prefilter
from reflet.render.materials.material_renderer import MaterialRenderer
from reflet.report.measures import display_psnr, picture_srgb
from reflet.report.plate import plate
from reflet.scene.builtin.labelled_court import labelled_court
from reflet.scene.material import EnvironmentLight
from reflet.scene.meshes.primitives import sphere_mesh
from reflet.scene.views.camera import Camera
from reflet.trace.references.glossy_reference import GlossySphere, albedo

ROUGHNESS = tuple(k / 10 for k in range(1, 11))
CAMERA = Camera((1.6, 1.0, 3.6), (0.0, 0.0, 0.0), fov_deg=32.0, width=192, height=192)


def rays(camera: Camera) -> Float[np.ndarray, "height width 3"]:
    """Unit view rays through the pixels' middles."""
    corner, dx, dy = camera.ray_basis()
    y, x = np.mgrid[: camera.height, : camera.width] + 0.5
    ray = corner + x[..., None] * dx + y[..., None] * dy
    return np.asarray(ray / np.linalg.norm(ray, axis=-1, keepdims=True))


def cosines(camera: Camera) -> Float[np.ndarray, "height width"]:
    """n·v where the ray through a pixel's middle meets the unit sphere, 0 beside it."""
    eye = np.asarray(camera.position)
    along = rays(camera) @ eye
    return np.sqrt(np.maximum(along**2 - eye @ eye + 1.0, 0.0))


def plain_split_sum(
    environment: Prefilter, camera: Camera, alpha: float, mask: Bool[np.ndarray, "height width"]
) -> Float[np.ndarray, "height width 3"]:
    """The environment filtered with `GgxKernel` about the mirrored directions of pixels' middles."""
    ray = rays(camera)[mask]
    eye, cosine = np.asarray(camera.position), cosines(camera)[mask]
    normal = eye + (-(ray @ eye) - cosine)[:, None] * ray
    out = np.zeros((*mask.shape, 3))
    out[mask] = environment.radiance(GgxKernel(alpha), ray + 2.0 * cosine[:, None] * normal)
    return out


def linear_error(reference: np.ndarray, picture: np.ndarray, mask: Bool[np.ndarray, "height width"]) -> float:
    """Root mean square of the difference over that of the reference."""
    difference = np.square(picture[mask].astype(float) - reference[mask]).mean()
    return float(np.sqrt(difference / np.square(reference[mask].astype(float)).mean()))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("environment", nargs="?", type=Path)
    parser.add_argument("--out", type=Path)
    parser.add_argument("--spp", type=int, default=256)
    parser.add_argument("--roughness", type=float, nargs="+", default=ROUGHNESS)
    arguments = parser.parse_args()
    source = read_env_image(arguments.environment) if arguments.environment else labelled_court(512)
    image: EnvImage = resample(source, LatLong(), 512)

    traced = GlossySphere(EnvironmentLight(image.texels[0, ..., :3]))
    prefilter = Prefilter(image)
    renderer = MaterialRenderer(sphere_mesh(around=512), EnvironmentMaps(image))
    cosine = cosines(CAMERA)
    rows = []
    names = "".join(f"{name:>9s}" for name in ("n=v=r", "single", "shown"))
    print(f"{'':18s}display PSNR, dB{'':13s}linear error\n{'roughness':>9s}{'noise':>9s}{names}  {names}")
    for roughness in arguments.roughness:
        halves = [traced.picture(CAMERA, roughness**2, spp=arguments.spp // 2, seed=seed) for seed in (0, 1)]
        reference = np.mean(halves, 0)
        material = GlossyGgx(metallic=1.0, perceptual_roughness=roughness)
        picture = renderer.picture(material, CAMERA, samples=16, backdrop=False)
        shown, mask = picture[..., :3], (picture[..., 3] > 0.999) & (cosine > 0.05)
        lost = np.ones_like(cosine)
        some = np.linspace(0.05, 1.0, 128)  # it is smooth; each takes 4096 samples
        lost[mask] = np.interp(cosine[mask], some, albedo(some, roughness**2))
        lost = lost[..., None].astype(np.float32)
        ours = (lost * plain_split_sum(prefilter, CAMERA, roughness**2, mask), lost * shown, shown)
        noise = display_psnr(halves[0], halves[1], mask) + 10.0 * np.log10(4.0)  # of the two halves' mean
        display = "".join(f"{display_psnr(reference, each, mask):9.1f}" for each in ours)
        linear = "".join(f"{linear_error(reference, each, mask):9.1%}" for each in ours)
        print(f"{roughness:9.1f}{noise:9.1f}{display}  {linear}", flush=True)
        rows.append([picture_srgb(np.where(mask[..., None], each, 0.0)) for each in (reference, *ours)])
    if arguments.out:
        columns = [[row[k] for row in rows[::2]] for k in range(4)]
        titles = [f"roughness {roughness:g}" for roughness in arguments.roughness[::2]]
        names = ("path traced", "n = v = r, single scattering", "ours, single scattering", "ours, energy kept")
        write_png(arguments.out / "glossy_sphere.png", plate(columns, titles, names))


if __name__ == "__main__":
    main()
