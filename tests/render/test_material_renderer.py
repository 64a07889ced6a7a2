"""Environment-mapped materials on the device, against closed forms and their NumPy twins."""

import numpy as np
import pytest
from compute import run
from map_scenes import analytic_levels, linear, sphere_reflections, view_rays

from reflet.envmap.env_image import EnvImage
from reflet.envmap.env_map import EnvMap
from reflet.envmap.mip_chain import MipChain
from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS
from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.shapes import Box
from reflet.reflectance.materials.material import (
    Coated,
    Conductor,
    Dielectric,
    DielectricOverDiffuse,
    GlossyGgx,
    GlossyPhong,
    Mirror,
    SurfaceMaterial,
)
from reflet.reflectance.materials.material_maps import EnvironmentMaps, roughness_over
from reflet.reflectance.prefilter.ggx_levels import GEOMETRIC
from reflet.render.filters.live_environment import LiveEnvironment
from reflet.render.maps.env_map_texture import upload_env_map
from reflet.render.materials.env_map_renderer import EnvMapRenderer, view_frame
from reflet.render.materials.material_renderer import MaterialRenderer
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.meshes.primitives import sphere_mesh
from reflet.scene.views.camera import Camera

CAMERA = Camera((1.5, 1.2, 2.6), (0.0, 0.0, 0.0), fov_deg=50, width=72, height=60)
ALBEDO = (0.2, 0.5, 0.9)
MATERIALS = (
    Mirror((0.9, 0.5, 0.3)),
    Dielectric(1.5),
    DielectricOverDiffuse(1.5, ALBEDO),
    Coated(5.0, ALBEDO),
    Conductor((0.2, 0.9, 1.4), (3.4, 2.3, 1.9)),
    GlossyPhong(20.0, (0.6, 0.5, 0.4), ALBEDO),
    GlossyGgx(ALBEDO, 0.5, 0.4),
)
EACH = pytest.mark.parametrize("material", MATERIALS, ids=lambda material: type(material).__name__)


@pytest.fixture(scope="module")
def renderer() -> MaterialRenderer:
    """A sphere before radiance that is linear in the direction."""
    return MaterialRenderer(sphere_mesh(around=256), EnvironmentMaps(analytic_levels(CUBE, 64)[0], size=64))


LEVELS = 6  # of GGX maps: two each of 64, 32 and 16 rows


def ggx_contrast(level: int) -> float:
    """What a level leaves of linear radiance's slope: by midpoints in s = sin²(θ/2), k ∝ cos⁺/(α² + (1 - α²)s)²."""
    s = (np.arange(200_000) + 0.5) / 400_000
    square = GEOMETRIC.roughness_of_level(level, LEVELS) ** 4
    if square == 0.0:
        return 1.0
    density = (1.0 - 2.0 * s) / (square + (1.0 - square) * s) ** 2
    return float((density * (1.0 - 2.0 * s)).sum() / density.sum())


def kept_contrast(material: SurfaceMaterial, cosine: np.ndarray, footprint: np.ndarray) -> np.ndarray:
    """The same of a material's whole lobe, for pixels of this n·v and footprint."""
    if isinstance(material, GlossyPhong):
        return np.full_like(footprint, (material.phong_exponent + 1.0) / (material.phong_exponent + 2.0))
    if isinstance(material, GlossyGgx):
        roughness = roughness_over(material.lobe(cosine)[1], footprint)
        lod = [GEOMETRIC.lod_from_roughness(r, LEVELS) for r in roughness]
        return np.interp(lod, range(LEVELS), [ggx_contrast(level) for level in range(LEVELS)])
    return np.ones_like(footprint)


