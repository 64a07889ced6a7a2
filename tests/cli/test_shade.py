"""``reflet shade``: pictures of materials, and what it refuses."""

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from reflet.cli.main import main
from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS
from reflet.envmap.rotations import turn_about_vertical
from reflet.errors import RefletWarning
from reflet.files.env_image_file import read_env_image, write_env_image
from reflet.files.ior_file import read_spectral_index
from reflet.files.pictures.exr import read_exr
from reflet.pipelines.shade import frame_mesh, load_mesh, own_material, shade, surface_material
from reflet.reflectance.brdfs.spectral import index_rgb
from reflet.reflectance.materials.material import Coated, GlossyGgx, GlossyPhong
from reflet.reflectance.materials.material_maps import EnvironmentMaps
from reflet.reflectance.materials.metals import METALS
from reflet.render.materials.parts_renderer import PartsRenderer, ShadedPart
from reflet.scene.material import Material, Texture
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.views.camera import Camera

LATLONG = PARAMETERIZATIONS["latlong"]
IOR = Path(__file__).parents[2] / "../shared/data/ior"


def reflet(*arguments: str | Path) -> int:
    with pytest.raises(SystemExit) as stop:
        main([str(argument) for argument in arguments])
    return stop.value.code or 0


@pytest.fixture(scope="module")
def white(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("environment") / "white.exr"
    write_env_image(path, [EnvImage(LATLONG, np.ones((1, 16, 32, 3), np.float32))])
    return path


@pytest.mark.parametrize("mesh", ["sphere", "torus", "teapot", "ring.obj"])
@pytest.mark.parametrize("material", ["coated:1.5", "ggx:0.4"])
def test_white_meshes_vanish_in_a_white_room(
    white: Path, tmp_path: Path, scene_files: tuple[Path, Path], mesh: str, material: str
) -> None:
    source = scene_files[0] if mesh == "ring.obj" else mesh
    out = tmp_path / "out.exr"
    assert reflet("shade", source, white, "--material", material, "--size", "48", "--samples", "1", "-o", out) == 0
    picture = read_exr(out)
    assert picture.shape == (48, 48, 3)
    # Backs of the open teapot are black.
    assert (np.abs(picture - 1.0).max(-1) > 1e-3).mean() < (0.02 if mesh == "teapot" else 0.002)


def test_a_png_without_backdrop_is_transparent(white: Path, tmp_path: Path) -> None:
    out = tmp_path / "out.png"
    common = ["shade", "sphere", white, "--material", "phong:20", "--albedo", "0.2,0.2,0.2", "--size", "32"]
    assert reflet(*common, "--no-backdrop", "-o", out) == 0
    picture = np.asarray(Image.open(out))
    assert picture.shape == (32, 32, 4)
    assert picture[0, 0, 3] == 0 and picture[16, 16, 3] == 255
    edge = (picture[..., 3] > 60) & (picture[..., 3] < 250)
    # Not premultiplied: the edge is as white, 1 - exp(-1.6) in sRGB, as the middle; of 16 samples some saw a back.
    assert np.abs(picture[edge][:, 0].astype(int) - picture[16, 16, 0]).mean() < 4.0
    brighter = tmp_path / "brighter.png"
    assert reflet(*common, "--exposure", "3", "-o", brighter) == 0
    assert np.asarray(Image.open(brighter))[16, 16, 0] > picture[16, 16, 0]


def test_the_environment_turns_counter_clockwise() -> None:
    # What lay towards +x comes to lie towards -z: the map's +x is found there.
    np.testing.assert_allclose(turn_about_vertical(90.0) @ [0.0, 0.0, -1.0], [1.0, 0.0, 0.0], atol=1e-12)


def test_the_camera_goes_where_it_is_told(white: Path) -> None:
    orbit = frame_mesh(load_mesh("torus"), azimuth_deg=90.0, elevation_deg=0.0, distance=4.0)
    np.testing.assert_allclose(orbit.camera().position, (0.0, 0.0, -4.0), atol=1e-6)
    near, far = (
        shade("sphere", white, "mirror", distance=distance, image_size=32, samples=1)[..., 3].mean()
        for distance in (4.0, 8.0)
    )
    assert 3.0 < near / far < 6.0


def test_parts_show_their_own_materials(white: Path) -> None:
    """In white light a metal shows its base colour, from behind only where it is double-sided."""
    maps = EnvironmentMaps(read_env_image(white), size=32)
    front = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0]], np.float32)
    flat = Mesh(front, np.tile(np.float32([0, 0, 1]), (3, 1)), np.array([[0, 1, 2]], np.uint32))
    turned = Mesh(front * np.float32([-1, -1, 1]), flat.normals, flat.triangles)
    metal = own_material(Material(base_color=(0.9, 0.5, 0.2), metallic=1.0, perceptual_roughness=0.3))
    parts = [ShadedPart(flat, metal), ShadedPart(turned, metal, double_sided=True)]
    renderer = PartsRenderer(parts, maps)
    for eye, backs in ((4.0, False), (-4.0, True)):
        camera = Camera((0.0, 0.0, eye), (0.0, 0.0, 0.0), fov_deg=30.0, width=32, height=32)
        picture = renderer.picture(camera, samples=1, backdrop=False)
        right, left = picture[20, 16 + (5 if not backs else -5)], picture[12, 16 + (-5 if not backs else 5)]
        assert right[3] == left[3] == 1.0
        # Schlick's term and what bounces twice nearly cancel straight on.
        np.testing.assert_allclose(left[:3], metal.base_color, atol=5e-3)
        np.testing.assert_allclose(right[:3], np.zeros(3) if backs else metal.base_color, atol=5e-3)


