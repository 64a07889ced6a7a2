"""Values of Mitsuba's materials and lights, constant or from textures."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from jaxtyping import Float

from reflet.errors import RefletError
from reflet.files.srgb import srgb_from_linear
from reflet.scene.material import REPEATS, Texture, Vec3, Wrap
from reflet.trace.mitsuba_files.mitsuba_doubts import Doubts
from reflet.trace.mitsuba_files.mitsuba_nodes import Node

PROCEDURAL_SIZE = 256  # pixels along each edge of a texture that has no pixels of its own
_NOT_READ = "Textures that cannot be read are replaced by the parameter's default"


@dataclass(frozen=True)
class Color:
    """A factor and an sRGB picture, if there is one; the factor is 1 unless the picture is brighter.

    ``texture_from_mesh`` maps the mesh's texture coordinates to the picture's: Mitsuba's ``to_uv``.
    """

    factor: Vec3
    picture: Texture | None = None
    texture_from_mesh: Float[np.ndarray, "3 3"] | None = None


@dataclass(frozen=True)
class Amount:
    """A share from 0 to 1: the mean, and the picture that it is the mean of, if there is one."""

    mean: float
    picture: Float[np.ndarray, "height width"] | None = None
    wraps: tuple[Wrap, Wrap] = REPEATS
    texture_from_mesh: Float[np.ndarray, "3 3"] | None = None

    def turned_by(self, function: Callable[[Any], Any]) -> "Amount":
        """``function`` of it, pixel by pixel."""
        picture = None if self.picture is None else function(self.picture)
        return replace(self, mean=float(function(self.mean) if picture is None else picture.mean()), picture=picture)


@dataclass(frozen=True)
class NormalMap:
    """Its picture, and where that lies."""

    picture: Texture
    texture_from_mesh: Float[np.ndarray, "3 3"] | None = None


class Values:
    """The parameters of one shape's plugins. What is put right goes into ``doubts`` under the shape's ``name``.

    Where the shape has no texture coordinates (not ``textured``) textures are replaced by their mean.
    """

    def __init__(self, name: str, textured: bool, doubts: Doubts) -> None:
        self.name = name
        self.textured = textured
        self.doubts = doubts

    def number(self, node: Node, key: str, default: float) -> float:
        """A scalar parameter, or the mean of its texture, which goes into the doubts."""
        values = self._evaluated(node, key, default)
        if values.shape[:2] != (1, 1) and self.textured:
            self.doubts.add(f"Textures of {key} count as their mean", self.name)
        return float(np.mean(values))

    def amount(self, node: Node, key: str, default: float) -> Amount:
        """A share from 0 to 1, with its texture."""
        shares = np.clip(self._evaluated(node, key, default).mean(-1), 0.0, 1.0)
        if shares.shape == (1, 1) or not self.textured:
            return Amount(float(shares.mean()))
        return Amount(float(shares.mean()), shares, *_laid(node.children[key]))

    def normals(self, node: Node) -> NormalMap | None:
        """The texture of a normal map; None, which goes into the doubts, where it cannot be laid on the shape."""
        key = next((key for key, child in node.children.items() if child.kind == "texture"), "")
        if not key or not self.textured:
            self.doubts.add("Normal maps of shapes without texture coordinates are left out", self.name)
            return None
        vectors = np.clip(self._evaluated(node, key, 0.5), 0.0, 1.0)
        pixels = np.full((*vectors.shape[:2], 4), 255, np.uint8)
        pixels[..., :3] = np.round(vectors * 255.0)
        wraps, placed = _laid(node.children[key])
        return NormalMap(Texture(pixels, wraps), placed)

    def color(
        self,
        node: Node,
        key: str,
        default: float,
        *,
        unbounded: bool = False,
        function: Callable[[Any], Any] = lambda linear: linear,
    ) -> Color:
        """``function`` of a colour; brighter than 1 if ``unbounded``."""
        linear = function(self._evaluated(node, key, default))
        mean = linear.reshape(-1, 3).mean(0)
        if linear.shape[:2] == (1, 1) or not self.textured:
            return Color((float(mean[0]), float(mean[1]), float(mean[2])))
        brightest = float(linear.max()) if unbounded else 1.0
        linear = np.clip(linear / max(brightest, 1e-9), 0.0, 1.0)
        code = srgb_from_linear(linear)
        pixels = np.full((*linear.shape[:2], 4), 255, np.uint8)
        pixels[..., :3] = np.round(code * 255.0)
        wraps, placed = _laid(node.children[key])
        return Color((brightest, brightest, brightest), Texture(pixels, wraps), placed)

    def _evaluated(self, node: Node, key: str, default: float) -> Float[np.ndarray, "height width 3"]:
        """Linear values of a parameter: one pixel, or a texture's at its pixels' centres, as if nothing placed it."""
        child = node.children.get(key)
        if child is not None and child.plugin in ("mesh_attribute", "volume"):
            self.doubts.add(_NOT_READ, f"{child.plugin} of {self.name}")
            return np.full((1, 1, 3), default)
        if child is not None:
            child = replace(child, values={name: value for name, value in child.values.items() if name != "to_uv"})
            try:
                texture = child.built(f"the {key} of {self.name}")
            except RefletError as error:
                self.doubts.add(_NOT_READ, str(error).rstrip("."))
                return np.full((1, 1, 3), default)
        else:
            described = node.values.get(key, default)
            if isinstance(described, int | float):
                return np.full((1, 1, 3), float(described))
            if isinstance(described, dict) and described["type"] == "rgb":
                return np.asarray(described["value"], np.float64).reshape(1, 1, 3)
            texture = mi.load_dict(described)
        width = height = 1
        if texture.is_spatially_varying():
            width, height = (max(int(size), 1) for size in texture.resolution())
            if width == height == 1:
                width = height = PROCEDURAL_SIZE
        v, u = np.meshgrid((np.arange(height) + 0.5) / height, (np.arange(width) + 0.5) / width, indexing="ij")
        at: Any = dr.zeros(mi.SurfaceInteraction3f, width * height)
        at.uv = mi.Point2f(np.stack([u.ravel(), v.ravel()]).astype(np.float32))
        channels = [np.broadcast_to(channel.numpy(), width * height) for channel in texture.eval(at)]
        return np.stack(channels, -1).astype(np.float64).reshape(height, width, 3)


def _laid(texture: Node) -> tuple[tuple[Wrap, Wrap], Float[np.ndarray, "3 3"] | None]:
    """How a texture goes on beyond its edges, and where it lies."""
    known: dict[str, Wrap] = {"clamp": "clamp", "mirror": "mirror"}
    wrap = known.get(texture.values.get("wrap_mode", ""), "repeat")
    placed = texture.values.get("to_uv")
    return (wrap, wrap), None if placed is None else _on_the_plane(placed)


def _on_the_plane(transform: Any) -> Float[np.ndarray, "3 3"]:
    """The part of a transform of space that moves points of the plane z = 0 within it."""
    matrix = np.array(transform.matrix, np.float64).reshape(-1)
    if matrix.size == 9:
        return matrix.reshape(3, 3)
    return matrix.reshape(4, 4)[np.ix_([0, 1, 3], [0, 1, 3])]
