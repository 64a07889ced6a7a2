"""The plainest shader, which benchmarks compare frames with, stands in for the program of pictures as built now."""

import runpy
from dataclasses import replace
from pathlib import Path

import numpy as np

from reflet.render.playback.renderer import Renderer
from reflet.scene.meshes.primitives import sphere_mesh
from reflet.scene.views.camera import Camera

BENCHMARK = runpy.run_path(str(Path(__file__).parents[2] / "benchmarks" / "frame_time.py"))


def test_a_ball_shows_its_distant_map():
    pem = BENCHMARK["layered_pem"](BENCHMARK["mirrors"]([sphere_mesh(1.0, around=16)]), size=8)
    distant, local = pem.maps[0]
    even = replace(distant, texels=np.full_like(distant.texels, 0.25))
    camera = Camera((0.0, 0.0, 4.0), (0.0, 0.0, 0.0), fov_deg=40.0, width=16, height=16)
    shown = BENCHMARK["plain_pem"](replace(pem, maps=[(even, local)] * 2))
    picture = BENCHMARK["plain_frame"](Renderer(shown), camera, 4)
    assert np.array_equal(picture[8, 8], (0.25, 0.25, 0.25, 1.0))  # a half float, unmixed
    assert not picture[0, 0].any()
