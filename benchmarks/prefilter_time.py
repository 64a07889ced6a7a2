"""Seconds to prefilter an environment for GGX, in one run with importance sampling in plain NumPy.

`python benchmarks/prefilter_time.py [ENV] [--size N] [--repeat N] [--most-samples N]`; without a file, a made-up sky of
1024×512 texels with a sun that gives two thirds of all light. The chain is `ggx_levels` of a cube map: level 0 a
mirror's, then 128², 64², … with the roughness of glTF viewers.

Importance sampling is done as engines do it: Hammersley points, half vectors by GGX's distribution with n = v = r,
trilinear lookups in the environment's mip levels by solid angle over density [Colbert07], weighted by n·l; vectorized
over texels, float32, one thread. Its number of samples is doubled until its error is as small as ours or
``--most-samples`` is reached ("as_good" says which). The error is the mean over texels of the relative difference to
brute force (`filtered_reference`), on 150 texels a level; NumPy's time is measured on 4096 texels a level and
multiplied. Ours is that of all. Processor seconds are printed beside wall seconds: other work on the machine hardly
changes them.
"""

import argparse
import json
import statistics
import time
from collections.abc import Callable

import numpy as np

from reflet.envmap.env_image import EnvImage
from reflet.envmap.mip_chain import MipChain
from reflet.envmap.parameterizations.by_name import parameterization
from reflet.envmap.parameterizations.cube import CUBE, face_from_direction
from reflet.envmap.resampling.mip_reduction import mip_levels_from_finest, pad
from reflet.envmap.resampling.resample import resample
from reflet.files.env_image_file import read_env_image
from reflet.reflectance.brdfs.ggx import GgxKernel, d_ggx
from reflet.reflectance.brdfs.quadrature import filtered_reference
from reflet.reflectance.prefilter.ggx_levels import LINEAR, ggx_levels

CHECKED, TIMED = 150, 4096  # texels of a level


def sky(size: int) -> EnvImage:
    """A bright horizon, noise as of leaves, and a sun of half a degree with two thirds of all light."""
    latlong = parameterization("latlong")
    direction, _ = latlong.texel_directions(size)
    noise = np.random.default_rng(0).random((1, size, 2 * size, 3))
    texels = np.exp(-4.0 * np.abs(direction[..., 1:2])) * (0.5 + noise)
    towards = np.array([0.4, 0.8, 0.447])
    sun = direction @ (towards / np.linalg.norm(towards)) > np.cos(np.deg2rad(0.25))
    solid_angle = latlong.texel_solid_angle(size)
    texels[sun] = 2.0 * (texels * solid_angle[..., None]).sum((0, 1, 2)) / solid_angle[sun].sum()
    return EnvImage(latlong, texels.astype(np.float32))


