"""What the web part shares with Python: the shaders' text, the table of sub-samples, the glTF file."""

import json
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from small_pem import small_pem

from reflet.pem.container import save_pem
from reflet.scene.sample_pattern import PATTERN
from reflet.shaders.link import link

WEB = Path(__file__).parents[2] / "web"


@pytest.fixture(scope="module")
def node():
    """Runs a script of web/test and gives what it printed."""
    if not shutil.which("node") or not (WEB / "node_modules").exists():
        pytest.skip("needs Node.js and its packages; run: make web")

    def run(script, *arguments):
        command = ["node", f"test/{script}", *map(str, arguments)]
        done = subprocess.run(command, cwd=WEB, capture_output=True, text=True, timeout=120, check=False)
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

    return run


def test_both_linkers_give_the_same_bytes(node):
    programs = ("picture", "backdrop", "accumulate", "display", "map_view", "mipmap", "probe")
    linked = node("link.mjs", *programs)
    assert {program: link(f"{program}.wgsl") for program in programs} == linked
    assert "#import" not in re.sub(r"//.*", "", linked["picture"])


def test_sub_samples_are_those_of_the_table():
    text = (WEB / "src/gpu/layouts.ts").read_text()
    table = re.search(r"const PATTERN = \[(.*?)\] as const", text, re.DOTALL)
    numbers = np.array(re.findall(r"\[(\d+), (\d+)\]", table[1]), float)
    np.testing.assert_array_equal(numbers / 32, PATTERN)


def test_gltf_validator_finds_no_error(node, tmp_path):
    save_pem(tmp_path / "pem", small_pem())
    issues = node("validate.mjs", tmp_path / "pem/scene.gltf")
    assert (issues["numErrors"], issues["numWarnings"]) == (0, 0), issues["messages"]
    # What it does say: it does not know our extension, and tangents and uv stand where no texture needs them.
    said = {message["code"] for message in issues["messages"]}
    assert said == {"UNSUPPORTED_EXTENSION", "UNUSED_MESH_TANGENT", "UNUSED_OBJECT"}


def test_the_lock_names_no_registry():
    lock = json.loads((WEB / "package-lock.json").read_text())
    assert all("resolved" not in package for package in lock["packages"].values())
    assert all("integrity" in package for name, package in lock["packages"].items() if name)
