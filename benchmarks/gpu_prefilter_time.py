"""What it costs to prefilter an env map in every frame on the device, and what is lost.

    .venv/bin/python benchmarks/gpu_prefilter_time.py [ENVIRONMENT] [ROWS]

The environment is any map file (by default the labelled court), ROWS those of a filtered paraboloid's faces (512, as in
the notes); cubes have half as many. A *plain lookup* is a frame of a mirror sphere, 512² pixels with one lookup of an
unfiltered cube each. Ways alternate and medians count, so that a busy machine changes the ratios little.

First Phong's lobe: the paper's hardware method on dual paraboloids, in the table of [Heidrich00, sec. 3.2.5], and
beside it taps from a smooth pyramid (`LiveEnvironment`), into a cube of a quarter of its rows. Then `ProbeFilter`'s
chain for GGX, level by level, and the slices of a measured BRDF's lobes (`BrdfMapFilter`; the table of
examples/brdf_table.py), without and with a lamp. At last whole frames of a teapot whose environment and exponent are
new in each.

The *error* is the L1 error relative to brute force (`quadrature`), as Manson and Sloan measure: the sum of absolute
differences over that of the reference, all channels, over texels drawn at random, each weighted by its solid angle.
Sources have the rows of the filtered map (the cube: level 0 of the chain). Beside the chain: 32 importance samples a
texel, half vectors by the density of GGX, levels by the solid angle of a sample [Colbert07]; from a cube's ordinary mip
levels, which is how engines do it and what Manson and Sloan compare with, and from the smooth pyramid.
"""

import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path

import numpy as np
import wgpu

from reflet.envmap.env_image import EnvImage
from reflet.envmap.lamp import Lamp
from reflet.envmap.mip_chain import MipChain
from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.parameterizations.dual_paraboloid import DualParaboloid
from reflet.envmap.parameterizations.parameterization import Parameterization
from reflet.envmap.resampling.mip_reduction import mip_images
from reflet.envmap.resampling.resample import resample
from reflet.envmap.texture_filter import taps as texture_taps
from reflet.files.env_image_file import read_env_image
from reflet.pipelines.shade import frame_mesh, load_mesh
from reflet.reflectance.brdfs.ggx import GgxKernel, d_ggx
from reflet.reflectance.brdfs.kernel import Kernel
from reflet.reflectance.brdfs.phong import PhongKernel
from reflet.reflectance.brdfs.quadrature import filtered_reference
from reflet.reflectance.brdfs.tabulated_kernel import TabulatedKernel
from reflet.reflectance.lobes.lobe_taps import LobeTaps
from reflet.reflectance.lobes.lobes import THETA, Lobe, fit_lobes
from reflet.reflectance.materials.material import GlossyGgx, GlossyPhong, Mirror, SurfaceMaterial
from reflet.reflectance.materials.measured_material import Measured
from reflet.reflectance.prefilter.plane_filter import plane_filters
from reflet.render.device.device import adapter_name, shared_device
from reflet.render.filters.live_environment import LiveEnvironment
from reflet.render.filters.phong_paraboloid import PhongParaboloidFilter
from reflet.render.filters.probe_filter import ProbeFilter, ggx_kernels
from reflet.render.maps.env_map_texture import EnvMapTexture, upload_env_map
from reflet.render.materials.env_map_renderer import EnvMapRenderer
from reflet.render.materials.material_renderer import MaterialRenderer
from reflet.scene.builtin.labelled_court import labelled_court
from reflet.scene.meshes.primitives import sphere_mesh
from reflet.scene.views.camera import Camera

sys.path.insert(0, str(Path(__file__).parents[1] / "examples"))
from brdf_table import measured

ROUNDS = 7
CHECKED = 200  # texels
CHECKED_OF_SLICE = 20
LAMP = Lamp((0.5, 0.6, 0.3), 8.0, (32.0, 28.0, 20.0))
SAMPLES = 32
NOTES = {10: 25, 50: 20, 100: 16, 250: 16, 500: 9}  # frames a second on the SGI O2 of the notes, by exponent


def median_times(ways: Mapping[str, Callable[[], object]]) -> dict[str, float]:
    """Milliseconds a frame."""
    times = np.empty((ROUNDS + 1, len(ways)))
    for row in times:
        for j, draw in enumerate(ways.values()):
            start = time.perf_counter()
            draw()
            row[j] = 1000.0 * (time.perf_counter() - start)
    return dict(zip(ways, np.median(times[1:], 0).tolist(), strict=True))  # the first frames build pipelines


def submitted(device: wgpu.GPUDevice, passes: Callable[[wgpu.GPUCommandEncoder], EnvMapTexture]) -> EnvMapTexture:
    """What the passes fill, when it is there."""
    encoder = device.create_command_encoder()
    env_map = passes(encoder)
    device.queue.submit([encoder.finish()])
    return waited_for(env_map)


