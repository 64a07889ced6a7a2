"""Frames leave nothing behind: programs whose loops stand in branches leak on llvmpipe, gigabytes in a comparison."""

import runpy
from dataclasses import replace
from pathlib import Path

import pytest

from reflet.render.playback.renderer import Renderer
from reflet.scene.bvh.build import build_bvh
from reflet.scene.meshes.primitives import torus_mesh

BENCHMARK = runpy.run_path(str(Path(__file__).parents[2] / "benchmarks" / "frame_time.py"))
FRAMES, SIZE = 10, 256


def resident_mb() -> float:
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith("VmRSS")) / 1e3


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="resident memory is read where Linux tells it")
@pytest.mark.parametrize("exact", [True, False], ids=["exact", "fast"])
@pytest.mark.parametrize("traced", [True, False], ids=["traced", "layered"])
def test_frames_take_no_memory(traced: bool, exact: bool) -> None:
    pem = BENCHMARK["layered_pem"](BENCHMARK["mirrors"]([torus_mesh(0.3, 0.2, around=40, sides=20)]), 16)
    if traced:
        tree = build_bvh(pem.scene, pem.on_hull)
        pem = replace(BENCHMARK["two_shells"](pem), most_hits=2, bvh=tree)
    camera = replace(pem.space.orbit, image_size=SIZE).camera({"azimuth_deg": 61.0})
    renderer = Renderer(pem)
    for _ in range(3):  # what is allocated once
        renderer.frame(camera, samples=4, exact=exact)
    before = resident_mb()
    for _ in range(FRAMES):
        renderer.frame(camera, samples=4, exact=exact)
    # One leak was of 8 to 40 MB in frames of this size; allocators keep a few of what was freed.
    assert resident_mb() - before < 10.0
