"""Captured env maps against scenes whose radiance is known in every direction."""

import numpy as np
import pytest
from map_scenes import linear

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.parameterizations.dual_paraboloid import DualParaboloid
from reflet.envmap.parameterizations.gazing_ball import GazingBall
from reflet.envmap.parameterizations.latlong import LatLong
from reflet.envmap.parameterizations.octahedral import Octahedral
from reflet.envmap.parameterizations.parameterization import Parameterization
from reflet.errors import RefletError
from reflet.render.capture.capture import EnvironmentCapture, Method, covering_cube_size
from reflet.render.capture.moving_scene import MovingSceneRenderer
from reflet.render.device.device import shared_device
from reflet.render.maps.env_map_texture import upload_env_map
from reflet.render.materials.env_map_renderer import EnvMapRenderer, view_frame
from reflet.scene.builtin.solids import box
from reflet.scene.material import EnvironmentLight, Material
from reflet.scene.meshes.corners import weld
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.meshes.primitives import sphere_mesh, torus_mesh
from reflet.scene.meshes.tessellate import tessellated
from reflet.scene.scene import Part, Scene
from reflet.scene.sky_light import SkyLight
from reflet.scene.views.camera import Camera

METHODS: list[tuple[Method, Parameterization | None]] = [
    ("cube", None), ("dual_paraboloid", None), ("warp", GazingBall()), ("warp", LatLong()), ("warp", Octahedral()),
]  # fmt: skip
EACH = pytest.mark.parametrize(("method", "to"), METHODS, ids=str)
MIRROR = Material(base_color=(0.8, 0.9, 1.0), metallic=1.0, perceptual_roughness=0.0)
TURN = view_frame(Camera((1.0, 2.0, 0.5), (0.0, 0.0, 0.0)))


def glowing(radiance: tuple[float, float, float], double_sided: bool = False) -> Material:
    return Material(base_color=(0.0, 0.0, 0.0), metallic=0.0, emission=radiance, double_sided=double_sided)


def moved(*offsets: tuple[float, float, float]) -> np.ndarray:
    out = np.tile(np.eye(4), (len(offsets), 1, 1))
    out[:, :3, 3] = offsets
    return out


def solid_angles(image: EnvImage) -> np.ndarray:
    return np.array(image.parameterization.texel_solid_angle(image.size))[..., None]


def box_mesh(edge: float) -> Mesh:
    solid = box((0.0, 0.0, 0.0), (2.0, 2.0, 2.0), 0)
    return tessellated(weld(solid.corners, solid.normals), edge)


@EACH
@pytest.mark.parametrize("turn", [np.eye(3), TURN], ids=["straight", "turned"])
def test_an_emitter_shows_up_in_its_direction(method: Method, to: Parameterization | None, turn: np.ndarray) -> None:
    scene = Scene((Part("lamp", sphere_mesh(0.5), glowing((1.0, 2.0, 4.0))),), ())
    capture = EnvironmentCapture(shared_device(), scene, 64, method, to)
    centre = np.array([0.3, -0.2, 0.1])
    for towards in ((2.0, 1.0, 1.5), (-1.0, 2.0, -1.5), (0.2, -2.5, 0.3)):
        offset = 2.5 * np.array(towards) / np.linalg.norm(towards)
        image = capture.frame(moved(tuple(centre + offset)), tuple(centre), turn).read()
        direction, valid = image.parameterization.texel_directions(64)
        flux = image.texels[..., :3].astype(float) * solid_angles(image) * valid[..., None]
        # A sphere of radius 0.5 at 2.5 m fills 2π(1 - cos asin 0.2); inscribed by 128 it is 1e-3 smaller. Its outline
        # crosses some 35 texels of 2°, each in or out: the square root of that, times 1/√12, of some 90 texels inside.
        expected = 2.0 * np.pi * (1.0 - np.sqrt(1.0 - 0.2**2))
        np.testing.assert_allclose(flux.sum((0, 1, 2)) / (1.0, 2.0, 4.0), expected, rtol=0.06)
        centroid = (flux[..., :1] * (direction @ turn)).sum((0, 1, 2))
        # The same scatter moves the middle by a tenth of a texel or two, of 3.6° at most; near the rim of a gazing ball
        # texels are much longer.
        angle = np.degrees(np.arccos(centroid @ offset / np.linalg.norm(centroid) / 2.5))
        assert angle < (3.0 if to and to.is_view_dependent else 0.8)


