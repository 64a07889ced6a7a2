"""Surfaces whose shading normals face away from the viewer, as strong normal maps make them: what they show of a white
room is told by the normal that mirrors the viewer along the ray that is bent above the surface, not by their own."""

from dataclasses import replace

import numpy as np
import pytest
from test_gloss import furnace

from reflet.reflectance.brdfs.dfg import dfg
from reflet.render.playback.renderer import Renderer
from reflet.scene.material import Material
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.surfaces.irradiance import IrradianceMap
from reflet.scene.views.camera import Camera

ELEVATION, TILT = np.radians(8.0), np.radians(20.0)
BLACK = Material("paint", (0.0,) * 3, 0.0, 0.5)


def floor_shown(material: Material, most_hits: int = 0) -> float:
    """Radiance of a floor in white light, seen from 8° above, whose normals lean 20° away."""
    positions = np.array([[-1, 0, -1], [-1, 0, 1], [1, 0, 1], [1, 0, -1]], np.float32)
    normals = np.tile(np.float32([np.sin(TILT), np.cos(TILT), 0.0]), (4, 1))
    pem = furnace(material, most_hits=most_hits)
    mesh = Mesh(positions, normals, np.array([[0, 1, 2], [0, 2, 3]], np.uint32))
    (part,) = pem.scene.parts
    unlit = IrradianceMap(np.zeros(2, np.uint32), np.arange(2, dtype=np.uint32) * 3, np.ones((6, 3), np.float32))
    scene = replace(pem.scene, parts=(replace(part, mesh=mesh),))
    pem = replace(pem, scene=scene, irradiance=unlit, on_hull=np.zeros(2, bool))
    eye = (-2.0 * float(np.cos(ELEVATION)), 2.0 * float(np.sin(ELEVATION)), 0.0)
    camera = Camera(eye, (0.0, 0.0, 0.0), fov_deg=0.1, width=2, height=2)
    return float(Renderer(pem).frame(camera, samples=1, what="object")[..., :3].mean())


def bent_cosine() -> float:
    """That between the viewer and the half vector of viewer and bent ray."""
    d, n = np.array([np.cos(ELEVATION), -np.sin(ELEVATION)]), np.array([np.sin(TILT), np.cos(TILT)])
    r = d - 2.0 * (d @ n) * n
    r[1] = 0.001
    r /= np.linalg.norm(r)
    half = (r - d) / np.linalg.norm(r - d)
    assert d @ n > 0.0  # the normal faces away
    return float(-d @ half)


@pytest.mark.parametrize("most_hits", [0, 3])
@pytest.mark.parametrize("roughness", [0.0, 0.5])
@pytest.mark.parametrize("coated", [False, True])
def test_normals_that_face_away_are_not_white(coated: bool, roughness: float, most_hits: int) -> None:
    material, cosine = replace(BLACK, perceptual_roughness=roughness), bent_cosine()
    a, b = _split(cosine, roughness)
    wanted = (0.04 * a + b) * (1.0 + 0.04 * (1.0 / (a + b) - 1.0))
    if coated:
        material = replace(BLACK, clearcoat=1.0, clearcoat_roughness=roughness)
        fresnel, (below_a, below_b) = 0.04 + 0.96 * (1.0 - cosine) ** 5, _split(cosine, 0.5)
        below = (0.04 * below_a + below_b) * (1.0 + 0.04 * (1.0 / (below_a + below_b) - 1.0))
        wanted = (1.0 - fresnel) * below + fresnel * (a + b)
    # of the table, linear between its columns, as in test_gloss
    assert floor_shown(material, most_hits) == pytest.approx(wanted, rel=1e-2)


def _split(cosine: float, roughness: float) -> tuple[float, float]:
    if roughness == 0.0:
        grazing = (1.0 - cosine) ** 5
        return 1.0 - grazing, grazing
    a, b = dfg(np.array([cosine]), roughness**2, 1 << 14)[0]
    return float(a), float(b)
