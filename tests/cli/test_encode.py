"""PEMs written again, coded or plain, by the command line, which says what they take."""

from pathlib import Path

import numpy as np
import pytest
from small_pem import small_pem
from verbs import reflet, refused

from reflet.pem.container import open_pem, save_pem


def test_a_pem_is_written_again_by_another_codec(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    save_pem(tmp_path / "plain", small_pem(size=64), codec="none")
    assert reflet("encode", tmp_path / "plain", "-o", tmp_path / "small") == 0
    assert reflet("encode", tmp_path / "small", "--codec", "none", "-o", tmp_path / "again") == 0
    said = capsys.readouterr().out
    sizes = {
        name: sum(path.stat().st_size for path in (tmp_path / name).rglob("*") if path.is_file())
        for name in ("plain", "small", "again")
    }
    assert f"small takes {sizes['small'] / 1e6:.2f} MB" in said and sizes["small"] < sizes["plain"] / 5
    maps = [open_pem(tmp_path / name).maps[1][0].texels for name in ("small", "again")]
    np.testing.assert_array_equal(*maps)

    assert reflet("info", tmp_path / "small") == 0
    told = capsys.readouterr().out
    assert "av1" in told and "maps of viewpoints" in told and f"{sizes['small'] / 1e6:.3f} MB" in told
    assert reflet("info", tmp_path / "plain" / "scene.gltf") == 0
    assert "none" in capsys.readouterr().out
    assert "already holds a bake" in refused(capsys, "encode", tmp_path / "plain", "-o", tmp_path / "small")
    assert "does not exist" in refused(capsys, "encode", tmp_path / "nowhere", "-o", tmp_path / "out")
    assert not (tmp_path / "out").exists()