class Sampled:
    """Importance sampling with mip-filtered lookups."""

    def __init__(self, image: EnvImage, size: int) -> None:
        self.chain = MipChain(size)
        texels = mip_levels_from_finest(self.chain, resample(image, CUBE, size).texels)
        self.levels = [pad(self.chain, texels, level).astype(np.float32) for level in range(self.chain.level_count)]
        starts = np.cumsum([0] + [level.size // 3 for level in self.levels])
        self.starts, self.flat = starts[:-1], np.concatenate([level.reshape(-1, 3) for level in self.levels])

    def lookup(self, face: np.ndarray, s: np.ndarray, t: np.ndarray, level: np.ndarray) -> np.ndarray:
        """Bilinear on one level each."""
        size = self.chain.size >> level
        x, y = (0.5 + 0.5 * s) * size + 0.5, (0.5 + 0.5 * t) * size + 0.5  # in the padded face
        column, row = np.minimum(x.astype(np.int64), size), np.minimum(y.astype(np.int64), size)
        fx, fy = (x - column)[:, None], (y - row)[:, None]
        at = self.starts[level] + (face * (size + 2) + row) * (size + 2) + column
        below = at + size + 2
        upper = self.flat[at] * (1 - fx) + self.flat[at + 1] * fx
        return upper * (1 - fy) + (self.flat[below] * (1 - fx) + self.flat[below + 1] * fx) * fy

    def radiance(self, alpha: float, normal: np.ndarray, samples: int) -> np.ndarray:
        """The split sum's integral around normals."""
        normal = normal.astype(np.float32)
        up = np.where(np.abs(normal[:, 2:]) < 0.999, np.float32([0, 0, 1]), np.float32([1, 0, 0]))
        tangent = np.cross(up, normal)
        tangent /= np.linalg.norm(tangent, axis=-1, keepdims=True)
        bitangent = np.cross(normal, tangent)
        total, weights = np.zeros((len(normal), 3), np.float32), 0.0
        for k in range(samples):
            u, v = (k + 0.5) / samples, int(f"{k:032b}"[::-1], 2) / 2.0**32
            cos_h = np.sqrt((1.0 - u) / (1.0 + (alpha * alpha - 1.0) * u))
            n_dot_l = 2.0 * cos_h * cos_h - 1.0
            if n_dot_l <= 0.0:
                continue
            sine = np.sqrt(1.0 - n_dot_l * n_dot_l)
            l = (
                np.float32(sine * np.cos(2 * np.pi * v)) * tangent
                + np.float32(sine * np.sin(2 * np.pi * v)) * bitangent
                + np.float32(n_dot_l) * normal
            )
            face, s, t = face_from_direction(l)
            texel = 4.0 / self.chain.size**2 / (1.0 + s * s + t * t) ** 1.5
            sample = 4.0 / (samples * d_ggx(np.array(cos_h), alpha))
            lod = np.clip(0.5 * np.log2(sample / texel), 0.0, self.chain.level_count - 1.001).astype(np.float32)
            finer = lod.astype(np.int64)
            f = (lod - finer)[:, None]
            looked_up = self.lookup(face, s, t, finer) * (1 - f) + self.lookup(face, s, t, finer + 1) * f
            total += np.float32(n_dot_l) * looked_up
            weights += n_dot_l
        return total / np.float32(weights)


def timed(what: Callable[[], object], repeat: int) -> tuple[object, float, float]:
    """The result, and medians of wall and processor seconds."""
    wall, processor, result = [], [], None
    for _ in range(repeat):
        at, used = time.perf_counter(), time.process_time()
        result = what()
        wall.append(time.perf_counter() - at)
        processor.append(time.process_time() - used)
    return result, statistics.median(wall), statistics.median(processor)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("env", nargs="?")
    parser.add_argument("--size", type=int, default=256)
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--most-samples", type=int, default=1024)
    asked = parser.parse_args()
    image = read_env_image(asked.env) if asked.env else sky(512)
    random = np.random.default_rng(0)

    ggx_levels(image, CUBE, 32)  # compiles
    ours, wall, processor = timed(lambda: ggx_levels(image, CUBE, asked.size), asked.repeat)
    prepared, wall_prepared, processor_prepared = timed(lambda: Sampled(image, asked.size), 1)
    rows, wall_sampled, processor_sampled = [], wall_prepared, processor_prepared
    for level in range(1, len(ours)):
        alpha = LINEAR.roughness_of_level(level, len(ours)) ** 2
        direction = CUBE.texel_directions(ours[level].size)[0].reshape(-1, 3)
        some = random.choice(len(direction), min(CHECKED, len(direction)), replace=False)
        reference = filtered_reference(image, GgxKernel(alpha), direction[some])
        error = float(np.abs(ours[level].texels.reshape(-1, 3)[some] / reference - 1.0).mean())
        many = direction[random.choice(len(direction), min(TIMED, len(direction)), replace=False)]
        samples, theirs = 16, np.inf
        while theirs > error and samples < asked.most_samples:
            samples *= 2
            theirs = float(np.abs(prepared.radiance(alpha, direction[some], samples) / reference - 1.0).mean())
        _, level_wall, level_processor = timed(lambda a=alpha, m=many, n=samples: prepared.radiance(a, m, n), 1)
        wall_sampled += level_wall * len(direction) / len(many)
        processor_sampled += level_processor * len(direction) / len(many)
        rows.append(
            {
                "size": ours[level].size,
                "alpha": alpha,
                "error": round(error, 5),
                "samples": samples,
                "their_error": round(theirs, 5),
                "as_good": theirs <= error,
            }
        )
    print(
        json.dumps(
            {
                "seconds": round(wall, 3),
                "processor_seconds": round(processor, 3),
                "sampled_seconds": round(wall_sampled, 1),
                "sampled_processor_seconds": round(processor_sampled, 1),
                "times_faster": round(wall_sampled / wall, 1),
                "times_fewer_processor_seconds": round(processor_sampled / processor, 1),
                "levels": rows,
            },
            indent=1,
        )
    )


if __name__ == "__main__":
    main()
