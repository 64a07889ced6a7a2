"""What it costs to prefilter an env map in every frame on the device, and what is lost.

    .venv/bin/python benchmarks/gpu_prefilter_time.py [ENVIRONMENT] [ROWS]

The environment is any map file (by default the labelled court), ROWS those of a filtered map's faces (512, as in the
notes). A *plain lookup* is a frame of a mirror sphere, 512² pixels with one lookup of an unfiltered cube each. Ways
alternate and medians count, so that a busy machine changes the ratios little.

First the paper's hardware method on dual paraboloids, in the table of [Heidrich00, sec. 3.2.5], then `ProbeFilter`'s
chain for GGX on cubes of half as many rows, level by level.

The *error* is the L1 error relative to brute force (`quadrature`), as Manson and Sloan measure: the sum of absolute
differences over that of the reference, all channels, over texels drawn at random, each weighted by its solid angle.
Sources have the rows of the filtered map (the cube: level 0 of the chain). Beside the chain: 32 importance samples a
texel, half vectors by the density of GGX, levels by the solid angle of a sample [Colbert07], from the same pyramid.
"""

import sys
import time
from collections.abc import Callable, Mapping

import numpy as np
import wgpu

from reflet.envmap.cube import CUBE
from reflet.envmap.dual_paraboloid import DualParaboloid
from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterization import Parameterization
from reflet.envmap.resample import resample
from reflet.files.env_image_file import read_env_image
from reflet.reflectance.ggx import d_ggx
from reflet.reflectance.kernel import Kernel
from reflet.reflectance.lobe_taps import LobeTaps, lobe_taps
from reflet.reflectance.phong import PhongKernel
from reflet.reflectance.plane_filter import plane_filters
from reflet.reflectance.quadrature import filtered_reference
from reflet.render.device import adapter_name, shared_device
from reflet.render.env_map_renderer import EnvMapRenderer
from reflet.render.env_map_texture import EnvMapTexture, upload_env_map
from reflet.render.phong_paraboloid import PhongParaboloidFilter
from reflet.render.probe_filter import ProbeFilter, ggx_kernels
from reflet.scene.camera import Camera
from reflet.scene.labelled_court import labelled_court
from reflet.scene.primitives import sphere_mesh

ROUNDS = 7
CHECKED = 400  # texels
SAMPLES = 32
NOTES = {10: 25, 50: 20, 100: 16, 250: 16, 500: 9}  # frames a second on the SGI O2 of the notes, by exponent


def median_times(ways: Mapping[str, Callable[[], None]]) -> dict[str, float]:
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
    last = {"texture": env_map.texture, "mip_level": env_map.texture.mip_level_count - 1}
    device.queue.read_texture(last, {"bytes_per_row": 256, "rows_per_image": 1}, (1, 1, 1))
    return env_map


def error(env_map: EnvMapTexture, level: int, source: EnvImage, kernel: Kernel) -> float:
    """See the module."""
    kind, size = env_map.parameterization, env_map.size >> level
    weight = kind.texel_solid_angle(size).ravel()
    some = np.random.default_rng(0).choice(len(weight), CHECKED, p=weight / weight.sum())
    direction = kind.texel_directions(size)[0].reshape(-1, 3)[some]
    expected = filtered_reference(source, kernel, direction)
    texels = env_map.read(level).texels.reshape(-1, 4)[some, :3].astype(float)
    return float(np.abs(texels - expected).sum() / expected.sum())


def importance_samples(alpha: float) -> LobeTaps:
    """Hammersley's points; a sample's texel is as large as the solid angle that it stands for."""
    u = (np.arange(SAMPLES) + 0.5) / SAMPLES
    v = np.array([int(f"{k:05b}"[::-1], 2) / SAMPLES for k in range(SAMPLES)])
    n_dot_h = np.sqrt((1.0 - u) / (1.0 + (alpha * alpha - 1.0) * u))
    theta, phi = 2.0 * np.arccos(n_dot_h), 2.0 * np.pi * v
    direction = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], -1)
    above = direction[:, 2] > 0.0
    edge = np.sqrt(4.0 / (SAMPLES * d_ggx(n_dot_h, alpha)))
    weight = direction[above, 2]
    return LobeTaps(direction[above], 0.6 * edge[above], weight / weight.sum())  # blur of a texel: `probe_filter`