@EACH
def test_the_distant_environment(method: Method, to: Parameterization | None) -> None:
    direction, _ = LatLong().texel_directions(128)
    environment = EnvironmentLight(linear(direction)[0].astype(np.float32))
    far = Part("behind", sphere_mesh(0.01, (0.0, 0.0, 50.0)), glowing((0.0, 0.0, 0.0)))
    capture = EnvironmentCapture(shared_device(), Scene((far,), (), environment), 64, method, to)
    image = capture.frame(np.eye(4)[None], (0.0, 0.0, 0.0), TURN).read()
    direction, valid = image.parameterization.texel_directions(64)
    error = np.abs(image.texels[..., :3].astype(float) - linear(direction @ TURN)).max(-1)
    # Half floats, and linear radiance filtered over texels of the environment (1.4°, at its poles coarser) and, warped,
    # of the cube; as coarse as the texels that are filled.
    loose = 4.0 if to and to.is_view_dependent else 1.0
    assert np.quantile(error[valid], 0.9) < 3e-3 * loose
    assert error[valid].max() < 0.02 * loose
    if to is None:  # beyond the rims of a dual paraboloid, too, there is the map's continuation
        assert error.max() < 0.012


@EACH
def test_inside_a_glowing_box(method: Method, to: Parameterization | None) -> None:
    """Six walls of known radiance: what is seen is a formula, away from the edges between them."""
    walls = tessellated(box_mesh(9.0), 0.2)
    normal = walls.normals[walls.triangles[:, 0]]
    axes = [*np.eye(3), *-np.eye(3)]
    colours = [(0.25 + 0.1 * k, 0.75 - 0.1 * k, 0.5) for k in range(6)]
    parts = [
        Part(
            str(k),
            Mesh(walls.positions, walls.normals, walls.triangles[normal @ axis > 0.5]),
            glowing(colours[k], True),
        )
        for k, axis in enumerate(axes)
    ]
    capture = EnvironmentCapture(shared_device(), Scene(tuple(parts), ()), 64, method, to)
    centre = np.array([0.2, -0.1, 0.3])
    image = capture.frame(np.tile(np.eye(4), (6, 1, 1)), tuple(centre)).read()
    direction, valid = image.parameterization.texel_directions(64)
    # Distance to the plane of each wall along the ray.
    with np.errstate(divide="ignore", invalid="ignore"):
        distances = [(1.0 - centre @ axis) / (direction @ axis) for axis in axes]
    distances = np.where(np.array(distances) > 0.0, distances, np.inf)
    nearest, next_nearest = np.sort(distances, 0)[:2]
    expected = np.array(colours)[distances.argmin(0)]
    # Walls are flat colours: half floats alone, where a texel (up to 5°) is clear of the edges. Warps look up coarser
    # levels where texels are long, most of all at the rim of a gazing ball.
    clear = valid & (next_nearest > (1.15 if to is None else 2.0) * nearest)
    if to and to.is_view_dependent:
        clear &= direction[..., 2] > -0.3
    assert clear.mean() > 0.1
    np.testing.assert_allclose(image.texels[..., :3].astype(float)[clear], expected[clear], atol=1e-3)


def test_paraboloids_miss_arcs_by_less_than_a_texel_where_edges_are_short() -> None:
    """The share of texels that differ from the exact map, by the angle that edges span at the eye."""
    device, size = shared_device(), 128
    offset, centre = moved((1.2, 0.4, 1.3)), (-0.5, 0.0, -0.5)
    wrong, beyond = {}, {}
    for edge in (9.0, 0.5):
        scene = Scene((Part("box", box_mesh(edge), glowing((1.0, 1.0, 1.0))),), ())
        drawn = EnvironmentCapture(device, scene, size, "dual_paraboloid").frame(offset, centre).read()
        exact = EnvironmentCapture(device, scene, size, "warp", DualParaboloid()).frame(offset, centre).read()
        _, valid = drawn.parameterization.texel_directions(size)
        a, b = (each.texels[..., 0].astype(float) for each in (drawn, exact))
        wrong[edge] = int((np.abs(a - b) > 0.5)[valid].sum())
        # Beyond one texel: none of the texels around has the value.
        around = [np.roll(b, (i, j), (1, 2)) for i in (-1, 0, 1) for j in (-1, 0, 1)]
        beyond[edge] = int((np.min([np.abs(a - each) for each in around], 0) > 0.5)[valid].sum())
    # Uncut, edges span up to 82°; of 0.5 m, 20.7°, where the limit of 128 rows is 20.3°. What is left is the outline's
    # scatter. Measured 93 and 5 texels, of them 20 and none beyond one texel.
    assert beyond[9.0] > 0 == beyond[0.5]
    assert wrong[9.0] > 4 * wrong[0.5]


