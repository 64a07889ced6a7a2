"""Models as three.js shows them, as reflet does, and path traced: how far the two are from the third.

    python benchmarks/beside_three.py FOLDER [--models FILE …] [--environments FILE.hdr …] [--reflect NAME …]
                                      [--size 256] [--spp 1024] [--quick]

Each model is baked under each environment with no options but those, into FOLDER (bakes and path traced pictures that
are there are kept), and played back at rest from three viewpoints that the bake does not look from. three.js shows the
same file by its own loaders: materials and occlusion maps as its GLTFLoader makes them, the environment as its
PMREMGenerator filters it, no tone mapping, the mean of 4² points a pixel; a mesh without a material is the mirror that
it is for reflet. The reference is Mitsuba's path integrator with glTF's own material, the light between microfacets
kept, light bouncing up to 8 times, 32 where there is glass. Sheen, iridescence, anisotropy and dispersion are in none
of the three.

Printed for each shot: display PSNR, SSIM and mean FLIP of the model's pixels (coverage above one half), the ratio of
FLIP to three.js's, the gain in dB, and the reference's own noise, by two halves of its samples, as display PSNR.
Written are a sheet of pictures with maps of their FLIP for each model and environment, and all numbers as
beside_three.json. three.js must be installed (make web) and runs in headless Chromium.
"""

import argparse
import json
import subprocess
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float
from matplotlib import colormaps

from reflet.errors import RefletError
from reflet.files.pictures.exr import read_exr, write_exr
from reflet.files.pictures.png import write_png
from reflet.pem.reader import open_pem
from reflet.pipelines.bake import bake
from reflet.pipelines.load import load_scene
from reflet.render.playback.renderer import Renderer
from reflet.report.measures import bounding_box, display_psnr, flip, flip_map, picture_srgb, ssim
from reflet.report.plate import plate
from reflet.scene.scene import Scene
from reflet.scene.views.camera import Camera
from reflet.scene.views.framing import frame_orbit
from reflet.trace.device_scene import DeviceScene
from reflet.trace.references.path_reference import PathReference
from reflet.trace.visible import covered_share

DATA = Path(__file__).parents[2] / "shared" / "data"
MODELS = [
    DATA / "models" / name
    for name in (
        "BoomBox_reduced.glb", "Corset_reduced.glb", "WaterBottle/WaterBottle.gltf", "Ingenuity_decoded.glb",
        "boombox_nomat.glb", "shaderball.glb", "torus.glb", "Suzanne/Suzanne.gltf",
        "MaterialsVariantsShoe/MaterialsVariantsShoe.gltf", "SheenChair.glb", "NormalTangentMirrorTest.glb",
        "GlassVaseFlowers.glb",
    )
]  # fmt: skip
ENVIRONMENTS = [DATA / "hdr" / "studio_small_05_1k.hdr", DATA / "hdr" / "venice_sunset_1k.hdr"]
VIEWPOINTS = ((15.0, 8.0), (140.0, 35.0), (265.0, 55.0))  # azimuth and elevation
THREE = Path(__file__).parents[1] / "web" / "test" / "three.mjs"
ACROSS = 4  # points of three.js along a pixel's side
MOST_BOUNCES, IN_GLASS = 8, 32
QUICK = (128, 64, 1)  # picture size, samples a pixel, viewpoints
WORST_FLIP = 0.5  # at the top of the colour scale
COLOURS = colormaps["magma"]

Picture = Float[np.ndarray, "height width 3"]
Mask = Bool[np.ndarray, "height width"]


@dataclass(frozen=True)
class Score:
    """How far a picture is from the reference."""

    psnr: float
    ssim: float
    flip: float


@dataclass(frozen=True)
class Shot:
    """One viewpoint's scores; ``noise`` is the reference's own, as display PSNR in dB."""

    model: str
    environment: str
    azimuth_deg: float
    elevation_deg: float
    three: Score
    reflet: Score
    noise: float

    @property
    def ratio(self) -> float:
        """FLIP to three.js's."""
        return self.reflet.flip / max(self.three.flip, 1e-9)

    @property
    def gain(self) -> float:
        """Display PSNR over three.js's, in dB."""
        return self.reflet.psnr - self.three.psnr


