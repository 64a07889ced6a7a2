"""The same seed gives the same bytes, in this process and in any other."""

import hashlib
import subprocess
import sys
from pathlib import Path

import numpy as np
from trace_scenes import CHROME, camera, quad, room, scene, sphere

from reflet.scene.material import Material
from reflet.scene.scene import Part
from reflet.trace.device_scene import DeviceScene
from reflet.trace.layers import Shells
from reflet.trace.light.irradiance import trace_irradiance
from reflet.trace.tracer import Tracer
from reflet.trace.variant import use_variant


def digest(seed: int) -> str:
    """Of everything that is traced: diffuse light, layers, visibility and a probe."""
    grey = Material("grey", base_color=(0.5, 0.4, 0.3), metallic=0.0)
    lamp = Material("lamp", base_color=(0, 0, 0), metallic=0.0, emission=(5.0, 5.0, 5.0))
    parts = [
        Part("room", room(2.0), grey),
        Part("lamp", quad((-0.5, 1.9, -0.5), (1, 0, 0), (0, 0, 1)), lamp),
        Part("ball", sphere((-0.5, 0, 0), 0.6, rows=12), CHROME, True),
        Part("other", sphere((0.7, 0, 0), 0.5, rows=12), CHROME, True),
    ]
    what = scene(parts, [(2,), (3,)])
    use_variant()
    tracer = Tracer(what, irradiance=trace_irradiance(DeviceScene(what), spp=16, budget=2000))
    view = tracer.view(camera((0.0, 0.4, 1.9), size=24), spp=8, seed=seed, surroundings=True)
    probe = tracer.probe(0, Shells((-0.5, 0.0, 0.0)), size=8, spp=4)
    total = hashlib.blake2b()
    for record in (tracer.irradiance, view.layers, view.visibility, probe):
        for value in vars(record).values():
            if isinstance(value, np.ndarray):
                total.update(np.ascontiguousarray(value).tobytes())
    return total.hexdigest()


def test_same_seed_same_bytes_in_any_process() -> None:
    here = digest(3)
    assert digest(3) == here
    assert digest(4) != here
    program = "import test_determinism; print(test_determinism.digest(3))"
    there = subprocess.run(
        [sys.executable, "-c", program], cwd=Path(__file__).parent, capture_output=True, text=True, check=True
    )
    assert there.stdout.strip() == here
