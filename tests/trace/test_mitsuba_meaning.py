"""What Mitsuba's XML means, asked of Mitsuba itself: where surfaces are and face, what is around them, and colours."""

import warnings
from pathlib import Path

import mitsuba as mi
import numpy as np
import pytest
from PIL import Image

from reflet.errors import RefletError, RefletWarning
from reflet.files.pictures.exr import write_exr
from reflet.scene.scene import Scene
from reflet.trace.mitsuba_files.mitsuba_xml import read_mitsuba_orbit, read_mitsuba_xml
from reflet.trace.variant import use_variant

MIRROR = '<bsdf type="conductor"><string name="material" value="none"/></bsdf>'
SKY = '<emitter type="constant"/>'
# A corner of three quads whose normals point to its inside, the third one wound the other way round.
CORNER = """
v 0 0 0
v 2 0 0
v 2 1 0
v 0 1 0
v 0 0 3
v 0 1 3
v 2 0 3
vt 0 0
vt 1 0
vt 1 1
vt 0 1
vn 0 0 1
vn 1 0 0
vn 0 1 0
f 1/1/1 2/2/1 3/3/1 4/4/1
f 1/1/2 4/2/2 6/3/2 5/4/2
f 1/1/3 2/2/3 7/3/3 5/4/3
"""


def write(folder: Path, inside: str, name: str = "scene.xml") -> Path:
    (folder / name).write_text(f'<scene version="3.0.0">{inside}</scene>')
    return folder / name


def read(folder: Path, inside: str, **options) -> tuple[Scene, list[str]]:  # type: ignore[no-untyped-def]
    """The scene, and the warnings."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        scene = read_mitsuba_xml(write(folder, inside), **options)
    said = [str(w.message) for w in caught if issubclass(w.category, RefletWarning)]
    return scene, said


def first_hits(scene: Scene, origin: np.ndarray, along: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Distance to the nearest triangle of each ray, and whether its front was met."""
    corners = np.concatenate([part.mesh.positions[part.mesh.triangles] for part in scene.parts]).astype(np.float64)
    a, e1, e2 = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    nearest, front = np.full(len(origin), np.inf), np.zeros(len(origin), bool)
    for ray, (o, d) in enumerate(zip(origin, along, strict=True)):
        p = np.cross(d, e2)
        det = np.einsum("ti,ti->t", e1, p)
        with np.errstate(divide="ignore", invalid="ignore"):
            u = o - a
            b1 = np.einsum("ti,ti->t", u, p) / det
            q = np.cross(u, e1)
            b2 = (q @ d) / det
            t = np.einsum("ti,ti->t", e2, q) / det
            t = np.where((b1 >= 0) & (b2 >= 0) & (b1 + b2 <= 1) & (t > 1e-6), t, np.inf)
        hit = np.nanargmin(t)
        nearest[ray], front[ray] = t[hit], det[hit] > 0.0
    return nearest, front


SHAPES = {
    "instances": f"""
      <shape type="shapegroup" id="group">
        <shape type="obj"><string name="filename" value="corner.obj"/>{MIRROR}</shape>
        <shape type="cube"><transform name="to_world"><scale value="0.3"/><translate x="1" y="2"/></transform></shape>
      </shape>
      <shape type="instance"><ref id="group"/></shape>
      <shape type="instance"><ref id="group"/><transform name="to_world">
        <scale x="-1" y="2" z="1"/><rotate y="1" angle="40"/><translate x="5"/></transform></shape>""",
    "inside out": f"""
      <shape type="obj"><string name="filename" value="corner.obj"/><boolean name="flip_normals" value="true"/>
        {MIRROR}</shape>
      <shape type="sphere"><point name="center" x="4" y="0" z="0"/><boolean name="flip_normals" value="true"/></shape>
      <shape type="cube"><boolean name="flip_normals" value="true"/>
        <transform name="to_world"><translate y="4"/></transform></shape>""",
    "mirrored": f"""
      <shape type="obj"><string name="filename" value="corner.obj"/>{MIRROR}
        <transform name="to_world"><scale x="-1"/><rotate z="1" angle="20"/></transform></shape>
      <shape type="rectangle"><transform name="to_world"><scale z="-1" x="2"/><translate y="3"/></transform></shape>
      <shape type="disk"><transform name="to_world"><rotate x="1" angle="70"/><translate x="4"/></transform></shape>
      <shape type="cylinder"><point name="p0" x="5" y="5" z="0"/><point name="p1" x="5" y="7" z="1"/>
        <float name="radius" value="0.5"/></shape>""",
}


