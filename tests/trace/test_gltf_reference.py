"""The path traced reference with glTF's materials: textures, normal maps and sides are where they belong."""

import warnings
from dataclasses import replace

import numpy as np
import pytest
from trace_scenes import camera, constant_light, quad, scene, sphere

from reflet.errors import RefletError, RefletWarning
from reflet.reflectance.brdfs.dfg import dfg
from reflet.scene.material import CLAMPS, EnvironmentLight, Material, Refraction, Texture
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.scene import Part
from reflet.trace.references import path_reference
from reflet.trace.references.path_reference import PathReference

PLATE = quad((-1, -1, 0), (2, 0, 0), (0, 2, 0))
LEAN = np.array([200, 165, 225, 255], np.uint8)  # a texel that leans to its right and to green's side


def uneven_light() -> EnvironmentLight:
    """No two directions alike, and smooth."""
    v, u = np.mgrid[0:32, 0:64] / 32.0 * np.pi
    wave = np.stack([np.cos(u), np.sin(u), np.cos(2 * u)], -1) * np.sin(v)[..., None]
    return EnvironmentLight((1.0 + 0.8 * wave + 0.4 * np.cos(v)[..., None]).astype(np.float32))


def picture(part: Part, light: EnvironmentLight, spp: int = 16, size: int = 24, **more: object) -> np.ndarray:
    view = camera((0.6, 0.4, 3.0), size)
    return PathReference(scene([part], [], light), materials="gltf", **more).picture(view, spp=spp, max_depth=4)  # type: ignore[arg-type]


def plate(material: Material, mesh: Mesh = PLATE) -> Part:
    return Part("plate", mesh, material)


def with_normals(mesh: Mesh, normal: np.ndarray) -> Mesh:
    """The mesh with one shading normal of its own."""
    return replace(mesh, normals=np.tile(normal / np.linalg.norm(normal), (len(mesh.positions), 1)).astype(np.float32))


def local_normal(scale: float) -> np.ndarray:
    return (2.0 * LEAN[:3] / 255.0 - 1.0) * [scale, scale, 1.0]


@pytest.mark.parametrize("roughness", [0.0, 0.4])
@pytest.mark.parametrize(
    ("tangent", "across"),
    [
        ((1.0, 0.0, 0.0, -1.0), (0.0, -1.0, 0.0)),  # v runs down the texture, along +y here
        ((-1.0, 0.0, 0.0, 1.0), (0.0, -1.0, 0.0)),  # u mirrored
        ((1.0, 0.0, 0.0, 1.0), (0.0, 1.0, 0.0)),  # v mirrored
    ],
)
def test_bumps_lean_where_tangents_and_their_handedness_say(
    tangent: tuple[float, ...], across: tuple[float, float, float], roughness: float
) -> None:
    """As a plate does whose own normals lean so; with the same random numbers, sample by sample."""
    material = Material("bumpy", (0.9, 0.6, 0.3), 0.5, roughness)
    texture = Texture(np.tile(LEAN, (2, 2, 1)))
    bumpy = replace(material, normal_texture=texture, normal_scale=0.8)
    mesh = replace(PLATE, tangents=np.tile(np.array(tangent, np.float32), (4, 1)))
    x, y, z = local_normal(0.8)
    leaning = with_normals(PLATE, x * np.array(tangent[:3]) + y * np.array(across) + z * np.array([0.0, 0.0, 1.0]))
    with warnings.catch_warnings():
        warnings.simplefilter("error", RefletWarning)
        mapped = picture(plate(bumpy, mesh), uneven_light())
    expected = picture(plate(material, leaning), uneven_light())
    # Normals differ by float32's rounding, and so do a few samples at the edge between two lobes.
    assert np.quantile(np.abs(mapped - expected), 0.99) < 1e-4
    assert np.abs(picture(plate(material), uneven_light()) - expected).max() > 0.05, "the bumps must tell"


