"""Mitsuba's XML scenes."""

import warnings
from contextlib import nullcontext
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from reflet.errors import RefletError, RefletWarning
from reflet.scene.scene import Scene
from reflet.trace.mitsuba_files.mitsuba_xml import read_mitsuba_orbit, read_mitsuba_xml

BENCH = Path(__file__).parents[2].parent / "shared/data/bench"

SHAPES = """
<scene version="3.0.0">
  <default name="r" value="2"/>
  <sensor type="perspective">
    <float name="fov" value="30"/><string name="fov_axis" value="y"/>
    <transform name="to_world"><lookat origin="8,2,3" target="1,2,3" up="0,1,0"/></transform>
    <film type="hdrfilm"><integer name="width" value="320"/><integer name="height" value="200"/></film>
  </sensor>
  <shape type="sphere" id="ball">
    <point name="center" x="1" y="2" z="3"/><float name="radius" value="$r"/>
    <bsdf type="roughconductor"><string name="material" value="Au"/><float name="alpha" value="0.04"/>
      <string name="distribution" value="ggx"/></bsdf>
  </shape>
  <shape type="rectangle" id="card">
    <transform name="to_world"><scale value="3"/></transform>
    <bsdf type="twosided"><bsdf type="diffuse">
      <texture type="bitmap" name="reflectance"><string name="filename" value="card.png"/></texture>
    </bsdf></bsdf>
  </shape>
  <shape type="disk" id="lamp">
    <bsdf type="diffuse"><spectrum name="reflectance" value="0.25"/></bsdf>
    <emitter type="area"><rgb name="radiance" value="3 2 1"/></emitter>
  </shape>
  <shape type="cylinder" id="pipe"><boolean name="flip_normals" value="true"/>
    <bsdf type="principled">
      <rgb name="base_color" value=".1 .5 .9"/><float name="metallic" value="1"/><float name="roughness" value="0"/>
    </bsdf>
  </shape>
  <shape type="cube" id="die"/>
  <emitter type="constant"><rgb name="radiance" value="0.2 0.3 0.4"/></emitter>
</scene>"""


def write(folder: Path, text: str) -> Path:
    (folder / "scene.xml").write_text(text)
    return folder / "scene.xml"


@pytest.fixture(scope="module")
def shapes(tmp_path_factory: pytest.TempPathFactory) -> Scene:
    folder = tmp_path_factory.mktemp("shapes")
    Image.fromarray(np.arange(24, dtype=np.uint8).reshape(2, 4, 3) * 10).save(folder / "card.png")
    with pytest.warns(RefletWarning, match="Conductors reflect by Schlick.*: ball"):
        return read_mitsuba_xml(write(folder, SHAPES))


def test_shapes_become_closed_form_meshes(shapes: Scene) -> None:
    parts = {part.name: part.mesh for part in shapes.parts}
    ball = parts["ball"].positions - np.array([1, 2, 3])
    np.testing.assert_allclose(np.linalg.norm(ball, axis=-1), 2.0, rtol=1e-6)
    np.testing.assert_allclose(parts["ball"].normals, ball / 2.0, atol=1e-6)
    assert np.ptp(parts["card"].positions, axis=0).tolist() == [6.0, 6.0, 0.0]
    # the cylinder's normals are flipped: inwards
    radial = parts["pipe"].positions * [1, 1, 0]
    np.testing.assert_allclose(parts["pipe"].normals, -radial, atol=1e-6)
    for mesh in parts.values():
        corners = mesh.positions[mesh.triangles]
        across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        assert (np.einsum("ti,ti->t", across, mesh.normals[mesh.triangles].sum(1)) > 0).all()


def test_materials_and_lights_keep_their_values(shapes: Scene) -> None:
    materials = {part.name: part.material for part in shapes.parts}
    gold = materials["ball"]
    # normal reflectance of gold, a public fact: yellow
    np.testing.assert_allclose(gold.base_color, [1.0, 0.78, 0.34], atol=0.05)
    assert gold.metallic == 1.0 and gold.perceptual_roughness == pytest.approx(0.2)
    card = materials["card"]
    assert card.double_sided and card.metallic == 0.0
    assert card.base_color_texture_srgb is not None
    np.testing.assert_array_equal(
        card.base_color_texture_srgb.pixels[..., :3], np.arange(24).reshape(2, 4, 3) * 10
    )  # row 0 stays at the top, every code as it was
    assert materials["lamp"].emission == pytest.approx((3.0, 2.0, 1.0))
    assert materials["lamp"].base_color == pytest.approx((0.25, 0.25, 0.25))
    assert materials["pipe"].base_color == pytest.approx((0.1, 0.5, 0.9))
    assert materials["die"].base_color == pytest.approx((0.5, 0.5, 0.5))
    assert {part.name for part in shapes.parts if part.reflective} == {"ball", "pipe"}
    assert shapes.environment is not None
    np.testing.assert_allclose(shapes.environment.radiance[0, 0], [0.2, 0.3, 0.4], rtol=1e-6)