@pytest.mark.parametrize("name", list(SHAPES))
def test_rays_meet_what_they_meet_in_mitsuba(tmp_path: Path, name: str) -> None:
    (tmp_path / "corner.obj").write_text(CORNER)
    scene, said = read(tmp_path, SHAPES[name] + SKY)
    assert said == []
    use_variant()
    theirs = mi.load_file(str(tmp_path / "scene.xml"))
    rng = np.random.default_rng(3)
    low, high = (np.array(corner).ravel() for corner in (theirs.bbox().min, theirs.bbox().max))
    origin = rng.normal(size=(300, 3))
    origin = (low + high) / 2 + origin / np.linalg.norm(origin, axis=1)[:, None] * np.linalg.norm(high - low)
    along = low + rng.random((300, 3)) * (high - low) - origin
    along /= np.linalg.norm(along, axis=1)[:, None]
    seen = theirs.ray_intersect(mi.Ray3f(mi.Point3f(origin.T), mi.Vector3f(along.T)))
    distance, front = first_hits(scene, origin, along)
    hit = np.array(seen.is_valid())
    both = hit & np.isfinite(distance)
    # Grids of 96 sides lie up to 1 - cos(π/96) = 0.05 % of a radius inside of what is curved, more at a slant.
    assert (hit != np.isfinite(distance)).mean() < 0.02 and both.sum() > 60
    close = np.abs(distance[both] - np.array(seen.t)[both]) < 0.02
    assert close.mean() > 0.97
    # who is lit says the shading normal there
    facing = np.einsum("ik,ki->i", along, np.array(seen.sh_frame.n)) < 0.0
    assert (front == facing)[both][close].mean() > 0.99
    assert 0.1 < facing[both].mean() < 0.9 or name == "instances"


def test_files_are_found_where_mitsuba_looks_for_them(tmp_path: Path) -> None:
    for folder in ("meshes", "parts", "pictures"):
        (tmp_path / folder).mkdir()
    (tmp_path / "meshes/corner.obj").write_text(CORNER)
    Image.fromarray(np.full((2, 2, 3), 255, np.uint8)).save(tmp_path / "pictures/White.png")
    write(
        tmp_path / "parts",
        f'<shape type="obj" id="inner"><string name="filename" value="corner.obj"/>{MIRROR}</shape>',
        "b.xml",
    )
    inside = """<path value="meshes"/><path value="parts"/><default name="radius" value="2"/>
      <include filename="b.xml"/>
      <shape type="sphere" id="ball"><float name="radius" value="$radius"/><ref id="late"/></shape>
      <bsdf type="twosided" id="late"><ref id="later"/></bsdf>
      <bsdf type="diffuse" id="later"><texture type="bitmap" name="reflectance">
        <string name="filename" value="pictures\\white.PNG"/></texture></bsdf>""" + SKY  # fmt: skip
    use_variant()
    before = len(mi.file_resolver())
    scene, said = read(tmp_path, inside)
    assert said == []
    parts = {part.name: part for part in scene.parts}
    assert parts["ball"].mesh.positions.max() == pytest.approx(2.0)
    assert parts["ball"].material.double_sided
    assert parts["ball"].material.base_color_texture_srgb is not None
    assert parts["inner"].reflective
    assert len(mi.file_resolver()) == before, "a scene's paths hold for that scene only"


def test_a_missing_texture_is_said_and_replaced(tmp_path: Path) -> None:
    scene, said = read(
        tmp_path,
        f"""<shape type="sphere" id="ball">{MIRROR}</shape><shape type="cube" id="die"><bsdf type="diffuse">
        <texture type="bitmap" name="reflectance"><string name="filename" value="gone.png"/></texture></bsdf></shape>"""
        + SKY,
    )
    assert len(said) == 1 and "gone.png" in said[0] and "of die" in said[0]
    die = next(part for part in scene.parts if part.name == "die")
    assert die.material.base_color == (0.5, 0.5, 0.5) and die.material.base_color_texture_srgb is None


