"""Hemispheres taken separately, by a fisheye lens or in a curved mirror, joined into one map of all directions."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy.ndimage import map_coordinates

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.dual_paraboloid import DualParaboloid
from reflet.envmap.parameterizations.equal_area_octahedral import EqualAreaOctahedral
from reflet.envmap.parameterizations.parameterization import Directions, Parameterization
from reflet.envmap.resampling.compiled_hemispheres import RIM, join_into
from reflet.envmap.resampling.equal_sampling import equal_sampling_size
from reflet.envmap.resampling.projections import PROJECTIONS, Angles
from reflet.errors import RefletError

Picture = Float[np.ndarray, "height width channels"]

DUAL_PARABOLOID = DualParaboloid()
HALF_TURN = np.diag([-1.0, 1.0, -1.0])  # about +y
WIDEST_BORDER = float(np.radians(20.0))  # where nothing else is said
_DIRECTIONS = 128  # squared: those looked at to compare exposures, and whether all are seen
_DARK = 1e-6  # radiance below this says nothing about exposure


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
                f"A hemisphere's picture of {self.projection} projection is 180 to {widest:g} degrees wide, "
                f"not {self.fov_deg:g}."
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

    def lens(self) -> Float[np.ndarray, "7"]:
        """What `compiled_hemispheres` needs to find a direction's pixel."""
        projection, (column, row, radius) = PROJECTIONS[self.projection], self.image_circle
        scale = radius / float(projection.radius(np.array(self.half_angle)))
        side = 1.0 if projection.is_mirror else -1.0
        return np.array([column, row, scale, self.half_angle, projection.code, side, max(radius - RIM, 0.0)])

    def beyond_edge(self, direction: Directions) -> Angles:
        """Radians by which unit directions lie outside the circle, negative inside."""
        return np.arctan2(np.hypot(direction[..., 0], direction[..., 1]), direction[..., 2]) - self.half_angle

    def radiance(self, direction: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "n channels"]:
        """What the picture shows in unit directions, bilinear between pixels; outside the circle as on its edge.

        That edge is `RIM` pixels inside the circle: where a lens ends pixels are half black.
        """
        projection, (column, row, radius) = PROJECTIONS[self.projection], self.image_circle
        x, y, z = np.moveaxis(direction, -1, 0)
        across = np.hypot(x, y)
        theta = np.minimum(np.arctan2(across, z), self.half_angle)
        ring = projection.radius(theta) * (radius / projection.radius(np.array(self.half_angle)))
        scale = np.minimum(ring, max(radius - RIM, 0.0)) / np.maximum(across, 1e-12)
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

    ``size`` is by default that of equal sampling: about as many texels as there are pixels. Texels are means of so many
    points that energy is kept. Raises RefletError for directions that neither picture shows, pictures of
    different channels, and where there is nothing to balance by.
    """
    if back is not None and back.pixels.shape[2] != front.pixels.shape[2]:
        raise RefletError(
            f"The front picture has {front.pixels.shape[2]} channels, the back one {back.pixels.shape[2]}; save both "
            "in grey or both in colour."
        )
    if blend_deg is not None and not 0.0 <= blend_deg <= 180.0:
        raise RefletError(f"A border is 0 to 180 degrees wide, not {blend_deg:g}.")
    pictures = [front, back or front]
    gain = 1.0
    if back is not None:
        _check_all_seen(front, back, front_from_back)
        gain = _exposure_ratio(front, back, front_from_back) if balance else 1.0
    size = size or equal_sampling_size(to, sum(picture.pixels_ahead for picture in pictures))
    channels = front.pixels.shape[2]
    texels = np.empty((*to.shape(size), channels), np.float32)
    join_into(
        texels,
        to.kind,
        np.ascontiguousarray(front.pixels, np.float32),
        front.lens(),
        np.ascontiguousarray(back.pixels, np.float32) if back is not None else np.empty((0, 0, channels), np.float32),
        pictures[1].lens(),
        np.ascontiguousarray(front_from_back, np.float64),
        -1.0 if blend_deg is None else float(np.radians(blend_deg)),
        WIDEST_BORDER,
        gain,
        max(picture.finest_sampling for picture in pictures),
    )
    return EnvImage(to, texels)


def _exposure_ratio(
    front: HemispherePicture, back: HemispherePicture, front_from_back: Float[np.ndarray, "3 3"]
) -> float:
    """Median over the directions that both pictures show of the front one's mean radiance over the back one's."""
    direction = EqualAreaOctahedral().texel_directions(_DIRECTIONS)[0].reshape(-1, 3)
    behind = direction @ front_from_back
    both = np.maximum(front.beyond_edge(direction), back.beyond_edge(behind)) < 0.0
    ahead, other = (picture.radiance(d[both])[:, :3].mean(1) for picture, d in ((front, direction), (back, behind)))
    lit = np.minimum(ahead, other) > _DARK
    if not lit.any():
        raise RefletError(
            "Exposures cannot be balanced, for no lit direction is in both pictures; give a larger field of view."
        )
    return float(np.median(ahead[lit] / other[lit]))


def _check_all_seen(
    front: HemispherePicture, back: HemispherePicture, front_from_back: Float[np.ndarray, "3 3"]
) -> None:
    direction = EqualAreaOctahedral().texel_directions(_DIRECTIONS)[0].reshape(-1, 3)
    # the inverse of a rotation is its transpose
    unseen = np.minimum(front.beyond_edge(direction), back.beyond_edge(direction @ front_from_back)) > 1e-6
    if unseen.any():
        raise RefletError(
            f"{unseen.mean():.1%} of all directions are in neither picture; give a larger field of view or turn the "
            "back camera otherwise."
        )