def test_backs_are_black_unless_double_sided_and_light_comes_from_the_sky() -> None:
    light = SkyLight((1.0, 0.5, 0.25), (0.2, 0.4, 0.6))
    inside_out = sphere_mesh(1.0, around=256)
    for double_sided in (False, True):
        white = Material(base_color=(0.5, 0.5, 0.5), metallic=0.0, double_sided=double_sided)
        for method in ("cube", "dual_paraboloid"):
            scene = Scene((Part("shell", inside_out, white),), ())
            image = (
                EnvironmentCapture(shared_device(), scene, 32, method, light=light)
                .frame(moved((0, 0, 0)), (0, 0, 0))
                .read()
            )
            direction, valid = image.parameterization.texel_directions(32)
            expected = 0.5 * light.irradiance_over_pi(-direction) if double_sided else np.zeros_like(direction)
            # Half floats; normals interpolated over triangles of 1.4°, straight instead of round.
            np.testing.assert_allclose(image.texels[valid][..., :3].astype(float), expected[valid], atol=1.5e-3)


@EACH
def test_the_picture_mirrors_the_map_of_the_same_frame(method: Method, to: Parameterization | None) -> None:
    lamp = Part("lamp", sphere_mesh(0.5), glowing((1.0, 2.0, 4.0)))
    mirror = Part("mirror", torus_mesh(), MIRROR, reflective=True)
    renderer = MovingSceneRenderer(Scene((lamp, mirror), ()), 64, method, to)
    camera = Camera((2.0, 1.5, 3.0), (0.0, 0.0, 0.0), width=64, height=48)
    turn = view_frame(camera) if to is not None and to.is_view_dependent else np.eye(3)
    pictures = []
    for towards in ((3.0, 1.0, 0.0), (0.0, 2.0, 2.0)):
        places = moved(towards, (0.1, 0.2, 0.0))
        picture = renderer.frame(places, camera, samples=1)
        captured = renderer.capture.frame(places, (0.1, 0.2, 0.0), turn)
        levels = [captured.read(level) for level in range(captured.texture.mip_level_count)]
        torus = torus_mesh(centre=(0.1, 0.2, 0.0))
        alone = EnvMapRenderer(torus, reflectance=MIRROR.base_color)
        expected = alone.picture(upload_env_map(alone.device, levels), camera, frame=turn, samples=1, backdrop=False)
        shown = expected[..., 3] == 1.0
        # The same program on the same texels; moved by the device in float32.
        assert (np.abs(picture - expected).max(-1)[shown] > 1e-3).sum() <= 3
        pictures.append(picture)
    assert np.abs(pictures[0] - pictures[1]).max() > 0.5


def test_sizes_and_errors() -> None:
    assert covering_cube_size(LatLong(), 256) == 256
    assert covering_cube_size(GazingBall(), 256) == 128
    assert covering_cube_size(CUBE, 64) == 64
    scene = Scene((Part("lamp", sphere_mesh(), glowing((1.0, 1.0, 1.0))),), ())
    with pytest.raises(RefletError, match="needs a parameterization"):
        EnvironmentCapture(shared_device(), scene, 16, "warp")
    with pytest.raises(RefletError, match="needs a parameterization"):
        EnvironmentCapture(shared_device(), scene, 16, "cube", LatLong())
    with pytest.raises(RefletError, match="Nothing in this scene mirrors"):
        MovingSceneRenderer(scene, 16)