def three_pictures(
    model: Path, environment: Path, cameras: Sequence[Camera], reach: float, folder: Path, across: int = ACROSS
) -> list[Picture]:
    """What three.js shows of a model: linear radiance. Pictures are square and of one size; ``reach`` is the radius of
    a sphere around the cameras' targets that holds the model. Scratch files go into ``folder``.

    Raises RefletError, with what the browser said, where it could not.
    """
    shots = []
    for number, camera in enumerate(cameras):
        distance = float(np.linalg.norm(np.subtract(camera.position, camera.target)))
        depths = {"near": max(0.99 * (distance - reach), 1e-3 * distance), "far": 1.01 * (distance + reach)}
        placed = {"position": camera.position, "target": camera.target, "up": camera.up, "fov": camera.fov_deg}
        files = {"model": str(model.resolve()), "environment": str(environment.resolve())}
        shots.append({"name": f"three-{number}", **files, **placed, **depths})
    size = cameras[0].width
    wanted = folder / "three.json"
    wanted.write_text(json.dumps({"size": size, "across": across, "shots": shots}))
    done = subprocess.run(["node", THREE, wanted, folder], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RefletError(f"three.js did not show {model.name}: {done.stderr.strip()[:1000]}")
    return [np.fromfile(folder / f"{shot['name']}.f32", np.float32).reshape(size, size, 3) for shot in shots]


def path_traced(scene: Scene, cameras: Sequence[Camera], spp: int, folder: Path) -> list[tuple[Picture, Picture]]:
    """For each camera two independent pictures of half the samples; kept in ``folder``, side by side."""
    reference: PathReference | None = None
    depth = IN_GLASS if any(part.material.refraction for part in scene.parts) else MOST_BOUNCES
    out = []
    for number, camera in enumerate(cameras):
        kept = folder / f"path-{number}-{camera.width}-{spp}-{depth}.exr"
        if not kept.exists():
            reference = reference or PathReference(scene, materials="gltf")
            halves = [reference.picture(camera, spp=spp // 2, max_depth=depth, seed=seed) for seed in (1, 2)]
            write_exr(kept, np.concatenate(halves, 1))
        first, second = np.split(read_exr(kept), 2, 1)
        out.append((first, second))
    return out


def beside(
    model: Path, environment: Path, reflect: Sequence[str], out: Path, size: int, spp: int, viewpoints: int
) -> list[Shot]:
    """One model under one environment, its sheet of pictures written."""
    folder = out / f"{model.stem}-{environment.stem}"
    folder.mkdir(parents=True, exist_ok=True)
    scene = load_scene(model, environment=environment, reflect=reflect)
    began = time.monotonic()
    bake(scene, folder / "pem", resume=(folder / "pem").exists())
    print(f"{folder.name}: baked in {time.monotonic() - began:.0f} s", flush=True)
    orbit = replace(frame_orbit(scene), image_size=size)
    places = VIEWPOINTS[:viewpoints]
    cameras = [orbit.camera({"azimuth_deg": azimuth, "elevation_deg": elevation}) for azimuth, elevation in places]
    positions = np.concatenate([part.mesh.positions for part in scene.parts])
    reach = float(np.linalg.norm(positions - np.float32(orbit.target), axis=1).max())
    theirs = three_pictures(model, environment, cameras, reach, folder)
    references = path_traced(scene, cameras, spp, folder)
    renderer, device = Renderer(open_pem(folder / "pem")), DeviceScene(scene)
    shots, rows = [], []
    for place, camera, three, (first, second) in zip(places, cameras, theirs, references, strict=True):
        reference, mask = 0.5 * (first + second), covered_share(device, camera, 16) > 0.5
        pictures = {"three": three, "reflet": renderer.frame(camera, samples="adaptive")[..., :3]}
        scores = {name: score(reference, picture, mask) for name, picture in pictures.items()}
        noise = display_psnr(first, second, mask) + 10.0 * float(np.log10(4.0))  # of the halves' mean
        shots.append(Shot(model.stem, environment.stem, *place, scores["three"], scores["reflet"], noise))
        shown = [picture_srgb(each) for each in (pictures["three"], pictures["reflet"], reference)]
        rows.append([*shown, *(error_colours(reference, each, mask) for each in pictures.values())])
    titles = [
        f"azimuth {shot.azimuth_deg:g}°, elevation {shot.elevation_deg:g}°: {shot.three.psnr:.1f} and "
        f"{shot.reflet.psnr:.1f} dB, FLIP {shot.three.flip:.3f} and {shot.reflet.flip:.3f}"
        for shot in shots
    ]
    names = ("three.js", "reflet", "path traced", "FLIP of three.js", "FLIP of reflet")
    write_png(out / f"{folder.name}.png", plate(rows, names, titles))
    return shots


def score(reference: Picture, picture: Picture, mask: Mask) -> Score:
    return Score(*(measure(reference, picture, mask) for measure in (display_psnr, ssim, flip)))


def error_colours(reference: Picture, picture: Picture, mask: Mask) -> np.ndarray:
    """FLIP on the model's pixels, from 0 to `WORST_FLIP`."""
    error = np.zeros(mask.shape)
    error[bounding_box(mask)] = flip_map(reference, picture, mask)
    colours = COLOURS(np.clip(error / WORST_FLIP, 0.0, 1.0))[..., :3]
    return np.where(mask[..., None], np.round(255.0 * colours), 64.0).astype(np.uint8)


def line(shot: Shot) -> str:
    name = f"{shot.model[:24]}, {shot.environment[:16]}"
    figures = "".join(f"{s.psnr:7.2f}{s.ssim:7.3f}{s.flip:7.3f}" for s in (shot.three, shot.reflet))
    return (
        f"{name:42}{shot.azimuth_deg:5.0f}{shot.elevation_deg:4.0f}{figures}"
        f"{shot.ratio:7.2f}{shot.gain:7.2f}{shot.noise:7.1f}"
    )


def summary(shots: Sequence[Shot]) -> str:
    """Means over all shots and the worst of them."""
    ratio, gain = np.mean([shot.ratio for shot in shots]), np.mean([shot.gain for shot in shots])
    least, highest = min(shots, key=lambda shot: shot.gain), max(shots, key=lambda shot: shot.ratio)
    above = sum(shot.ratio > 0.9 for shot in shots)
    below = sum(shot.gain < 0.0 for shot in shots)
    return (
        f"{len(shots)} shots: FLIP {ratio:.2f} of three.js's on average, {gain:+.2f} dB; {above} above 0.90, {below} "
        f"below three.js in dB\nhighest FLIP ratio: {line(highest)}\nleast gain:         {line(least)}"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--models", type=Path, nargs="+", default=MODELS)
    parser.add_argument("--environments", type=Path, nargs="+", default=ENVIRONMENTS)
    parser.add_argument("--reflect", nargs="+", default=())
    parser.add_argument("--size", type=int, default=256)
    parser.add_argument("--spp", type=int, default=1024)
    parser.add_argument("--quick", action="store_true", help=f"{QUICK[0]}², {QUICK[1]} samples a pixel, one viewpoint")
    asked = parser.parse_args()
    size, spp, viewpoints = QUICK if asked.quick else (asked.size, asked.spp, len(VIEWPOINTS))
    head = f"{'':42}{'az':>5}{'el':>4}" + "".join(f"{what:>21}" for what in ("three.js: dB SSIM FLIP", "reflet"))
    shots: list[Shot] = []
    print(f"{head}{'ratio':>7}{'gain':>7}{'noise':>7}")
    for model in asked.models:
        for environment in asked.environments:
            try:
                found = beside(model, environment, asked.reflect, asked.folder, size, spp, viewpoints)
            except RefletError as error:
                print(f"{model.stem}, {environment.stem}: {error}", flush=True)
                continue
            shots += found
            print("\n".join(map(line, found)), flush=True)
            records = [{**asdict(shot), "ratio": shot.ratio, "gain": shot.gain} for shot in shots]
            (asked.folder / "beside_three.json").write_text(json.dumps(records, indent=1))
    if shots:
        print(summary(shots))


if __name__ == "__main__":
    main()