def test_each_half_of_a_plate_with_mirrored_texture_leans_its_own_way() -> None:
    """One mesh, two handednesses, which are told by each triangle's first vertex."""
    left, right = quad((-1, -1, 0), (1, 0, 0), (0, 2, 0)), quad((0, -1, 0), (1, 0, 0), (0, 2, 0))
    both = Mesh(
        np.concatenate([left.positions, right.positions]),
        np.concatenate([left.normals, right.normals]),
        np.concatenate([left.triangles, right.triangles + np.uint32(4)]),
        np.concatenate([left.uv, right.uv * np.array([-1, 1], np.float32)]),
        np.repeat(np.array([[1, 0, 0, -1], [-1, 0, 0, 1]], np.float32), 4, axis=0),
    )  # fmt: skip
    chrome = Material("chrome", (1.0, 1.0, 1.0), 1.0, 0.0)
    bumpy = replace(chrome, normal_texture=Texture(np.tile(LEAN, (1, 1, 1))))
    mapped = picture(plate(bumpy, both), uneven_light(), spp=4)
    x, y, z = local_normal(1.0)
    normals = np.repeat(np.array([[x, -y, z], [-x, -y, z]]), 4, axis=0)
    own = replace(both, normals=(normals / np.linalg.norm(normals[0])).astype(np.float32))
    np.testing.assert_allclose(mapped, picture(plate(chrome, own), uneven_light(), spp=4), atol=1e-4)


def test_textures_say_colour_roughness_and_metal() -> None:
    """Four texels, each seen along the normal in its middle, in a furnace of radiance 2, by single scattering."""
    color = np.full((2, 2, 4), 255, np.uint8)
    color[0, 0, :3] = (188, 0, 255)  # 188 is 0.5 in linear light
    other = np.zeros((2, 2, 4), np.uint8)  # red says nothing, green is roughness and blue metal
    other[0, 0], other[0, 1] = (0, 255, 255, 255), (255, 0, 255, 255)
    other[1, 0], other[1, 1] = (0, 128, 255, 255), (0, 255, 0, 255)
    material = Material(
        "four", (1.0, 0.5, 1.0), 0.9, 0.8, base_color_texture_srgb=Texture(color, CLAMPS),
        metallic_roughness_texture=Texture(other, CLAMPS),
    )  # fmt: skip
    reference = PathReference(
        scene([plate(material)], [], constant_light(2.0)), materials="gltf", single_scattering=True
    )
    half = ((188 / 255 + 0.055) / 1.055) ** 2.4
    white = np.array([1.0, 0.5, 1.0])
    for u, v, base, metallic, roughness in [
        (0, 0, white * [half, 0.0, 1.0], 0.9, 0.8), (1, 0, white, 0.9, 0.0), (0, 1, white, 0.9, 0.8 * 128 / 255),
        (1, 1, white, 0.0, 0.8),
    ]:  # fmt: skip
        count = 1 << 14
        eye = np.tile(np.array([u - 0.5, v - 0.5, 3.0], np.float32), (count, 1))  # v runs along +y here
        down = np.tile(np.array([0.0, 0.0, -1.0], np.float32), (count, 1))
        found = reference.along(eye, down, max_depth=3)
        a, b = dfg(np.array([1.0]), roughness**2)[0]
        # ∫ (1 - F(v·h))·cos θ/π: the fifth power of 1 - cos(θ/2) gives 8e-5
        paint = 0.04 * a + b + base * (0.96 - 8e-5)
        wanted = 2.0 * ((1.0 - metallic) * paint + metallic * (base * a + b))
        # 5 standard errors, and dfg's own
        error = 5.0 * found.std(0) / np.sqrt(count) + 1e-3
        np.testing.assert_array_less(np.abs(found.mean(0) - wanted), error, err_msg=f"{u} {v}")