def environment(path: str | None, to: Parameterization, rows: int) -> EnvImage:
    """In ``rows`` rows, in what half floats can hold."""
    image = labelled_court(rows) if path is None else read_env_image(path)
    texels = np.clip(resample(image, to, rows).texels, 0.0, 65504.0)
    return EnvImage(to, texels.astype(np.float16))


def main() -> None:
    path = sys.argv[1] if len(sys.argv) > 1 else None
    rows = int(sys.argv[2]) if len(sys.argv) > 2 else 512
    device = shared_device()
    paraboloid, cube = environment(path, DualParaboloid(), rows), environment(path, CUBE, rows // 2)
    source, cube_source = upload_env_map(device, [paraboloid]), upload_env_map(device, [cube])
    renderer = EnvMapRenderer(sphere_mesh())
    camera = Camera((0.0, 0.0, 4.0), (0.0, 0.0, 0.0))
    hardware, probe = PhongParaboloidFilter(device, rows), ProbeFilter(device, rows // 2)

    def by_paraboloid(exponent: int) -> EnvMapTexture:
        return submitted(device, lambda encoder: hardware.refilter(encoder, source, PhongKernel(exponent)))

    def by_probe() -> EnvMapTexture:
        return submitted(device, lambda encoder: probe.refilter(encoder, cube_source))

    ways: dict[str, Callable[[], object]] = {
        "plain": lambda: renderer.picture(cube_source, camera, samples=1, backdrop=False),
        **{str(each): lambda each=each: by_paraboloid(each) for each in NOTES},
        "probe": by_probe,
    }
    times = median_times(ways)
    plain = times["plain"]
    print(f"{adapter_name(device)}\nplain lookup: {plain:.1f} ms a frame\n")

    print(
        f"Dual paraboloids of {rows} rows, Phong\n{'exponent':>8s}{'filter sizes':>14s}{'shrink factors':>16s}", end=""
    )
    print(f"{'ms':>8s}{'plain lookups':>15s}{'per second':>12s}{'notes':>7s}{'error':>8s}")
    for exponent, rate in NOTES.items():
        small, large = plane_filters(PhongKernel(exponent), rows)
        sizes, factors = f"{small.size}, {large.size}", f"{1 << small.shrink_level}, {1 << large.shrink_level}"
        took, off = times[str(exponent)], error(by_paraboloid(exponent), 0, paraboloid, PhongKernel(exponent))
        speed = f"{took:8.1f}{took / plain:15.2f}{1000 / took:12.0f}{rate:7d}"
        print(f"{exponent:8d}{sizes:>14s}{factors:>16s}{speed}{off:8.3f}")

    kernels = ggx_kernels(rows // 2)
    ours = [error(by_probe(), level, cube, kernel) for level, kernel in enumerate(kernels, start=1)]
    taps = [len(lobe_taps(kernel).weight) for kernel in kernels]
    for level, kernel in enumerate(kernels, start=1):
        probe.set_lobe(level, importance_samples(kernel.alpha))
    theirs = [error(by_probe(), level, cube, kernel) for level, kernel in enumerate(kernels, start=1)]
    print(f"\nCube of {rows // 2} rows, GGX: {times['probe']:.1f} ms, {times['probe'] / plain:.2f} plain lookups")
    samples = f"{SAMPLES} importance samples"
    print(f"{'level':>5s}{'rows':>6s}{'alpha':>8s}{'taps':>6s}{'error':>8s}{samples:>24s}{'ratio':>8s}")
    for level, kernel in enumerate(kernels, start=1):
        error_ours, error_theirs = ours[level - 1], theirs[level - 1]
        figures = f"{error_ours:8.3f}{error_theirs:24.3f}{error_theirs / error_ours:8.1f}"
        print(f"{level:5d}{rows // 2 >> level:6d}{kernel.alpha:8.3f}{taps[level - 1]:6d}{figures}")
    print(f"{'all':>5s}{'':20s}{np.mean(ours):8.3f}{np.mean(theirs):24.3f}{np.mean(theirs) / np.mean(ours):8.1f}")


if __name__ == "__main__":
    main()
