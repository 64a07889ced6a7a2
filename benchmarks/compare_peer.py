"""Our prefiltered maps and a peer's, from the same environment, both against brute force.

`python benchmarks/compare_peer.py [FOLDER] [--texels N]`; FOLDER holds neutral.hdr and what Filament's cmgen makes of
it by default: neutral_ibl.ktx (GGX, 256², 5 levels, R11G11B10F) and its harmonics. Ours is what `reflet prefilter
--engine filament` writes: the same format, orientation and roughness per level (lod = r·(2 - r)·4, by cmgen's source),
so both pay for 5 or 6 bits of mantissa; "unpacked" is ours before that.

Errors are means over N texels a level of |map/reference - 1|. The reference of level 0, a mirror's, is the interpolated
environment's mean over the texel, from 24² points; of the others `filtered_reference` over all texels of neutral.hdr.
"light" is the mean of map over that of the reference. "best_roughness" is the roughness, in steps of 0.01, whose map is
closest to the peer's: evidence that its level is filtered with what we take it to be.

Harmonics: |ours - theirs|/|theirs| over the nine coefficients, and again after damping ours as cmgen does by default
(sinc(l/12.92)⁴, the widest of its windows).
"""

import argparse
import json
import tempfile
from pathlib import Path

import numpy as np

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.cube import CUBE, direction_from_face
from reflet.envmap.resampling.resample import radiance_at
from reflet.files.env_image_file import read_env_image, read_levels
from reflet.files.textures.filament import quarter_turned
from reflet.files.textures.ktx1 import read_ktx1_texture
from reflet.pipelines.engine_maps import engine_maps
from reflet.reflectance.brdfs.ggx import GgxKernel
from reflet.reflectance.brdfs.quadrature import filtered_reference
from reflet.reflectance.prefilter.ggx_levels import FILAMENT, ggx_levels
from reflet.reflectance.prefilter.prefilter import Prefilter

PEER = Path(__file__).parents[2] / "shared" / "data" / "peers" / "cmgen_neutral"
ACROSS = 24  # points of a texel for the mirror's reference


def harmonics_of(path: Path) -> np.ndarray:
    """Coefficients of one of Filament's KTX files, (9, 3)."""
    return np.array(read_ktx1_texture(path).metadata["sh"].split(), float).reshape(9, 3)


def texel_means(image: EnvImage, size: int, texel: np.ndarray) -> np.ndarray:
    """The interpolated environment's means over texels of a cube."""
    face, row, column = np.unravel_index(texel, (6, size, size))
    inside = (np.arange(ACROSS) + 0.5) / ACROSS
    s = (2.0 * (column[:, None, None] + inside[None, None, :]) / size - 1.0) + 0.0 * inside[None, :, None]
    t = (2.0 * (row[:, None, None] + inside[None, :, None]) / size - 1.0) + 0.0 * inside[None, None, :]
    direction = direction_from_face(np.broadcast_to(face[:, None, None], s.shape), s, t)
    weight = (1.0 + s * s + t * t) ** -1.5
    radiance = radiance_at(image, direction)
    return np.einsum("nij,nijc->nc", weight, radiance) / weight.sum((1, 2))[:, None]


def level_row(image: EnvImage, level: int, maps: dict[str, EnvImage], texels: int) -> dict[str, object]:
    """Errors of one level."""
    size, roughness = maps["ours"].size, FILAMENT.roughness_of_level(level, 5)
    random = np.random.default_rng(level)
    some = random.choice(6 * size * size, min(texels, 6 * size * size), replace=False)
    direction = CUBE.texel_directions(size)[0].reshape(-1, 3)[some]
    if level == 0:
        reference = texel_means(image, size, some)
    else:
        reference = filtered_reference(image, GgxKernel(roughness**2), direction)
    row: dict[str, object] = {"level": level, "size": size, "roughness": round(roughness, 4)}
    for name, one in maps.items():
        seen = one.texels.reshape(-1, 3)[some]
        row[name] = round(float(np.abs(seen / reference - 1.0).mean()), 5)
        row[f"light_{name}"] = round(float(seen.mean() / reference.mean()), 4)
    if level > 0:
        environment, theirs = Prefilter(image), maps["peer"].texels.reshape(-1, 3)[some]
        trial = np.arange(max(roughness - 0.1, 0.03), min(roughness + 0.1, 1.0) + 1e-6, 0.01)
        apart = [np.abs(environment.radiance(GgxKernel(r**2), direction) / theirs - 1.0).mean() for r in trial]
        row["best_roughness"] = round(float(trial[int(np.argmin(apart))]), 2)
    return row


def compare(folder: Path, texels: int) -> dict[str, object]:
    """The whole comparison."""
    image = quarter_turned(read_env_image(folder / "neutral.hdr"))
    peer = read_levels(folder / "neutral_ibl.ktx")
    with tempfile.TemporaryDirectory() as scratch:
        ibl, _, _ = engine_maps(folder / "neutral.hdr", Path(scratch) / "neutral", "filament")
        packed, ours = read_levels(ibl), harmonics_of(ibl)
    unpacked = ggx_levels(image, CUBE, 256, scale=FILAMENT)
    theirs = harmonics_of(folder / "neutral_ibl.ktx")
    damped = ours * np.sinc(np.array([0, 1, 1, 1, 2, 2, 2, 2, 2]) / 12.92)[:, None] ** 4
    rows = [
        level_row(image, level, {"ours": packed[level], "unpacked": unpacked[level], "peer": peer[level]}, texels)
        for level in range(5)
    ]
    return {
        "levels": rows,
        "harmonics": {
            "difference": round(float(np.linalg.norm(ours - theirs) / np.linalg.norm(theirs)), 4),
            "difference_damped": round(float(np.linalg.norm(damped - theirs) / np.linalg.norm(theirs)), 4),
            "ours": np.round(ours[:, 0], 4).tolist(),
            "damped": np.round(damped[:, 0], 4).tolist(),
            "peer": np.round(theirs[:, 0], 4).tolist(),
        },
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", type=Path, default=PEER)
    parser.add_argument("--texels", type=int, default=300)
    asked = parser.parse_args()
    print(json.dumps(compare(asked.folder, asked.texels), indent=1))


if __name__ == "__main__":
    main()
