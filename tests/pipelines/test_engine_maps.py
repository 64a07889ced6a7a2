"""Our files for Filament beside those of its own tool, from the same environment."""

import itertools
from pathlib import Path

import numpy as np
import pytest

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.cube import CUBE
from reflet.files.env_image_file import read_env_image, read_levels
from reflet.files.textures.filament import quarter_turned
from reflet.files.textures.ktx1 import read_ktx1_texture
from reflet.pipelines.engine_maps import engine_maps
from reflet.reflectance.brdfs.ggx import GgxKernel
from reflet.reflectance.brdfs.quadrature import filtered_reference
from reflet.reflectance.prefilter.ggx_levels import FILAMENT

PEER = Path(__file__).parents[2].parent / "shared" / "data" / "peers" / "cmgen_neutral"

pytestmark = pytest.mark.skipif(not PEER.is_dir(), reason="the peer's files are not here")


@pytest.fixture(scope="module")
def ours(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return engine_maps(PEER / "neutral.hdr", tmp_path_factory.mktemp("engine") / "neutral", "filament")[0]


def log_difference(ours: EnvImage, theirs: EnvImage, turn: np.ndarray) -> float:
    """Mean over texels of |ln ours(turn·ω) - ln theirs(ω)|; turns of the cube take texel centres to texel centres."""
    size = ours.size
    face, uv = CUBE.uv_from_direction(CUBE.texel_directions(size)[0] @ turn.T)
    column, row = (np.clip((uv[..., k] * size).astype(int), 0, size - 1) for k in (0, 1))
    return float(np.abs(np.log(ours.texels[face, row, column] / theirs.texels)).mean())


def test_of_all_48_orientations_it_is_the_peers(ours: Path) -> None:
    ours_64, theirs_64 = read_levels(ours)[2], read_levels(PEER / "neutral_ibl.ktx")[2]
    differences = {}
    for axes in itertools.permutations(range(3)):
        for signs in itertools.product((1.0, -1.0), repeat=3):
            turn = np.zeros((3, 3))
            turn[range(3), axes] = signs
            differences[axes, signs] = log_difference(ours_64, theirs_64, turn)
    assert len(differences) == 48
    right = differences.pop(((0, 1, 2), (1.0, 1.0, 1.0)))
    # 0.065 by the peer's own error; the studio's next best likeness, half a turn with both sides swapped, is at 0.3.
    assert right < 0.1
    assert min(differences.values()) > 2.0 * right


def test_the_skybox_too(ours: Path) -> None:
    mine = read_levels(ours.with_name("neutral_skybox.ktx"))[0]
    theirs = read_levels(PEER / "neutral_skybox.ktx")[0]
    half_turn = np.diag([-1.0, 1.0, -1.0])
    right = log_difference(mine, theirs, np.eye(3))
    # The peer's is blurred for looks.
    assert right < 0.2 < log_difference(mine, theirs, half_turn)


def test_harmonics_are_the_peers_within_five_per_cent(ours: Path) -> None:
    mine, theirs = (
        np.array(read_ktx1_texture(path).metadata["sh"].split(), float).reshape(9, 3)
        for path in (ours, PEER / "neutral_ibl.ktx")
    )
    # Measured 3.7 %, nearly all of it that the peer damps its bands by 4 % and 15 % against ringing.
    assert np.linalg.norm(mine - theirs) < 0.05 * np.linalg.norm(theirs)
    damping = np.sinc(np.array([0, 1, 1, 1, 2, 2, 2, 2, 2]) / 12.92)[:, None] ** 4
    assert np.linalg.norm(mine * damping - theirs) < 0.01 * np.linalg.norm(theirs)


@pytest.mark.parametrize("level", [1, 2, 3, 4])
def test_nearer_to_brute_force_than_the_peer(ours: Path, level: int) -> None:
    mine, theirs = read_levels(ours)[level], read_levels(PEER / "neutral_ibl.ktx")[level]
    direction = CUBE.texel_directions(mine.size)[0].reshape(-1, 3)
    some = np.random.default_rng(level).choice(len(direction), 40, replace=False)
    image = quarter_turned(read_env_image(PEER / "neutral.hdr"))
    kernel = GgxKernel(FILAMENT.roughness_of_level(level, 5) ** 2)
    reference = filtered_reference(image, kernel, direction[some])
    error, peers = (np.abs(m.texels.reshape(-1, 3)[some] / reference - 1.0).mean() for m in (mine, theirs))
    # R11G11B10F rounds by 1/256 on average (blue: 1/128); the peer measures 4.7 % to 7.5 %.
    assert error < 0.008
    assert peers > 4.0 * error
