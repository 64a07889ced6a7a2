"""Pictures of hemispheres, made from an analytic sky, give that sky back."""

import numpy as np
import pytest

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS
from reflet.envmap.resampling.hemispheres import HALF_TURN, HemispherePicture, join_hemispheres
from reflet.envmap.resampling.projections import PROJECTIONS
from reflet.errors import RefletError

WIDE = {"orthographic": 180.0, "mirror_ball": 360.0}
SIZE = 192


def sky(direction: np.ndarray) -> np.ndarray:
    """Linear and quadratic in the direction, different along every axis, between 0.3 and 1.9."""
    x, y, z = np.moveaxis(direction, -1, 0)
    return np.stack([1 + 0.5 * x + 0.3 * y * z, 1 + 0.5 * y - 0.3 * x * z, 1 + 0.5 * z + 0.2 * x * y], -1)


def angle_from_radius(name: str, radius: np.ndarray, half: float) -> np.ndarray:
    """Of a circle of radius 1 at ``half``: the closed forms that the projections' names stand for, inverted."""
    inverse = {
        "equidistant": lambda r: r * half,
        "equisolid": lambda r: 2.0 * np.arcsin(np.minimum(r * np.sin(half / 2.0), 1.0)),
        "stereographic": lambda r: 2.0 * np.arctan(r * np.tan(half / 2.0)),
        "orthographic": lambda r: np.arcsin(np.minimum(r * np.sin(half), 1.0)),
    }
    inverse["paraboloid"], inverse["mirror_ball"] = inverse["stereographic"], inverse["equisolid"]
    return inverse[name](radius)


def photograph(name: str, fov: float, front_from_camera: np.ndarray, size: int = SIZE) -> np.ndarray:
    """What a camera with this lens, or before this mirror, sees of the sky."""
    at = (np.arange(size) + 0.5) / size * 2.0 - 1.0
    right, up = np.meshgrid(at, -at)
    radius = np.hypot(right, up)
    theta = angle_from_radius(name, radius, np.radians(fov / 2.0))
    # A lens along +z has -x on its right; a mirror seen from +z has +x there.
    x = right if name in ("paraboloid", "mirror_ball") else -right
    direction = np.stack([x / radius * np.sin(theta), up / radius * np.sin(theta), np.cos(theta)], -1)
    return sky(direction @ front_from_camera.T).astype(np.float32)


def both(name: str, fov: float, turn: np.ndarray = HALF_TURN) -> tuple[HemispherePicture, HemispherePicture]:
    front, back = photograph(name, fov, np.eye(3)), photograph(name, fov, turn)
    return HemispherePicture(front, name, fov), HemispherePicture(back, name, fov)


def error(image: EnvImage) -> float:
    """Largest difference from the sky over the valid texels."""
    direction, valid = image.parameterization.texel_directions(image.size)
    return float(np.abs(image.texels - sky(direction))[valid].max())


@pytest.mark.parametrize("name", [name for name in PROJECTIONS if name != "orthographic"])
@pytest.mark.parametrize("to", ["dual_paraboloid", "cube", "latlong"])
def test_the_sky_comes_back_without_a_seam(name: str, to: str) -> None:
    joined = join_hemispheres(*both(name, WIDE.get(name, 195.0)), to=PARAMETERIZATIONS[to], size=48)
    assert error(joined) < SMOOTH


# A texel is a mean of the sky over up to w = 4/48 radians (dual paraboloid, in the middle): off by its Laplacian, at
# most 2·0.5 + 6·0.3/2 = 1.9, times w²/24. Bilinear pixels of π/192 radians add a tenth of that. The outermost 1.5
# pixels, of a degree each, are continued, where alpha is 0.05 of the sky's slope of 0.6: 4e-4. A seam would be larger.
SMOOTH = 1e-3


def test_an_orthographic_lens_reaches_its_rim() -> None:
    joined = join_hemispheres(*both("orthographic", 180.0), size=48)
    direction, _ = joined.parameterization.texel_directions(48)
    away = np.abs(direction[..., 2]) > 0.2
    assert np.abs(joined.texels - sky(direction))[away].max() < 2e-3  # pixels get wide towards the rim: 1/192/cos θ
    # Right at the rim the last 1.5 pixels span arccos(1 - 3/192) = 0.18 radians, where the sky changes by up to 0.12.
    assert error(joined) < 0.12


@pytest.mark.parametrize("yaw", [150.0, 200.0])
def test_cameras_need_not_stand_back_to_back(yaw: float) -> None:
    angle = np.radians(yaw)
    turn = np.array([[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]])
    assert error(join_hemispheres(*both("equidistant", 260.0, turn), front_from_back=turn, size=48)) < SMOOTH


def test_a_circle_off_the_middle() -> None:
    padding = ((10, 30), (50, 20), (0, 0))
    front, back = (np.pad(picture.pixels, padding, "edge") for picture in both("equidistant", 190.0))
    circle = (50.0 + SIZE / 2, 10.0 + SIZE / 2, SIZE / 2)
    pictures = [HemispherePicture(pixels, "equidistant", 190.0, circle) for pixels in (front, back)]
    assert error(join_hemispheres(*pictures, size=48)) < SMOOTH