@EACH
def test_a_sphere_shows_the_material(renderer: MaterialRenderer, material: SurfaceMaterial) -> None:
    picture = renderer.picture(material, CAMERA, samples=1)
    direction, cosine = sphere_reflections(CAMERA)
    normal = direction - view_rays(CAMERA)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    usable = np.isfinite(cosine) & (cosine > 0.4)
    assert usable.mean() > 0.1
    if isinstance(material, GlossyGgx):
        lean = np.where(usable, material.lobe(np.where(usable, cosine, 1.0))[0], 0.0)[..., None]
        direction = direction + lean * (normal - direction)
        direction /= np.linalg.norm(direction, axis=-1, keepdims=True)
    footprint = np.maximum(*(np.linalg.norm(np.roll(direction, -1, axis) - direction, axis=-1) for axis in (0, 1)))
    specular, diffuse = material.weights(cosine[usable])
    mean, kept = linear(np.zeros(3)), kept_contrast(material, cosine[usable], footprint[usable])[:, None]
    wanted = specular * (mean + kept * (linear(direction[usable]) - mean))
    wanted += diffuse * (mean + 2.0 / 3.0 * (linear(normal[usable]) - mean))
    # Pixels see up to 0.2 radians, so that lookups are in texels of as much: interpolated between them a slope of 0.5
    # errs by 0.5·(0.2)²/8, and octahedral maps' kinks count an eighth of a texel (test_env_map_renderer).
    np.testing.assert_allclose(picture[usable][:, :3], wanted, atol=8e-3)


@pytest.fixture(scope="module")
def furnace() -> MaterialRenderer:
    return MaterialRenderer(
        sphere_mesh(), EnvironmentMaps(EnvImage(CUBE, np.ones((6, 16, 16, 3), np.float32)), size=32)
    )


@pytest.mark.parametrize(
    "material",
    [Mirror(), Coated(1.5), GlossyPhong(50.0), GlossyGgx(metallic=1.0), GlossyGgx(perceptual_roughness=0.7)],
    ids=repr,
)
def test_white_stays_white_in_a_furnace(furnace: MaterialRenderer, material: SurfaceMaterial) -> None:
    picture = furnace.picture(material, CAMERA, samples=1)
    off = np.abs(picture[..., :3] - 1.0).max(-1) > 5e-4  # the bound of every filter
    assert off.sum() <= 3  # backs that peep out at the outline are black


def test_a_furnace_shows_the_fresnel_terms(furnace: MaterialRenderer) -> None:
    _, cosine = sphere_reflections(CAMERA)
    usable = np.isfinite(cosine) & (cosine > 0.2)
    for material in (Dielectric(1.5), MATERIALS[4]):
        picture = furnace.picture(material, CAMERA, samples=1)
        wanted = material.weights(cosine[usable])[0]
        # The mesh of 128 meridians has normals off by (π/128)²/8 and a surface within 3e-4 of the sphere: F of slope 1
        # at most here, and n·v changes by sqrt(2·3e-4)/2 near the outline.
        np.testing.assert_allclose(picture[usable][:, :3], wanted, atol=6e-3)


@pytest.mark.parametrize("within", [False, True], ids=["far", "within"])
def test_a_normal_that_faces_away_reflects_by_the_ray_that_is_bent(within: bool) -> None:
    side, away = np.radians(60.0), np.radians(40.0)
    viewer = np.array([np.sin(side), 0.0, np.cos(side)])
    camera = Camera(tuple(5.0 * viewer), (0.0, 0.0, 0.0), fov_deg=1.0, width=3, height=3)
    normal = np.array([-np.sin(away), 0.0, np.cos(away)])
    mesh = Mesh(
        np.float32([[-1, -1, 0], [1, -1, 0], [0, 1, 0]]),
        np.tile(np.float32(normal), (3, 1)),
        np.uint32([[0, 1, 2]]),
    )
    bent = -viewer + 2.0 * (viewer @ normal) * normal
    bent[2] = 0.001  # just above the triangle
    cosine = 0.5 * np.linalg.norm(bent / np.linalg.norm(bent) + viewer)
    white = EnvImage(CUBE, np.ones((6, 16, 16, 3), np.float32))
    material = Dielectric(1.5)
    if within:
        box = Box((-9.0,) * 3, (9.0,) * 3, (0.0,) * 3)
        chain = MipChain(16)
        room = EnvMap(chain, np.ones((chain.texel_count, 3), np.float16), box)
        renderer = EnvMapRenderer(mesh)
        shown = renderer.picture(
            upload_env_map(renderer.device, room), camera, samples=1, material=renderer.programs.material(material)
        )
    else:
        shown = MaterialRenderer(mesh, EnvironmentMaps(white, size=16)).picture(material, camera, samples=1)
    # Of the slope of F there, 2, a view ray that leaves the middle by half a pixel, 0.003 rad.
    assert shown[1, 1, 0] == pytest.approx(material.weights(np.array([cosine]))[0].ravel()[0], abs=2e-3)