def test_a_z_up_scene_is_turned_with_all_that_is_in_it(tmp_path: Path) -> None:
    picture = np.random.default_rng(1).random((8, 16, 3)).astype(np.float32)
    write_exr(tmp_path / "sky.exr", picture)
    camera = """<sensor type="perspective"><float name="fov" value="30"/><transform name="to_world">
      <lookat origin="0,-8,3" target="0,0,3" up="0,0,1"/></transform></sensor>"""
    world = f"""<shape type="sphere" id="ball"><point name="center" x="1" y="2" z="3"/>{MIRROR}</shape>
      <emitter type="envmap"><string name="filename" value="sky.exr"/></emitter>"""
    scene, said = read(tmp_path, camera + world)
    assert len(said) == 1 and "+z is up" in said[0] and "--up y" in said[0]
    middle = scene.parts[0].mesh.positions
    np.testing.assert_allclose((middle.min(0) + middle.max(0)) / 2, [1, 3, -2], atol=1e-6)
    orbit = read_mitsuba_orbit(tmp_path / "scene.xml", scene)
    np.testing.assert_allclose(orbit.camera().position, [0, 3, 8], atol=1e-5)

    use_variant()
    theirs = mi.load_dict({"type": "envmap", "filename": str(tmp_path / "sky.exr")})
    v, u = np.meshgrid((np.arange(8) + 0.5) / 8, (np.arange(16) + 0.5) / 16, indexing="ij")
    theta, phi = v * np.pi, (u - 0.5) * 2 * np.pi
    x, y, z = np.sin(theta) * np.cos(phi), np.cos(theta), np.sin(theta) * np.sin(phi)
    seen = mi.SurfaceInteraction3f()
    seen.wi = -mi.Vector3f(np.stack([x, -z, y]).reshape(3, -1).astype(np.float32))  # +z of the file is up
    expected = np.stack([np.array(c) for c in theirs.eval(seen)], -1).reshape(8, 16, 3)
    assert scene.environment is not None
    # Mitsuba's texture coordinates are of single precision: a texel of 2π/16 is off by 1e-6 of itself.
    np.testing.assert_allclose(scene.environment.radiance, expected, atol=1e-5)

    as_it_is, said = read(tmp_path, camera + world, up="y")
    assert said == []
    assert as_it_is.parts[0].mesh.positions[:, 2].max() == pytest.approx(4.0)
    no_word, said = read(tmp_path, world)
    assert said == [] and no_word.parts[0].mesh.positions[:, 2].max() == pytest.approx(4.0)


def test_conductors_by_eta_and_k(tmp_path: Path) -> None:
    scene, said = read(
        tmp_path,
        """<shape type="sphere" id="a"><bsdf type="conductor"><rgb name="eta" value="0.2 0.9 1.5"/>
          <rgb name="k" value="3.9 2.4 1.9"/><rgb name="specular_reflectance" value="0.5 1 1"/></bsdf></shape>
        <shape type="cube" id="b"><bsdf type="roughconductor"><float name="alpha_u" value="0.01"/>
          <float name="alpha_v" value="0.03"/><spectrum name="eta" value="1.5"/><spectrum name="k" value="0"/></bsdf>
        </shape>"""
        + SKY,
    )
    n, k = np.array([0.2, 0.9, 1.5]), np.array([3.9, 2.4, 1.9])
    facing = ((n - 1) ** 2 + k**2) / ((n + 1) ** 2 + k**2)
    materials = {part.name: part.material for part in scene.parts}
    np.testing.assert_allclose(materials["a"].base_color, facing * [0.5, 1, 1], rtol=1e-5)
    # eta 1.5 without absorption: (0.5/2.5)²; the mean alpha 0.02
    np.testing.assert_allclose(materials["b"].base_color, 0.04, rtol=1e-4)
    assert materials["b"].perceptual_roughness == pytest.approx(np.sqrt(0.02))
    assert any("Conductors" in text and text.endswith(": a, b.") for text in said)
    assert any("as rough along as across: b" in text for text in said)