def test_every_part_has_its_whole_material_whether_it_reflects_or_not() -> None:
    gold = Material("gold", (1.0, 0.8, 0.3), 1.0, 0.3)
    one, other = (
        PathReference(scene([Part("ball", sphere(), gold, reflective)], [(0,)] if reflective else [], uneven_light()),
                      materials="gltf").picture(camera(), spp=4, max_depth=4)
        for reflective in (False, True)
    )  # fmt: skip
    np.testing.assert_array_equal(one, other)

    glass = Material("glass", refraction=Refraction(1.5, attenuation_color=(0.5, 0.9, 0.5), attenuation_distance=1.0))
    whole = picture(Part("ball", sphere(), glass), uneven_light(), spp=4)
    with_mirrors = scene([Part("ball", sphere(), glass, True)], [(0,)], uneven_light())
    expected = PathReference(with_mirrors).picture(camera((0.6, 0.4, 3.0), 24), spp=4, max_depth=4)
    np.testing.assert_array_equal(whole, expected)


@pytest.mark.parametrize("double_sided", [False, True])
def test_only_double_sided_faces_have_backs(double_sided: bool) -> None:
    material = Material("foil", (0.9, 0.9, 0.9), 0.5, 0.5, double_sided=double_sided)
    what = scene([plate(material)], [], constant_light(1.0))
    back = PathReference(what, materials="gltf").picture(camera((0.0, 0.1, -3.0), 8), spp=64, max_depth=3)[3:5, 3:5]
    # white keeps nearly all of it; 4 · 64 samples of deviation 0.3
    assert back.mean() == pytest.approx(0.9 if double_sided else 0.0, abs=0.06)


def test_bumps_of_backs_lean_as_those_of_fronts_glowing_or_not() -> None:
    """What glows on both sides has a second mesh behind the first."""
    foil = Material("foil", (1.0, 1.0, 1.0), 1.0, 0.0, double_sided=True, normal_texture=Texture(LEAN.reshape(1, 1, 4)))
    mesh = replace(PLATE, tangents=np.tile(np.array([1, 0, 0, -1], np.float32), (4, 1)))
    x, y, z = local_normal(1.0)
    leaning = with_normals(PLATE, np.array([x, -y, z]))
    behind = camera((0.6, 0.4, -3.0), 24)

    def seen(material: Material, shape: Mesh) -> np.ndarray:
        what = scene([plate(material, shape)], [], uneven_light())
        return PathReference(what, materials="gltf").picture(behind, spp=4, max_depth=3)

    expected = seen(replace(foil, normal_texture=None), leaning)
    dark, glowing = seen(foil, mesh), seen(replace(foil, emission=(0.5, 0.25, 0.0)), mesh)
    np.testing.assert_allclose(dark, expected, atol=1e-4)
    middle = slice(10, 14)
    # a few micrometres apart, the plates' mirrored rays are the same but for rounding
    np.testing.assert_allclose((glowing - dark)[middle, middle], np.tile([0.5, 0.25, 0.0], (4, 4, 1)), atol=1e-4)


def test_single_scattering_loses_light() -> None:
    white = plate(Material("white", (1.0, 1.0, 1.0), 1.0, 1.0))
    kept, lost = (
        picture(white, constant_light(1.0), 256, single_scattering=single)[12, 12] for single in (False, True)
    )
    # 256 samples of deviation 0.3 times the gain of 3; without it 1 - ln 2 along the normal, some more at 15°
    np.testing.assert_allclose(kept, 1.0, atol=0.2)
    np.testing.assert_allclose(lost, 0.32, atol=0.07)


def test_passes_of_a_large_picture_are_independent(monkeypatch: pytest.MonkeyPatch) -> None:
    part = plate(Material("white", (1.0, 1.0, 1.0), 0.0, 1.0))
    truth = picture(part, uneven_light(), 4096)
    whole = np.abs(picture(part, uneven_light(), 64) - truth).mean()
    monkeypatch.setattr(path_reference, "LANES", 24 * 24 * 4)
    pieces = np.abs(picture(part, uneven_light(), 64) - truth).mean()
    # 24² pixels tell noise to some per cent; passes with one seed would have four times as much of it
    assert pieces == pytest.approx(whole, rel=0.2)
    assert pieces > 0.0


def test_other_materials_are_refused_in_a_sentence() -> None:
    with pytest.raises(RefletError, match="one of mirrors, gltf, not 'glossy'"):
        PathReference(scene([plate(Material())], []), materials="glossy")