def waited_for(env_map: EnvMapTexture) -> EnvMapTexture:
    """The map when all that fills it is done."""
    last = {"texture": env_map.texture, "mip_level": env_map.texture.mip_level_count - 1}
    env_map.device.queue.read_texture(last, {"bytes_per_row": 256, "rows_per_image": 1}, (1, 1, 1))
    return env_map


@dataclass(frozen=True, eq=False)
class Source:
    """An environment, and what it should become."""

    image: EnvImage

    @cache  # noqa: B019
    def filtered(self, kernel: Kernel, size: int) -> np.ndarray:
        """By brute force, in some texels of a map of ``size`` rows."""
        return filtered_reference(self.image, kernel, directions(self.image.parameterization, size))

    def error(self, kernel: Kernel, env_map: EnvMapTexture, level: int = 0) -> float:
        """See the module."""
        size = env_map.size >> level
        some = some_texels(env_map.parameterization, size)
        return self.distance(kernel, size, env_map.read(level).texels.reshape(-1, 4)[some, :3].astype(float))

    def distance(self, kernel: Kernel, size: int, texels: np.ndarray) -> float:
        """The error of these texels."""
        expected = self.filtered(kernel, size)
        return float(np.abs(texels - expected).sum() / expected.sum())


def directions(kind: Parameterization, size: int) -> np.ndarray:
    """Of the texels that are looked at."""
    return kind.texel_directions(size)[0].reshape(-1, 3)[some_texels(kind, size)]


@cache
def some_texels(kind: Parameterization, size: int) -> np.ndarray:
    """Drawn at random, each as likely as it is large."""
    weight = kind.texel_solid_angle(size).ravel()
    return np.random.default_rng(0).choice(len(weight), CHECKED, p=weight / weight.sum())


def importance_samples(alpha: float) -> LobeTaps:
    """Hammersley's points; ``blur`` is the edge of the solid angle that a sample stands for, that of its texel."""
    u = (np.arange(SAMPLES) + 0.5) / SAMPLES
    v = np.array([int(f"{k:05b}"[::-1], 2) / SAMPLES for k in range(SAMPLES)])
    n_dot_h = np.sqrt((1.0 - u) / (1.0 + (alpha * alpha - 1.0) * u))
    theta, phi = 2.0 * np.arccos(n_dot_h), 2.0 * np.pi * v
    direction = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], -1)
    above = direction[:, 2] > 0.0
    edge = np.sqrt(4.0 / (SAMPLES * d_ggx(n_dot_h, alpha)))
    weight = direction[above, 2]
    return LobeTaps(direction[above], edge[above], weight / weight.sum())


def from_smooth_pyramid(samples: LobeTaps) -> LobeTaps:
    """The same as blurs: 0.6 of a texel (`probe_pyramid`)."""
    return LobeTaps(samples.direction, 0.6 * samples.blur, samples.weight)


def sampled_error(source: Source, kernel: GgxKernel, size: int) -> float:
    """The error of samples from ordinary mip levels of a cube, in texels of a level of ``size`` rows."""
    chain = MipChain(source.image.size)
    mips = np.concatenate([each.texels.reshape(-1, 3) for each in mip_images(source.image)]).astype(float)
    r = directions(CUBE, size)
    right = np.cross(r, np.where(np.abs(r[:, 1:2]) < 0.9, [[0.0, 1.0, 0.0]], [[1.0, 0.0, 0.0]]))
    right /= np.linalg.norm(right, axis=-1, keepdims=True)
    frames = np.stack([right, np.cross(r, right), r], 1)
    samples = importance_samples(kernel.alpha)
    texels_a_radian = chain.size * np.sqrt(6.0 / (4.0 * np.pi))
    lod = np.clip(np.log2(samples.blur * texels_a_radian), 0.0, chain.level_count - 1.0)
    total = np.zeros_like(r)
    for direction, level, weight in zip(samples.direction, lod, samples.weight, strict=True):
        indices, weights = texture_taps(chain, direction @ frames, np.full(len(r), level))
        total += weight * np.einsum("nt,ntc->nc", weights, mips[indices])
    return source.distance(kernel, size, total)


def environment(path: str | None, to: Parameterization, rows: int) -> EnvImage:
    """In ``rows`` rows, in what half floats can hold."""
    image = labelled_court(rows) if path is None else read_env_image(path)
    texels = np.clip(resample(image, to, rows).texels, 0.0, 65504.0)
    return EnvImage(to, texels.astype(np.float16))