def test_textures_lie_where_mitsuba_puts_them(tmp_path: Path) -> None:
    codes = np.random.default_rng(2).integers(0, 256, (4, 8, 3), np.uint8)
    Image.fromarray(codes).save(tmp_path / "card.png")
    texture = """<texture type="bitmap" name="reflectance"><string name="filename" value="card.png"/>
      <string name="filter_type" value="nearest"/><transform name="to_uv"><scale x="3" y="0.5"/>
      <rotate z="1" angle="30"/><translate x="0.25" y="0.5"/></transform></texture>"""
    scene, _ = read(
        tmp_path,
        f"""<shape type="rectangle" id="card"><bsdf type="diffuse">{texture}</bsdf></shape>
        <shape type="sphere">{MIRROR}<transform name="to_world"><translate z="-9"/></transform></shape>"""
        + SKY,
    )
    card = next(part for part in scene.parts if part.name == "card")
    use_variant()
    theirs = mi.load_file(str(tmp_path / "scene.xml"))
    rng = np.random.default_rng(4)
    x, y = rng.uniform(-1, 1, (2, 200))
    rays = mi.Ray3f(mi.Point3f(np.stack([x, y, np.full(200, 5.0)])), mi.Vector3f(0, 0, -1))
    seen = theirs.ray_intersect(rays)
    shown = np.array(seen.bsdf().eval_diffuse_reflectance(seen)).T
    # our card: uv of its four corners, bilinear over the quad, the nearest texel of the picture
    positions, uv = card.mesh.positions.astype(np.float64), card.mesh.uv
    assert uv is not None and card.material.base_color_texture_srgb is not None
    solved = np.linalg.lstsq(np.column_stack([positions[:, :2], np.ones(4)]), uv, rcond=None)[0]
    at = np.column_stack([x, y, np.ones(200)]) @ solved
    pixels = card.material.base_color_texture_srgb.pixels[..., :3]
    np.testing.assert_array_equal(pixels, codes)
    code = pixels[np.floor(at[:, 1] * 4).astype(int) % 4, np.floor(at[:, 0] * 8).astype(int) % 8] / 255.0
    linear = np.where(code <= 0.04045, code / 12.92, ((code + 0.055) / 1.055) ** 2.4)
    # rounding decides on which texel a point within 1e-6 of an edge falls: one of 200, if any
    assert (np.abs(linear - shown).max(1) < 1e-3).mean() > 0.99


def test_what_looks_other_than_in_mitsuba_is_said_once_with_all_names(tmp_path: Path) -> None:
    grey = '<bsdf type="diffuse"><rgb name="reflectance" value="0.2"/></bsdf>'
    white = '<bsdf type="diffuse"><rgb name="reflectance" value="0.9"/></bsdf>'
    shapes = {
        "leaf": f'<bsdf type="mask"><float name="opacity" value="0.5"/>{grey}</bsdf>',
        "hole": f'<bsdf type="mask"><float name="opacity" value="0"/>{grey}</bsdf>',
        "air": '<bsdf type="null"/>',
        "lamp": '<bsdf type="null"/><emitter type="area"><rgb name="radiance" value="3"/></emitter>',
        "pane": '<bsdf type="thindielectric"/>',
        "bowl": '<bsdf type="dielectric"/>',
        "vase": '<bsdf type="dielectric"><rgb name="specular_reflectance" value="0.5"/></bsdf>',
        "bump": f'<bsdf type="bumpmap"><texture type="checkerboard"/>{grey}</bsdf>',
        "mixed": f'<bsdf type="blendbsdf"><float name="weight" value="0.7"/>{grey}{white}</bsdf>',
        "coin": f'<bsdf type="twosided">{white}{grey}</bsdf>',
        "coat": '<bsdf type="principled"><float name="clearcoat" value="1"/></bsdf>',
        "ink": '<bsdf type="diffuse"><texture type="mesh_attribute" name="reflectance">'
        '<string name="name" value="vertex_color"/></texture></bsdf>',
        "ball": MIRROR,
    }
    inside = "".join(f'<shape type="sphere" id="{name}">{bsdf}</shape>' for name, bsdf in shapes.items())
    lights = '<emitter type="point" id="bulb"/><emitter type="directional"/><emitter type="spot"/>'
    lights += '<emitter type="projector"/>'
    scene, said = read(tmp_path, inside + lights + SKY)
    assert sorted(said) == [
        "Both sides are shown as the front is: coin.",
        "Bump maps are left out: bump.",
        "Clear coats have GGX's highlights, as bright in their middle as Mitsuba's: coat.",
        "Diffuse light of principled materials is Lambert's beneath what reflects, other than Mitsuba's at grazing "
        "angles: coat.",
        "Glass reflects as much as its index of refraction says: vase.",
        "Lights of kinds that have no counterpart are left out: projector 4.",
        "Of two blended materials the heavier one is shown alone: mixed.",
        "Shapes that let all light through are left out: hole, air.",
        "Spots fade towards their edges as glTF's do, not Mitsuba's: spot 3.",
        "Textures that cannot be read are replaced by the parameter's default: mesh_attribute of ink.",
    ]
    materials = {part.name: part.material for part in scene.parts}
    assert set(materials) == set(shapes) - {"hole", "air"}
    assert (materials["leaf"].alpha, materials["leaf"].alpha_mode) == (0.5, "blend")
    assert materials["lamp"].emission == pytest.approx((3, 3, 3)) and materials["lamp"].base_color == (0, 0, 0)
    assert materials["mixed"].base_color == pytest.approx((0.9, 0.9, 0.9))
    assert materials["coin"].base_color == pytest.approx((0.9, 0.9, 0.9)) and materials["coin"].double_sided
    assert materials["ball"].base_color == (1.0, 1.0, 1.0)


