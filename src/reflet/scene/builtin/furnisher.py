"""Gathers solids and the pictures they wear into parts of a scene."""

import numpy as np
from jaxtyping import Float

from reflet.scene.builtin.atlas import pack
from reflet.scene.builtin.room_pictures import Picture
from reflet.scene.builtin.solids import Solid, Vec3, join
from reflet.scene.material import CLAMPS, Material, Texture
from reflet.scene.meshes.corners import weld
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.scene import Part

_ATLAS_WIDTH = 2048


class Furnisher:
    """One diffuse part in the making."""

    def __init__(self) -> None:
        self._tiles: list[np.ndarray] = []
        self._solids: list[Solid] = []

    def tile(self, picture: Picture) -> int:
        """The number of a picture in the atlas to come: what solids call their tile."""
        self._tiles.append(np.rint(np.clip(picture, 0.0, 1.0) * 255.0).astype(np.uint8))
        return len(self._tiles) - 1

    def add(self, *solids: Solid) -> None:
        """Puts solids where they say."""
        self._solids.extend(solids)

    def part(self, name: str) -> Part:
        """Everything, as one mesh with one texture."""
        atlas, rectangles = pack(self._tiles, _ATLAS_WIDTH)
        solid = join(self._solids)
        rectangle = rectangles[solid.tile]
        mesh = _mesh(solid, rectangle[:, :2] + solid.uv * rectangle[:, 2:])
        return Part(name, mesh, Material(name, metallic=0.0, base_color_texture_srgb=Texture(atlas, CLAMPS)))


def emitter(name: str, solid: Solid, radiance: Vec3) -> Part:
    """A black part that gives light."""
    return Part(name, _mesh(solid), Material(name, base_color=(0.0, 0.0, 0.0), metallic=0.0, emission=radiance))


def _mesh(solid: Solid, uv: Float[np.ndarray, "corners 2"] | None = None) -> Mesh:
    return weld(solid.corners, solid.normals, uv)