def test_camera_becomes_an_orbit(shapes: Scene, tmp_path: Path) -> None:
    text = SHAPES.replace('value="card.png"', 'value="scene.xml"')  # the camera alone is read
    orbit = read_mitsuba_orbit(write(tmp_path, text), shapes)
    assert orbit.fov_deg == pytest.approx(30.0, abs=1e-4)
    assert orbit.image_size == 200
    np.testing.assert_allclose(orbit.camera().position, [8.0, 2.0, 3.0], atol=1e-5)
    forward = np.subtract(orbit.target, (8.0, 2.0, 3.0))
    np.testing.assert_allclose(forward / np.linalg.norm(forward), [-1.0, 0.0, 0.0], atol=1e-6)


def test_environment_is_turned_to_the_projects_convention(tmp_path: Path) -> None:
    """Mitsuba's picture starts behind +z; ours has +x in its middle. A mark seen from the camera tells."""
    picture = np.zeros((32, 64, 3), np.float32)
    picture[10, 20] = 1000.0
    import mitsuba as mi

    from reflet.trace.variant import use_variant

    use_variant()
    mi.Bitmap(picture).write(str(tmp_path / "sky.exr"))
    text = """<scene version="3.0.0"><shape type="sphere"><bsdf type="principled"><float name="metallic" value="1"/>
      <float name="roughness" value="0"/></bsdf></shape>
      <emitter type="envmap"><string name="filename" value="sky.exr"/></emitter></scene>"""
    what = read_mitsuba_xml(write(tmp_path, text))
    assert what.environment is not None
    found = what.environment.radiance.sum(-1)
    row, column = np.unravel_index(found.argmax(), found.shape)
    phi, theta = ((column + 0.5) / found.shape[1] - 0.5) * 2 * np.pi, (row + 0.5) / found.shape[0] * np.pi
    ours = [np.cos(phi) * np.sin(theta), np.cos(theta), np.sin(phi) * np.sin(theta)]
    # Mitsuba: u = atan2(x, -z)/2π, v = acos(y)/π
    u, v = 20.5 / 64 * 2 * np.pi, 10.5 / 32 * np.pi
    theirs = [np.sin(u) * np.sin(v), np.cos(v), -np.cos(u) * np.sin(v)]
    assert np.degrees(np.arccos(np.dot(ours, theirs))) < 6.0, "within a pixel of 5.6°"


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("<scene", "Mitsuba cannot read"),
        ('<scene version="3.0.0"><shape type="hair"/></scene>', "hair0 is of type hair"),
        ('<scene version="3.0.0"><shape type="ply"><string name="filename" value="no.ply"/></shape></scene>', "no.ply"),
        ('<scene version="3.0.0"><shape type="cube"><bsdf type="hair"/></shape></scene>', "BSDF hair of cube0"),
        (
            '<scene version="3.0.0"><shape type="cube"/><emitter type="projector"/></scene>',
            "Nothing in the scene",
        ),
        (
            '<scene version="3.0.0"><shape type="cube"><float name="maxAngle" value="3"/></shape></scene>',
            "max_?[aA]ngle",
        ),
        ('<scene version="3.0.0"><path value="nowhere"/></scene>', "nowhere. not found"),
        ('<scene version="3.0.0"><shape type="instance"/></scene>', "instance0 is of no shapegroup"),
        (
            '<scene version="3.0.0"><shape type="cube"/><emitter type="constant"/><emitter type="constant"/></scene>',
            "2 environments .constant, constant., and Mitsuba takes one",
        ),
    ],
)
def test_what_has_no_counterpart_is_one_sentence(tmp_path: Path, text: str, says: str) -> None:
    left_out = pytest.warns(RefletWarning, match="no counterpart are left out: projector 1")
    with left_out if "projector" in text else nullcontext(), pytest.raises(RefletError, match=says) as caught:
        read_mitsuba_xml(write(tmp_path, text))
    assert "\n" not in str(caught.value)


@pytest.mark.skipif(not BENCH.exists(), reason="needs the shared test data")
def test_bench_scene_reads_as_its_gltf_twin() -> None:
    from reflet.pipelines.load import load_scene

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RefletWarning)
        xml = read_mitsuba_xml(BENCH / "mitsuba/teapot-bench.xml")
    glb = load_scene(BENCH / "teapot-bench.glb")
    assert len(xml.objects) == 1 and len(xml.objects[0].parts) == 4
    assert sum(len(part.mesh.triangles) for part in xml.parts if part.reflective) == 39_800
    by_name = {part.name: part for part in glb.parts}
    for part in xml.parts:
        twin = by_name[part.name]
        assert part.reflective == twin.reflective
        assert part.material.double_sided == twin.material.double_sided
        assert part.material.emission == pytest.approx(twin.material.emission)
        np.testing.assert_allclose(part.mesh.positions.min(0), twin.mesh.positions.min(0), atol=1e-5)
        np.testing.assert_allclose(part.mesh.positions.max(0), twin.mesh.positions.max(0), atol=1e-5)
    room = next(part for part in xml.parts if part.name == "room")
    assert room.material.base_color_texture_srgb is not None
    twin_texture = by_name["room"].material.base_color_texture_srgb
    assert twin_texture is not None
    np.testing.assert_array_equal(room.material.base_color_texture_srgb.pixels, twin_texture.pixels)
