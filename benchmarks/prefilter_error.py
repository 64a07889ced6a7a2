"""Errors of prefiltered maps at default settings, against brute force, as a table.

`python benchmarks/prefilter_error.py [ENV] [--texels N] [--size N]`; by default kloppenheim_05_1k.hdr, whose sun holds
65 % of all light in 0.01 % of its texels. Maps are cubes of 128² texels a face, as `reflet prefilter --size 128` makes
them; of each, N texels chosen at random are held against `filtered_reference`, the float64 sum over all texels of the
environment. An error is |map/reference - 1|, of all three channels; "mean" is over texels, "most" the worst of them.
"furnace" is the largest deviation of a constant environment's map, over all parameterizations, of 24 and of 100 rows
filtered to maps of 1, 7 and 32 rows. "linear" is that of L = 1 + ½ω_z (cube of 128 rows) from 1 + ½·m·r_z, m being the
kernel's first moment: 2/3 for diffuse, (N + 1)/(N + 2) for Phong, by quadrature for the others.

A second table is "linear" of environments in each parameterization, with slopes along x, y and z, the largest error in
2000 directions. Of a gazing ball of R rows those within 4/√R rad of -z, which it shows in its last texel, are left out;
a row of its own has all.
"""

import argparse
from pathlib import Path

import numpy as np

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS
from reflet.envmap.parameterizations.cube import CUBE
from reflet.files.env_image_file import read_env_image
from reflet.pipelines.prefilter import lobe
from reflet.reflectance.brdfs.kernel import Kernel
from reflet.reflectance.brdfs.quadrature import filtered_reference
from reflet.reflectance.prefilter.prefilter import Prefilter, prefiltered

KLOPPENHEIM = Path(__file__).parents[2] / "shared" / "data" / "hdr" / "kloppenheim_05_1k.hdr"
BRDFS = (
    "diffuse",
    *(f"phong:{n}" for n in (1, 10, 50, 200, 1000)),
    *(f"ggx:{r}" for r in (0.134, 0.25, 0.5, 0.75, 1.0)),
    *(f"sheen:{r}" for r in (0.3, 0.6)),
)
NARROW = ("phong:10", "phong:100", "phong:1000", "ggx:0.25", "ggx:0.1")


def first_moment(kernel: Kernel) -> float:
    """∫ k·cos θ dω, with s = u⁴ to see narrow lobes: dω = 4π ds."""
    u = (np.arange(1 << 20) + 0.5) / (1 << 20)
    s = u**4
    weight = 4.0 * np.pi * kernel.density(s) * 4.0 * u**3 / (1 << 20)
    return float(weight @ (1.0 - 2.0 * s) / weight.sum())


def furnace(kernel: Kernel) -> float:
    """The largest relative deviation in a white furnace."""
    worst = 0.0
    for source in PARAMETERIZATIONS.values():
        for size in (24, 100):
            environment = Prefilter(EnvImage(source, np.full((*source.shape(size), 3), 0.7, np.float32)))
            for to in (source, CUBE):
                for rows in (1, 7, 32):
                    worst = max(worst, float(np.abs(environment.map(kernel, to, rows).texels / 0.7 - 1.0).max()))
    return worst


def of_sources() -> None:
    """Prints the second table."""
    direction = np.random.default_rng(0).normal(size=(2000, 3))
    direction /= np.linalg.norm(direction, axis=-1, keepdims=True)
    kernels = [kernel for kernel in (lobe(brdf).kernel for brdf in NARROW) if kernel is not None]
    expected = [1.0 + 0.5 * first_moment(kernel) * direction for kernel in kernels]
    print(f"\n| source | rows | {' | '.join(f'`{brdf}`' for brdf in NARROW)} |\n|---|---|" + "---|" * len(NARROW))
    for name, source in PARAMETERIZATIONS.items():
        for rows in (128, 256, 512):
            texels = (1.0 + 0.5 * source.texel_directions(rows)[0]).astype(np.float32)
            environment = Prefilter(EnvImage(source, texels))
            found = [environment.radiance(kernel, direction) for kernel in kernels]
            error = np.array([np.abs(a / b - 1.0).max(-1) for a, b in zip(found, expected, strict=True)])
            resolved = direction[:, 2] > (-np.cos(4.0 / np.sqrt(rows)) if name == "gazing_ball" else -2.0)
            for what, worst in ((name, error[:, resolved].max(1)), ("the same, all of it", error.max(1))):
                if what == name or not resolved.all():
                    print(f"| {what} | {rows} | " + " | ".join(f"{100.0 * each:.2g} %" for each in worst) + " |")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("env", nargs="?", type=Path, default=KLOPPENHEIM)
    parser.add_argument("--texels", type=int, default=100)
    parser.add_argument("--size", type=int, default=128)
    asked = parser.parse_args()
    image = read_env_image(asked.env)
    environment = Prefilter(image)
    direction = CUBE.texel_directions(asked.size)[0].reshape(-1, 3)
    some = np.random.default_rng(0).choice(len(direction), asked.texels, replace=False)
    z = CUBE.texel_directions(128)[0][..., 2:]
    linear = EnvImage(CUBE, (1.0 + 0.5 * z).astype(np.float32))
    print(f"{asked.env.name}, {asked.size}² a face, {asked.texels} texels\n")
    print("| BRDF | mean | most | furnace | linear |\n|---|---|---|---|---|")
    for brdf in BRDFS:
        kernel = lobe(brdf).kernel
        assert kernel is not None
        seen = environment.map(kernel, CUBE, asked.size).texels.reshape(-1, 3)[some]
        error = np.abs(seen / filtered_reference(image, kernel, direction[some]) - 1.0)
        expected = 1.0 + 0.5 * first_moment(kernel) * CUBE.texel_directions(32)[0][..., 2:]
        of_linear = np.abs(prefiltered(linear, kernel, CUBE, 32).texels / expected - 1.0).max()
        shares = (error.mean(), error.max(), furnace(kernel), of_linear)
        print(f"| `{brdf}` | " + " | ".join(f"{100.0 * share:.2g} %" for share in shares) + " |", flush=True)
    of_sources()


if __name__ == "__main__":
    main()
