"""Textures as the project's meshes wear them, as a texture of Mitsuba's, for the path traced reference."""

from functools import cache
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from jaxtyping import Float

from reflet.scene.material import REPEATS, WRAPS, Texture
from reflet.scene.meshes.mesh import Mesh


@cache
def _register(variant: str) -> None:
    class Placed(mi.Texture):  # type: ignore[name-defined, misc]
        """A repeating ``picture`` that goes on along u and v by ``wrap_u`` and ``wrap_v``, numbers in `WRAPS`, looked
        up by the mesh attribute ``coordinates`` if one is named; times the mesh's ``vertex_color`` if ``tinted``.

        Of one channel it is alpha, times ``vertex_alpha``: 0 or 1 by a ``cutoff``, if there is one."""

        def __init__(self, properties: "mi.Properties") -> None:
            super().__init__(properties)
            self.picture = properties["picture"]
            self.wraps = properties["wrap_u"], properties["wrap_v"]
            self.sizes = properties["width"], properties["height"]
            name = properties.get("coordinates", "")
            self.coordinates = mi.load_dict({"type": "mesh_attribute", "name": name}) if name else None
            tinted = properties.get("tinted", False)
            self.tint = mi.load_dict({"type": "mesh_attribute", "name": "vertex_color"}) if tinted else None
            self.fade = mi.load_dict({"type": "mesh_attribute", "name": "vertex_alpha"}) if tinted else None
            self.cutoff = properties.get("cutoff", -1.0)

        def eval(self, si, active=True):  # type: ignore[no-untyped-def]
            """The colour there."""
            value = self.picture.eval(self._placed(si, active), active)
            return value if self.tint is None else value * mi.Color3f(self.tint.eval_3(si, active))

        def eval_1(self, si, active=True):  # type: ignore[no-untyped-def]
            """The one channel there."""
            value = self.picture.eval_1(self._placed(si, active), active)
            if self.fade is not None:
                value *= self.fade.eval_1(si, active)
            return value if self.cutoff < 0.0 else dr.select(value >= self.cutoff, 1.0, 0.0)

        def eval_3(self, si, active=True):  # type: ignore[no-untyped-def]
            """The three channels there."""
            return self.picture.eval_3(self._placed(si, active), active)

        def mean(self) -> Any:
            """Of the picture."""
            return self.picture.mean()

        def _placed(self, si, active):  # type: ignore[no-untyped-def]
            uv = si.uv
            if self.coordinates is not None:
                uv = mi.Point2f(self.coordinates.eval_3(si, active).xy)
            placed = mi.SurfaceInteraction3f(si)
            placed.uv = mi.Point2f(*map(_within, uv, self.wraps, self.sizes))
            return placed

    mi.register_texture("reflet_placed", Placed)


def _within(coordinate, wrap: int, size: int):  # type: ignore[no-untyped-def]
    """Where a picture that repeats shows what one shows that wraps otherwise: no farther out than its outer texels'
    centres, beyond which they go on alike."""
    if WRAPS[wrap] == "repeat":
        return coordinate
    if WRAPS[wrap] == "mirror":
        coordinate = dr.abs(coordinate - 2.0 * dr.floor(0.5 * coordinate + 0.5))
    return dr.clip(coordinate, 0.5 / size, 1.0 - 0.5 / size)


def placed_texture(
    texture: Texture | None,
    linear: Float[np.ndarray, "height width channels"],
    mesh: Mesh,
    *,
    tinted: bool = False,
    cutoff: float | None = None,
) -> dict[str, Any]:
    """``linear`` values laid onto the mesh as ``texture`` is, times the mesh's colours if it is to be ``tinted``, or
    its alpha if they have one channel; that is 0 below a ``cutoff`` and 1 elsewhere, if there is one."""
    plain: dict[str, Any] = {
        "type": "bitmap",
        "data": mi.TensorXf(np.ascontiguousarray(linear, np.float32)),
        "raw": True,
        "wrap_mode": "repeat",
    }
    wraps, coordinates = (REPEATS, 0) if texture is None else (texture.wraps, texture.coordinates)
    tinted = tinted and mesh.colors is not None
    if wraps == REPEATS and coordinates == 0 and not tinted and cutoff is None:
        return plain
    _register(mi.variant())
    height, width = linear.shape[:2]
    return {
        "type": "reflet_placed",
        "picture": plain,
        "wrap_u": WRAPS.index(wraps[0]),
        "wrap_v": WRAPS.index(wraps[1]),
        "width": width,
        "height": height,
        "coordinates": attribute_name(coordinates),
        "tinted": tinted,
        "cutoff": -1.0 if cutoff is None else cutoff,
    }


def attribute_name(coordinates: int) -> str:
    """What a mesh attribute with texture coordinates number 1, 2, … is called; empty for number 0, the mesh's own."""
    return f"vertex_uv{coordinates}" if coordinates else ""


def add_attributes(shape: "mi.Mesh", mesh: Mesh) -> None:
    """What `placed_texture` reads of the mesh besides its own texture coordinates."""
    for number, uv in enumerate(mesh.more_uv, 1):
        shape.add_attribute(attribute_name(number), 3, np.pad(uv, ((0, 0), (0, 1))).astype(np.float32).ravel())
    if mesh.colors is not None:
        shape.add_attribute("vertex_color", 3, np.ascontiguousarray(mesh.colors[:, :3], np.float32).ravel())
        shape.add_attribute("vertex_alpha", 1, np.ascontiguousarray(mesh.colors[:, 3], np.float32))