def test_glass_is_read_with_its_index_and_tint(tmp_path: Path) -> None:
    inside = f"""
    <shape type="sphere" id="clear"><bsdf type="dielectric"/></shape>
    <shape type="sphere" id="water"><bsdf type="dielectric"><string name="int_ior" value="water"/></bsdf></shape>
    <shape type="sphere" id="green"><bsdf type="dielectric"><float name="int_ior" value="3.0"/>
      <float name="ext_ior" value="1.5"/><rgb name="specular_transmittance" value="0.2, 0.9, 0.3"/></bsdf></shape>
    <shape type="sphere" id="pane"><bsdf type="thindielectric"><float name="int_ior" value="1.6"/></bsdf></shape>
    <shape type="sphere" id="frosted"><bsdf type="roughdielectric"><float name="alpha" value="0.25"/></bsdf></shape>
    {SKY}"""
    scene, said = read(tmp_path, inside)
    assert said == ["Baked as clear glass whatever their roughness: frosted (0.50)."]
    found = {part.name: part for part in scene.parts}
    assert all(part.reflective and part.material.double_sided for part in scene.parts)
    glass = {name: part.material.refraction for name, part in found.items()}
    # Mitsuba's own defaults: BK7 in air
    assert glass["clear"] is not None and glass["clear"].index == pytest.approx(1.5046 / 1.000277, rel=1e-6)
    assert glass["water"] is not None and glass["water"].index == pytest.approx(1.333 / 1.000277, rel=1e-6)
    assert glass["green"] is not None and glass["green"].index == pytest.approx(2.0, rel=1e-6)
    assert glass["pane"] is not None and glass["pane"].thin and not glass["clear"].thin
    assert found["green"].material.base_color == pytest.approx((0.2, 0.9, 0.3))
    assert found["clear"].material.base_color == (1.0, 1.0, 1.0)
    assert found["frosted"].material.perceptual_roughness == pytest.approx(0.5)


def test_an_environment_given_replaces_the_files_own(tmp_path: Path) -> None:
    from reflet.scene.material import EnvironmentLight

    two = f'<shape type="sphere">{MIRROR}</shape>{SKY}{SKY}'
    with pytest.raises(RefletError, match="--environment FILE"):
        read(tmp_path, two)
    given = EnvironmentLight(np.ones((2, 4, 3), np.float32))
    scene, _ = read(tmp_path, two, environment=given)
    assert scene.environment is given


def test_a_computed_sky_keeps_its_sun(tmp_path: Path) -> None:
    """The sun's disc is smaller than two texels; what it gives is found in them by looking at many places in each."""
    scene, said = read(
        tmp_path,
        f"""<shape type="sphere">{MIRROR}</shape><emitter type="sunsky"><vector name="sun_direction" x="1" y="1" z="1"/>
        <float name="sky_scale" value="0"/></emitter>""",
    )
    assert said == [] and scene.environment is not None
    radiance = scene.environment.radiance.astype(np.float64)
    rows = len(radiance)
    solid_angle = 2 * np.pi / (2 * rows) * np.diff(-np.cos(np.linspace(0, np.pi, rows + 1)))
    flux = np.einsum("r,rck->k", solid_angle, radiance)
    use_variant()
    sun = mi.load_dict({"type": "sunsky", "sun_direction": [1.0, 1.0, 1.0], "sky_scale": 0.0})
    across = np.radians(0.3) * (2 * (np.arange(400) + 0.5) / 400 - 1)  # a patch of 0.6°, the disc is 0.5358° wide
    s, t = np.meshgrid(across, across)
    right, above = np.array([1, -1, 0]) / np.sqrt(2), np.array([1, 1, -2]) / np.sqrt(6)
    at = np.full(3, 3**-0.5) + s[..., None] * right + t[..., None] * above
    at /= np.linalg.norm(at, axis=-1, keepdims=True)
    seen = mi.SurfaceInteraction3f()
    seen.wi = -mi.Vector3f(at.reshape(-1, 3).T.astype(np.float32))
    whole = np.array([np.array(channel).sum() for channel in sun.eval(seen)]) * (across[1] - across[0]) ** 2
    # About 24² of our places fall on the disc; those on its rim, 75 of 600, are in or out by chance.
    np.testing.assert_allclose(flux, whole, rtol=0.02)
