"""A pinhole camera."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from reflet.errors import RefletError

Vec3 = tuple[float, float, float]


@dataclass(frozen=True)
class Camera:
    """Looks from ``position`` at ``target``; ``fov_deg`` is the vertical field of view. Metres, degrees, pixels."""

    position: Vec3
    target: Vec3
    up: Vec3 = (0.0, 1.0, 0.0)
    fov_deg: float = 36.0
    width: int = 512
    height: int = 512

    def __post_init__(self) -> None:
        forward = np.subtract(self.target, self.position)
        if not np.isfinite(forward).all():
            raise RefletError("A camera's place and target are finite numbers; give angles and distances that are.")
        if np.linalg.norm(np.cross(forward, self.up)) < 1e-9:
            eye, target = (", ".join(f"{each:.6g}" for each in point) for point in (self.position, self.target))
            raise RefletError(
                f"A camera at ({eye}) that looks at ({target}) has no upright picture; choose an elevation below "
                "90°, another distance or target."
            )
        if not 0.0 < self.fov_deg < 180.0:
            raise RefletError(f"The field of view must lie between 0 and 180 degrees, not {self.fov_deg}.")
        if self.width < 1 or self.height < 1:
            raise RefletError(f"A picture needs at least one pixel, not {self.width}×{self.height}.")

    def frame(self) -> tuple[Float[np.ndarray, "3"], Float[np.ndarray, "3"], Float[np.ndarray, "3"]]:
        """Unit vectors (right, up, forward) in world space."""
        forward = np.subtract(self.target, self.position).astype(np.float64)
        forward /= np.linalg.norm(forward)
        right = np.cross(forward, self.up)
        right /= np.linalg.norm(right)
        return right, np.cross(right, forward), forward

    def view_from_world(self) -> Float[np.ndarray, "3 3"]:
        """The rotation whose rows are right, up and back (towards the viewer)."""
        right, up, forward = self.frame()
        return np.stack([right, up, -forward])

    def ray_basis(self) -> tuple[Float[np.ndarray, "3"], Float[np.ndarray, "3"], Float[np.ndarray, "3"]]:
        """(corner, dx, dy): the ray through pixel coordinates (x, y) is corner + x·dx + y·dy, not normalized.

        Pixel coordinates run from (0, 0) at the picture's top left corner to (width, height). The rays' component
        along the view direction is 1.
        """
        right, up, forward = self.frame()
        half = np.tan(np.radians(self.fov_deg) / 2.0)
        dx = right * (2.0 * half / self.height)
        dy = up * (-2.0 * half / self.height)
        return forward - dx * (self.width / 2.0) - dy * (self.height / 2.0), dx, dy

    def clip_from_world(self, near: float, far: float) -> Float[np.ndarray, "4 4"]:
        """WebGPU's clip space (depth 0 at ``near``, 1 at ``far``) from world space; multiplies column vectors."""
        view_from_world = np.eye(4)
        view_from_world[:3, :3] = self.view_from_world()
        view_from_world[:3, 3] = -view_from_world[:3, :3] @ np.asarray(self.position)
        scale = 1.0 / np.tan(np.radians(self.fov_deg) / 2.0)
        clip_from_view = np.zeros((4, 4))
        clip_from_view[0, 0] = scale * self.height / self.width
        clip_from_view[1, 1] = scale
        clip_from_view[2, 2:] = far / (near - far), near * far / (near - far)
        clip_from_view[3, 2] = -1.0
        return clip_from_view @ view_from_world
