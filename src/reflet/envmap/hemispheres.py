"""Hemispheres taken separately, by a fisheye lens or in a curved mirror, joined into one map of all directions."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy.ndimage import map_coordinates

from reflet.envmap.dual_paraboloid import DualParaboloid
from reflet.envmap.env_image import EnvImage
from reflet.envmap.equal_area_octahedral import EqualAreaOctahedral
from reflet.envmap.equal_sampling import equal_sampling_size
from reflet.envmap.parameterization import Directions, Parameterization
from reflet.errors import RefletError

Picture = Float[np.ndarray, "height width channels"]
Angles = Float[np.ndarray, "*batch"]

DUAL_PARABOLOID = DualParaboloid()
HALF_TURN = np.diag([-1.0, 1.0, -1.0])  # about +y
MOST_SUBSAMPLES = 16  # along a texel's edge: a picture so much finer than the map is thinned out
_BLOCK = 1 << 18  # lookups at a time: bounds the memory to some 50 MB beside pictures and map
WIDEST_BORDER = np.radians(20.0)  # where nothing else is said
_DARK = 1e-6  # radiance below this says nothing about exposure


@dataclass(frozen=True)
class Projection:
    """How far from the middle of a round picture a direction is seen.

    ``radius`` maps the angle to the optical axis in radians to a distance, up to a factor; the picture shows directions
    up to ``widest_deg`` across. A mirror's picture is taken from the side it shows, hence is not reversed; a lens that
    looks the same way has +x on its left.
    """

    radius: Callable[[Angles], Angles]
    is_mirror: bool = False
    fov_deg: float = 180.0  # the angle across the picture where nothing else is said
    widest_deg: float = 360.0


PROJECTIONS: dict[str, Projection] = {
    "equidistant": Projection(lambda theta: theta),
    "equisolid": Projection(lambda theta: np.sin(0.5 * theta)),
    "stereographic": Projection(lambda theta: np.tan(0.5 * theta), widest_deg=350.0),
    "orthographic": Projection(np.sin, widest_deg=180.0),
    # Seen by an orthographic camera: z = (1 - x² - y²)/2 is the stereographic projection [Heidrich00, eq. 8], and on a
    # ball the normal halves the angle between the axis and the mirrored ray [Heidrich00, sec. 2.1].
    "paraboloid": Projection(lambda theta: np.tan(0.5 * theta), is_mirror=True, widest_deg=350.0),
    "mirror_ball": Projection(lambda theta: np.sin(0.5 * theta), is_mirror=True, fov_deg=360.0),
}


@dataclass(frozen=True)
class HemispherePicture:
    """One round picture of linear radiance, its axis along +z and +y up.

    ``fov_deg`` is the angle across the circle, at least 180; by default what its projection usually shows: 180, or 360
    for a mirror ball, whose outline mirrors what is right behind it. ``circle`` is the middle (column, row) and radius
    of the circle in pixels, by default the largest one amid the picture. Raises RefletError where these make no sense.
    """

    pixels: Picture
    projection: str
    fov_deg: float | None = None
    circle: tuple[float, float, float] | None = None

    def __post_init__(self) -> None:
        if self.projection not in PROJECTIONS:
            raise RefletError(f"A projection is one of {', '.join(PROJECTIONS)}; {self.projection} is none.")
        widest = PROJECTIONS[self.projection].widest_deg
        if not 180.0 <= 2.0 * np.degrees(self.half_angle) <= widest + 1e-9:
            raise RefletError(
                f"A {self.projection} picture of a hemisphere is 180 to {widest:g} degrees wide, not {self.fov_deg:g}."
            )
        column, row, radius = self.image_circle
        height, width = self.pixels.shape[:2]
        if not (radius > 0.0 and 0.0 <= column <= width and 0.0 <= row <= height):
            raise RefletError(
                f"A circle of radius {radius:g} around ({column:g}, {row:g}) does not fit a {width}×{height} picture; "
                "give its middle and radius in pixels from the top left corner."
            )

    @property
    def half_angle(self) -> float:
        """Radians from the axis to the circle."""
        fov = PROJECTIONS[self.projection].fov_deg if self.fov_deg is None else self.fov_deg
        return float(np.radians(0.5 * fov))

    @property
    def image_circle(self) -> tuple[float, float, float]:
        """Middle (column, row) and radius in pixels."""
        height, width = self.pixels.shape[:2]
        return self.circle or (0.5 * width, 0.5 * height, 0.5 * min(width, height))

    @property
    def pixels_ahead(self) -> float:
        """Pixels that show the half of all directions around the axis."""
        radius = PROJECTIONS[self.projection].radius
        share = radius(np.array(0.5 * np.pi)) / radius(np.array(self.half_angle))
        return float(np.pi * (self.image_circle[2] * share) ** 2)

    @property
    def finest_sampling(self) -> float:
        """The most pixels per steradian anywhere within the circle."""
        projection, (_, _, radius) = PROJECTIONS[self.projection], self.image_circle
        # The outermost hundredth is left out: at the rim of a ball sin θ vanishes.
        theta = np.linspace(0.0, 0.99 * self.half_angle, 256)
        ring = projection.radius(theta) * (radius / projection.radius(np.array(self.half_angle)))
        return float(np.max(np.diff(0.5 * ring**2) / np.diff(-np.cos(theta))))

    def beyond_edge(self, direction: Directions) -> Angles:
        """Radians by which unit directions lie outside the circle, negative inside."""
        return np.arctan2(np.hypot(direction[..., 0], direction[..., 1]), direction[..., 2]) - self.half_angle

    def radiance(self, direction: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "n channels"]:
        """What the picture shows in unit directions, bilinear between pixels; outside the circle as on its edge."""
        projection, (column, row, radius) = PROJECTIONS[self.projection], self.image_circle
        x, y, z = np.moveaxis(direction, -1, 0)
        across = np.hypot(x, y)
        theta = np.minimum(np.arctan2(across, z), self.half_angle)
        ring = projection.radius(theta) * (radius / projection.radius(np.array(self.half_angle)))
        scale = ring / np.maximum(across, 1e-12)
        right = x if projection.is_mirror else -x
        at = np.stack([row - scale * y - 0.5, column + scale * right - 0.5])
        channels = np.moveaxis(self.pixels, -1, 0)
        return np.stack([map_coordinates(channel, at, order=1, mode="nearest") for channel in channels], -1)


def join_hemispheres(
    front: HemispherePicture,
    back: HemispherePicture | None = None,
    *,
    front_from_back: Float[np.ndarray, "3 3"] = HALF_TURN,
    blend_deg: float | None = None,
    balance: bool = False,
    to: Parameterization = DUAL_PARABOLOID,
    size: int | None = None,
) -> EnvImage:
    """The map of all directions that two pictures show between them, the front one's axis along +z.

    Over the border where both see, alpha falls from 1 to 0, which hides what does not agree; implements [Heidrich00,
    sec. 2.3.2]. Without ``back`` the front one is mirrored at the plane z = 0, as in Figure 6 there. The other
    camera's directions are turned by ``front_from_back``, by default half a turn about +y. The border is ``blend_deg``
    wide, by default all that both see but at most 20 degrees, for what does not agree shows double there; where it is
    wider than what both see, the colours of a picture's edge go on beyond it.
    ``balance`` multiplies the back picture by the median ratio of the two where both see.

    ``size`` is by default that of equal sampling: about as many texels as there are pixels. Texels are means of as many
    points as reach all pixels (up to 16²). Raises RefletError for directions that neither picture shows, pictures of
    different channels, and where there is nothing to balance by.
    """
    if back is not None and back.pixels.shape[2] != front.pixels.shape[2]:
        raise RefletError(
            f"The front picture has {front.pixels.shape[2]} channels, the back one {back.pixels.shape[2]}; convert one."
        )
    if blend_deg is not None and not 0.0 <= blend_deg <= 180.0:
        raise RefletError(f"A border is 0 to 180 degrees wide, not {blend_deg:g}.")
    joint = _Joint(front, back, front_from_back, None if blend_deg is None else float(np.radians(blend_deg)))
    if balance and back is not None:
        joint = _Joint(front, back, front_from_back, joint.blend, joint.exposure_ratio())
    pictures = [front, back or front]
    size = size or equal_sampling_size(to, sum(picture.pixels_ahead for picture in pictures))
    return EnvImage(to, _texels(joint, to, size, max(picture.finest_sampling for picture in pictures)))


@dataclass(frozen=True)
class _Joint:
    """The joined pictures as a function of direction."""

    front: HemispherePicture
    back: HemispherePicture | None
    front_from_back: Float[np.ndarray, "3 3"]
    blend: float | None  # radians
    gain: float = 1.0  # of the back picture

    def radiance(self, direction: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "n channels"]:
        """Blended radiance in unit directions."""
        if self.back is None:
            return self.front.radiance(np.concatenate([direction[:, :2], np.abs(direction[:, 2:])], 1))
        behind = direction @ self.front_from_back  # the inverse of a rotation is its transpose
        beyond_front, beyond_back = self.front.beyond_edge(direction), self.back.beyond_edge(behind)
        unseen = np.minimum(beyond_front, beyond_back)
        if unseen.max() > 1e-6:
            raise RefletError(
                "Some directions are in neither picture; give a larger field of view or another turn of the camera."
            )
        # Half way between the two edges alpha is 1/2; it changes over the width of the border. Where that is all both
        # see, it is 0 and 1 right on the edges.
        width = np.minimum(-(beyond_front + beyond_back), WIDEST_BORDER) if self.blend is None else self.blend
        alpha = 0.5 + (beyond_back - beyond_front) / (2.0 * np.maximum(width, 1e-9))
        alpha = np.clip(alpha, 0.0, 1.0)[:, None]
        out = np.zeros((len(direction), self.front.pixels.shape[2]))
        ahead = alpha[:, 0] > 0.0
        out[ahead] = alpha[ahead] * self.front.radiance(direction[ahead])
        ahead = alpha[:, 0] < 1.0
        out[ahead] += (1.0 - alpha[ahead]) * self.gain * self.back.radiance(behind[ahead])
        return out

    def exposure_ratio(self) -> float:
        """Median over the directions that both pictures show of the front one's mean radiance over the back one's."""
        assert self.back is not None
        direction = EqualAreaOctahedral().texel_directions(128)[0].reshape(-1, 3)
        behind = direction @ self.front_from_back
        both = np.maximum(self.front.beyond_edge(direction), self.back.beyond_edge(behind)) < 0.0
        front = self.front.radiance(direction[both])[:, :3].mean(1)
        back = self.back.radiance(behind[both])[:, :3].mean(1)
        lit = np.minimum(front, back) > _DARK
        if not lit.any():
            raise RefletError(
                "Exposures cannot be balanced, for no lit direction is in both pictures; give a larger field of view."
            )
        return float(np.median(front[lit] / back[lit]))


def _texels(
    joint: _Joint, to: Parameterization, size: int, finest: float
) -> Float[np.ndarray, "faces rows columns channels"]:
    """Means over a square grid of points in each texel, so fine that no pixel is passed over."""
    everywhere = EqualAreaOctahedral().texel_directions(64)[0]
    coarsest = float(to.sampling_rate(everywhere).min()) * size**2
    points = int(np.clip(np.ceil((finest / coarsest) ** 0.5), 1, MOST_SUBSAMPLES))
    faces, rows, columns = to.shape(size)
    texels = np.zeros((faces, rows, columns, joint.front.pixels.shape[2]), np.float32)
    offset = (np.arange(points) + 0.5) / points
    u = ((np.arange(columns)[:, None] + offset) / columns).ravel()
    block = max(_BLOCK // (len(u) * points), 1)
    for face in range(faces):
        for top in range(0, rows, block):
            v = ((np.arange(top, min(top + block, rows))[:, None] + offset) / rows).ravel()
            uv = np.stack(np.broadcast_arrays(u[None, :], v[:, None]), -1)
            direction, _ = to.direction_from_uv(np.full(uv.shape[:-1], face), uv)
            radiance = joint.radiance(direction.reshape(-1, 3))
            grid = radiance.reshape(len(v) // points, points, columns, points, -1)
            texels[face, top : top + block] = grid.mean((1, 3))
    return texels