def test_exposures_that_differ_fade_without_a_jump() -> None:
    front, back = (
        HemispherePicture(np.full((64, 64, 3), level, np.float32), "equidistant", 200.0) for level in (1.0, 3.0)
    )
    joined = join_hemispheres(front, back, to=PARAMETERIZATIONS["latlong"], size=64)
    middle = joined.texels[0, 32, :, 0].astype(np.float64)  # along the horizon
    assert middle.min() == 1.0 and middle.max() == 3.0
    # Both see 20 degrees: alpha changes by 1/20 a degree, a texel is 2.8 degrees wide, so the ramp rises by
    # 2·2.8/20 = 0.28 a texel at most; a hard border would jump by 2.
    assert np.abs(np.diff(middle)).max() < 0.29
    azimuth = 360.0 * (np.arange(128) + 0.5) / 128 - 180.0  # atan2(z, x); the front picture's axis is at 90
    from_front = np.abs(azimuth - 90.0)
    from_front = np.minimum(from_front, 360.0 - from_front)
    alpha = np.clip((100.0 - from_front) / 20.0, 0.0, 1.0)
    # Row 32 lies 1.4 degrees off the horizon: 0.01 in alpha; a texel's mean rounds the ramp's ends by 2.8/20/8.
    assert np.abs(middle - (3.0 - 2.0 * alpha)).max() < 0.06


def test_balance_brings_exposures_together() -> None:
    front, back = both("equisolid", 200.0)
    darker = HemispherePicture(back.pixels * 0.25, "equisolid", 200.0)
    assert error(join_hemispheres(front, darker, size=48)) > 0.5
    # The median ratio is 4 to the two pictures' bilinear errors.
    assert error(join_hemispheres(front, darker, size=48, balance=True)) < 1e-3


def test_a_border_as_wide_as_asked() -> None:
    front, back = (HemispherePicture(np.full((8, 8, 1), level, np.float32), "equidistant", 200.0) for level in (0, 1))
    for blend in (0.0, 5.0, 40.0):
        joined = join_hemispheres(front, back, to=PARAMETERIZATIONS["latlong"], size=256, blend_deg=blend)
        mixed = np.mean((joined.texels[0, 128] > 1e-6) & (joined.texels[0, 128] < 1 - 1e-6))
        # Two borders around the horizon, each to a texel (0.7 degrees) at both ends.
        assert mixed * 360.0 == pytest.approx(2.0 * blend, abs=4 * 0.71)


def test_black_around_the_circle_stays_out() -> None:
    at = (np.arange(200) + 0.5) / 100.0 - 1.0
    inside = np.hypot(at, at[:, None]) < 1.0
    picture = HemispherePicture(inside[..., None].astype(np.float32), "equidistant", 180.0)
    for back in (picture, None):
        joined = join_hemispheres(picture, back, to=PARAMETERIZATIONS["cube"], size=128)
        # 1.5 pixels inside the circle the farthest of four bilinear taps may be black, of weight below 0.1.
        assert joined.texels.min() > 0.9


def test_without_a_back_the_front_is_mirrored() -> None:
    front, _ = both("equidistant", 180.0)
    joined = join_hemispheres(front, size=48)
    assert np.array_equal(joined.texels[0], joined.texels[1])
    direction, _ = joined.parameterization.texel_directions(48)
    inside = direction[0, ..., 2] > 0.1  # texels on the rim are partly of the mirrored half
    assert np.abs(joined.texels - sky(direction))[0][inside].max() < SMOOTH


def test_a_small_sun_keeps_its_energy_in_a_small_map() -> None:
    pixels = np.zeros((400, 400, 1), np.float32)
    pixels[150, 220] = 1e5
    picture = HemispherePicture(pixels, "equisolid", 200.0)
    dark = HemispherePicture(np.zeros_like(pixels), "equisolid", 200.0)
    joined = join_hemispheres(picture, dark, size=16, to=PARAMETERIZATIONS["equal_area_octahedral"])
    flux = (joined.texels[..., 0] * joined.parameterization.texel_solid_angle(16)).sum()
    # Equisolid pixels are alike: 4π·sin²(50°)/(π·200²) steradian. Summed over points half a pixel apart a bilinear tent
    # is even; where texels are longer than wide, points are up to 0.7 pixels apart one way: sinc²(1/0.7) = 2 %.
    assert flux == pytest.approx(1e5 * 4.0 * np.sin(np.radians(50.0)) ** 2 / 200**2, rel=0.02)


@pytest.mark.parametrize(
    "projection, fov, circle",
    [
        ("fish", None, None),
        ("equidistant", 120.0, None),
        ("orthographic", 190.0, None),
        ("equidistant", None, (2, 2, -1)),
    ],
)
def test_pictures_that_make_no_sense(projection: str, fov: float | None, circle: tuple[float, float, float]) -> None:
    with pytest.raises(RefletError):
        HemispherePicture(np.ones((8, 8, 3)), projection, fov, circle)


def test_the_compiled_loop_agrees_with_the_pictures() -> None:
    """Pictures of noise, where a texel is one point: magnified."""
    noise = np.random.default_rng(1).random((2, 24, 24, 3)).astype(np.float32)
    front, back = (HemispherePicture(pixels, "stereographic", 200.0, (11.0, 13.0, 10.0)) for pixels in noise)
    joined = join_hemispheres(front, back, to=PARAMETERIZATIONS["latlong"], size=256)
    direction = joined.parameterization.texel_directions(256)[0][0]
    clear = np.abs(np.degrees(np.arcsin(direction[..., 2]))) > 11.0  # beyond the border
    ahead = clear & (direction[..., 2] > 0.0)
    behind = clear & (direction[..., 2] < 0.0)
    assert np.abs(joined.texels[0][ahead] - front.radiance(direction[ahead])).max() < 1e-6  # float32
    assert np.abs(joined.texels[0][behind] - back.radiance(direction[behind] @ HALF_TURN)).max() < 1e-6


def test_directions_that_nobody_saw_are_told() -> None:
    with pytest.raises(RefletError, match="neither"):
        join_hemispheres(*both("equidistant", 190.0), front_from_back=np.eye(3), size=16)
    front, back = both("equidistant", 180.0)
    with pytest.raises(RefletError, match="balanced"):
        join_hemispheres(front, back, size=16, balance=True)