class Ways:
    """What is timed and measured."""

    def __init__(self, path: str | None, rows: int) -> None:
        self.device, self.rows = shared_device(), rows
        self.paraboloid, self.cube = (
            Source(environment(path, kind, size)) for kind, size in ((DualParaboloid(), rows), (CUBE, rows // 2))
        )
        self.source = upload_env_map(self.device, [self.paraboloid.image])
        self.cube_source = upload_env_map(self.device, mip_images(self.cube.image))
        self.hardware, self.probe = PhongParaboloidFilter(self.device, rows), ProbeFilter(self.device, rows // 2)
        self.live = LiveEnvironment(rows // 2, self.device)
        self.sphere, self.camera = EnvMapRenderer(sphere_mesh()), Camera((0.0, 0.0, 4.0), (0.0, 0.0, 0.0))
        mesh = load_mesh("teapot")
        self.frames = MaterialRenderer(mesh, self.live)
        self.frame_camera = frame_mesh(mesh).camera()
        self.count = 0

    def plain(self) -> None:
        """One lookup a pixel."""
        self.sphere.picture(self.cube_source, self.camera, samples=1, backdrop=False)

    def by_paraboloids(self, exponent: float) -> EnvMapTexture:
        """The paper's method."""
        return submitted(
            self.device, lambda encoder: self.hardware.refilter(encoder, self.source, PhongKernel(exponent))
        )

    def by_taps(self, exponent: float) -> EnvMapTexture:
        """Phong on a cube, from the environment on."""
        self.live.show(self.cube_source)
        return waited_for(self.live.maps(GlossyPhong(exponent)).reflected)

    def chain(self) -> EnvMapTexture:
        """GGX, from the environment on."""
        return submitted(self.device, lambda encoder: self.probe.refilter(encoder, self.cube_source))

    def slices(self, lamp: Lamp | None = None) -> EnvMapTexture:
        """Of the measured BRDF's lobes, from the environment on."""
        self.live.show(self.cube_source, lamp)
        return waited_for(self.live.maps(MEASURED).reflected)

    def frame(self, material: Callable[[float], SurfaceMaterial]) -> None:
        """One sample a pixel, with environment and exponent as new."""
        self.count += 1
        self.live.show(self.cube_source)
        self.frames.picture(material(20.0 + self.count), self.frame_camera, samples=1)


MEASURED = Measured(fit_lobes(measured(), angles=12))
MATERIALS: dict[str, Callable[[float], SurfaceMaterial]] = {
    "a mirror, nothing filtered": lambda _: Mirror(),
    "matte: diffuse": lambda _: GlossyPhong(1.0, (0.0, 0.0, 0.0), (1.0, 1.0, 1.0)),
    "Phong": GlossyPhong,
    "Phong over matte": lambda exponent: GlossyPhong(exponent, (0.5, 0.5, 0.5), (0.5, 0.5, 0.5)),
    "GGX, metallic: all levels": lambda exponent: GlossyGgx((1.0, 1.0, 1.0), 1.0, 1.0 / exponent),
    "GGX over matte": lambda exponent: GlossyGgx((0.5, 0.5, 0.5), 0.0, 1.0 / exponent),
    "measured: 24 slices over matte": lambda _: MEASURED,
}


def print_phong(ways: Ways, times: Mapping[str, float]) -> None:
    """The notes' table."""
    print(f"Phong: dual paraboloids of {ways.rows} rows; taps into a cube of {ways.rows // 4}")
    print(f"{'exponent':>8s}{'filter sizes':>14s}{'shrink factors':>16s}", end="")
    print(f"{'ms':>8s}{'plain lookups':>15s}{'per second':>12s}{'notes':>7s}{'error':>8s}", end="")
    print(f"{'taps: ms':>10s}{'lookups':>9s}{'error':>8s}")
    for exponent, rate in NOTES.items():
        kernel = PhongKernel(exponent)
        small, large = plane_filters(kernel, ways.rows)
        sizes, factors = f"{small.size}, {large.size}", f"{1 << small.shrink_level}, {1 << large.shrink_level}"
        took, off = times[f"paraboloids {exponent}"], ways.paraboloid.error(kernel, ways.by_paraboloids(exponent))
        speed = f"{took:8.1f}{took / times['plain']:15.2f}{1000 / took:12.0f}{rate:7d}"
        took_taps, off_taps = times[f"taps {exponent}"], ways.cube.error(kernel, ways.by_taps(exponent))
        taps = f"{took_taps:10.1f}{took_taps / times['plain']:9.2f}{off_taps:8.3f}"
        print(f"{exponent:8d}{sizes:>14s}{factors:>16s}{speed}{off:8.3f}{taps}")


def print_ggx(ways: Ways, took: float, plain: float) -> None:
    """Level by level, beside importance samples."""
    size = ways.probe.size
    kernels = ggx_kernels(size)
    errors = np.empty((len(kernels), 3))
    for level, kernel in enumerate(kernels, start=1):
        errors[level - 1, 0] = ways.cube.error(kernel, ways.chain(), level)
        errors[level - 1, 1] = sampled_error(ways.cube, kernel, size >> level)
    for level, kernel in enumerate(kernels, start=1):
        ways.probe.set_lobe(level, from_smooth_pyramid(importance_samples(kernel.alpha)))
    for level, kernel in enumerate(kernels, start=1):
        errors[level - 1, 2] = ways.cube.error(kernel, ways.chain(), level)
    print(f"\nGGX, a cube of {size} rows: {took:.1f} ms, {took / plain:.2f} plain lookups")
    head = f"{SAMPLES} samples: mips"
    print(f"{'level':>5s}{'rows':>6s}{'alpha':>8s}{'error':>8s}{head:>18s}{'pyramid':>9s}{'ratios':>14s}")
    for level, (row, kernel) in enumerate(zip(errors, kernels, strict=True), start=1):
        print(f"{level:5d}{size >> level:6d}{kernel.alpha:8.3f}", figures(row))
    print(f"{'all':>5s}{'':14s}", figures(errors.mean(0)))


def print_measured(ways: Ways, took: float, plain: float) -> None:
    """Lobe by lobe. A slice counts by its light."""
    angles = len(MEASURED.lobes.cos_theta_o)
    shown = ways.slices()
    cost = f"{took:.1f} ms, {took / plain:.2f} plain lookups"
    print(f"\nA measured BRDF, {angles} slices a lobe of {shown.size} rows: {cost}")
    print(f"{'lobe':>8s}{'error':>8s}{'with a lamp':>13s}")
    image = ways.cube.image
    share = (
        LAMP.share(CUBE.texel_directions(4 * image.size)[0]).reshape(6, image.size, 4, image.size, 4, 1).mean((2, 4))
    )
    lit = EnvImage(CUBE, image.texels.astype(np.float32) + share.astype(np.float32) * np.float32(LAMP.radiance))
    for number, lobe in enumerate(MEASURED.lobes.lobes):
        errors = [
            slices_error(lobe, ways.slices(lamp), number * angles, light)
            for light, lamp in ((image, None), (lit, LAMP))
        ]
        print(f"{lobe.name:>8s}{errors[0]:8.3f}{errors[1]:13.3f}")


def slices_error(lobe: Lobe, shown: EnvMapTexture, first: int, light: EnvImage) -> float:
    """The error of a lobe's slices in texels drawn at random."""
    kind = shown.parameterization
    some = some_texels(kind, shown.size)[:CHECKED_OF_SLICE]
    direction = kind.texel_directions(shown.size)[0].reshape(-1, 3)[some]
    off = total = 0.0
    for k, (densities, albedo) in enumerate(zip(lobe.densities, lobe.albedo, strict=True)):
        texels = shown.read(0, first + k).texels.reshape(-1, 4)[some]
        for c in np.flatnonzero(albedo):
            channel = EnvImage(light.parameterization, light.texels[..., c : c + 1])
            kernel = TabulatedKernel(THETA, densities[:, c])
            expected = albedo[c] * filtered_reference(channel, kernel, direction)[:, 0]
            off, total = off + float(np.abs(texels[:, c] - expected).sum()), total + float(expected.sum())
    return off / total


def figures(errors: np.ndarray) -> str:
    """Ours, the others', and theirs over ours."""
    ours, mips, pyramid = errors
    return f"{ours:7.3f}{mips:18.3f}{pyramid:9.3f}{mips / ours:7.1f}{pyramid / ours:7.1f}"


def main() -> None:
    """Prints the four tables."""
    path = sys.argv[1] if len(sys.argv) > 1 else None
    ways = Ways(path, int(sys.argv[2]) if len(sys.argv) > 2 else 512)
    timed: dict[str, Callable[[], object]] = {"plain": ways.plain, "chain": ways.chain, "slices": ways.slices}
    for exponent in NOTES:
        timed[f"paraboloids {exponent}"] = partial(ways.by_paraboloids, exponent)
        timed[f"taps {exponent}"] = partial(ways.by_taps, exponent)
    for name, material in MATERIALS.items():
        timed[name] = partial(ways.frame, material)
    times = median_times(timed)
    print(f"{adapter_name(ways.device)}\nplain lookup: {times['plain']:.1f} ms a frame\n")
    print_phong(ways, times)
    print_ggx(ways, times["chain"], times["plain"])
    print_measured(ways, times["slices"], times["plain"])
    print(f"\nFrames of {ways.frame_camera.width}² pixels, environment and exponent new in each: ms, plain lookups")
    for name in MATERIALS:
        print(f"{name:>36s}{times[name]:9.1f}{times[name] / times['plain']:7.2f}")


if __name__ == "__main__":
    main()
