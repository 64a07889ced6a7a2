"""One small picture that many tests share."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))

from synthetic import Picture, mirror_scene, picture, sphere_mesh


@pytest.fixture(scope="session")
def sphere_picture() -> Picture:
    """A mirror sphere of radius 0.3 around the origin, seen from near, 40² pixels of 16 sub-samples."""
    return picture(mirror_scene(sphere_mesh(0.3, 16)), (0.8, 0.4, 0.7), 40)