def test_a_turned_environment_is_turned_back() -> None:
    turn = view_frame(Camera((1.0, 2.0, 0.5), (0.0, 0.0, 0.0)))
    image = analytic_levels(CUBE, 64, lambda d: linear(d @ turn))[0]
    material = MATERIALS[2]
    picture = MaterialRenderer(sphere_mesh(around=256), image).picture(material, CAMERA, frame=turn, samples=1)
    straight = MaterialRenderer(sphere_mesh(around=256), analytic_levels(CUBE, 64)[0]).picture(
        material, CAMERA, samples=1
    )
    covered = sphere_reflections(CAMERA)[1] > 0.4
    np.testing.assert_allclose(picture[covered], straight[covered], atol=5e-3)  # two grids of texels, as above


@pytest.mark.parametrize("by_paraboloids", [False, True])
def test_live_pictures_are_those_of_a_still_environment(by_paraboloids: bool) -> None:
    """The environment changes, and the exponent."""
    live = LiveEnvironment(64, by_paraboloids=by_paraboloids)
    renderer = MaterialRenderer(sphere_mesh(), live)
    inside = sphere_reflections(CAMERA)[1] > 0.4
    for flip, exponent in ((1.0, 50.0), (-1.0, 9.0)):
        image = analytic_levels(PARAMETERIZATIONS["latlong"], 64, lambda d, flip=flip: linear(flip * d))[0]
        live.show(image)
        for material in (
            GlossyPhong(exponent, (0.7, 0.7, 0.7), (0.3, 0.3, 0.3)),
            GlossyGgx(ALBEDO, 0.5, 0.4),
            Coated(2.0),
        ):
            by_cpu = MaterialRenderer(sphere_mesh(), EnvironmentMaps(image, 64)).picture(material, CAMERA, samples=1)
            by_device = renderer.picture(material, CAMERA, samples=1)
            # Two grids of texels, 8e-3 each (above). The paper's filter loses the lobe's tails: of N = 9's contrast of
            # 10/11 some hundredths more is kept.
            np.testing.assert_allclose(by_device[inside], by_cpu[inside], atol=0.03 if by_paraboloids else 0.016)
            outside = by_cpu[..., 3] == 0.0
            np.testing.assert_array_equal(by_device[outside], by_cpu[outside])


def test_nothing_behind_where_none_is_asked_for(furnace: MaterialRenderer) -> None:
    picture = furnace.picture(Coated(1.5), CAMERA, backdrop=False, samples=1)
    assert (picture[picture[..., 3] == 0.0] == 0.0).all()


def test_fresnel_weights_stay_twins_at_the_horizon() -> None:
    """The shader's formula is fed with n·v itself here: the sphere's outline has too few pixels to tell."""
    cosine = np.linspace(0.0, 1.0, 101)
    code = """
    #import fresnel
    let f = fresnel_dielectric(1.5, in0[i]);
    out[2*i] = f; out[2*i+1] = (1.0 - f) * 0.5;
    """
    shader = run(code, [cosine[:, None]], 2)
    specular, diffuse = Coated(1.5, (0.5, 0.5, 0.5)).weights(cosine)
    np.testing.assert_allclose(shader, np.stack([specular[:, 0], diffuse[:, 0]], -1), atol=2e-6)  # test_fresnel_twin


def test_the_shader_finds_the_levels_of_roughness() -> None:
    roughness = np.linspace(0.0, 1.0, 201)
    shader = run("#import ggx_lod\nout[i] = ggx_lod(in0[i], 4.0);", [roughness[:, None]], 1)[:, 0]
    wanted = [GEOMETRIC.lod_from_roughness(r, 5) for r in roughness]
    np.testing.assert_allclose(shader, wanted, atol=2e-5)  # float32's log2
    # Lobes widen by one factor from level to level, but for the 0.0055 that a mirror's counts as.
    square = np.array([GEOMETRIC.roughness_of_level(level, 5) for level in range(5)]) ** 4 + 0.0055**2
    np.testing.assert_allclose(square[1:] / square[:-1], (1.0 + 0.0055**-2) ** 0.25, rtol=1e-3)  # 1 + 0.0055² at last