def test_glass_is_said_to_be_opaque(tmp_path: Path, white: Path) -> None:
    extensions = {"KHR_materials_transmission": {"transmissionFactor": 1}}
    corners = np.float32([[-1, -1, 0], [1, -1, 0], [0, 1, 0]])
    document = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "name": "pane"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
        "materials": [{"pbrMetallicRoughness": {"metallicFactor": 0}, "extensions": extensions}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "buffers": [{"uri": "corners.bin", "byteLength": 36}],
    }
    (tmp_path / "corners.bin").write_bytes(corners.tobytes())
    (tmp_path / "pane.gltf").write_text(json.dumps(document))
    with pytest.warns(RefletWarning, match=r"Glass is shown opaque here: pane\."):
        shade(tmp_path / "pane.gltf", white, "gltf", image_size=16, samples=1)


def test_textures_count_by_their_mean() -> None:
    half = np.zeros((2, 2, 4), np.uint8)
    half[0] = 255
    texture = Texture(half)
    material = Material(base_color_texture_srgb=texture, metallic_roughness_texture=texture, perceptual_roughness=0.5)
    assert own_material(material) == GlossyGgx((0.5, 0.5, 0.5), 0.5, 0.25)


def test_materials_by_name() -> None:
    assert surface_material("coated:1.33", (0.1, 0.2, 0.3)) == Coated(1.33, (0.1, 0.2, 0.3))
    phong = surface_material("phong:50", (0.25, 0.5, 1.0))
    assert phong == GlossyPhong(50.0, (0.75, 0.5, 0.0), (0.25, 0.5, 1.0))  # the lobe gets what the albedo leaves
    assert surface_material("conductor:Au") is METALS["Au"]


@pytest.mark.skipif(not IOR.exists(), reason="needs ../shared/data")
@pytest.mark.parametrize("file", ["Au_Johnson", "Ag_Johnson", "Cu_Johnson", "Al_Rakic"])
def test_metals_are_those_of_the_tables(file: str) -> None:
    n, k = index_rgb(read_spectral_index(IOR / f"{file}.yml"))
    metal = METALS[file[:2]]
    cosine = np.linspace(0.0, 1.0, 33)
    given = surface_material(f"conductor:{IOR / file}.yml").weights(cosine)[0]
    np.testing.assert_allclose(metal.weights(cosine)[0], given, atol=2e-4)  # four decimals of n and k
    np.testing.assert_allclose(metal.n, n, atol=1e-3)
    np.testing.assert_allclose(metal.k, k, atol=1e-3)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["teapot", "{white}", "--material", "wood", "-o", "out.png"], "one of mirror"),
        (["teapot", "{white}", "--material", "coated", "-o", "out.png"], "such as coated:1.5"),
        (["teapot", "{white}", "--material", "phong:0", "-o", "out.png"], "greater than 0"),
        (["teapot", "{white}", "--material", "ggx:1.5", "-o", "out.png"], "between 0 and 1"),
        (["teapot", "{white}", "--material", "mirror:2", "-o", "out.png"], "takes no number"),
        (["teapot", "{white}", "--material", "conductor:Pb", "-o", "out.png"], "Au, Ag, Cu, Al"),
        (["teapot", "{white}", "--material", "coated:1.5", "--albedo", "2,0,0", "-o", "out.png"], "share of light"),
        (["teapot", "{white}", "--material", "gltf", "-o", "out.png"], "choose another"),
        (["teapot", "{white}", "--material", "mirror", "-o", "out.gif"], "a .png or an .exr"),
        (["kettle", "{white}", "--material", "mirror", "-o", "out.png"], "sphere, torus, teapot"),
        (["kettle.glb", "{white}", "--material", "mirror", "-o", "out.png"], "does not exist"),
        (["teapot", "nowhere.hdr", "--material", "mirror", "-o", "out.png"], "nowhere.hdr"),
        (["teapot", "{white}", "--material", "mirror", "--distance", "-1", "-o", "out.png"], "positive"),
        (["teapot", "{white}", "--material", "mirror", "--turn", "inf", "-o", "out.png"], "degrees"),
        (["teapot", "{white}", "--material", "mirror", "--exposure", "-1", "-o", "out.png"], "above 0"),
        (["teapot", "{white}", "--material", "mirror", "--exposure", "nan", "-o", "out.png"], "above 0"),
        (["teapot", "{white}", "--material", "table:{white}", "-o", "out.png"], "no .npz archive of arrays"),
    ],
)
def test_bad_input_ends_in_a_sentence(
    white: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    arguments: list[str],
    words: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    assert reflet("shade", *(argument.format(white=white) for argument in arguments)) == 2
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1 and lines[0].startswith("reflet: ") and words in lines[0]
    assert not list(tmp_path.glob("out*"))
