"""Mitsuba's BSDFs become materials that reflect as Mitsuba's own plugins do, where the two models agree."""

import warnings
from pathlib import Path
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest
from PIL import Image

from reflet.errors import RefletWarning
from reflet.scene.material import Material
from reflet.trace.mitsuba_files.mitsuba_xml import read_mitsuba_xml
from reflet.trace.references.materials import MaterialPlugins
from reflet.trace.variant import use_variant

BECKMANN = "Beckmann's microfacets are shown as GGX's, whose highlights have longer tails: ball."
GGX = '<string name="distribution" value="ggx"/>'


def read(folder: Path, bsdf: str, textured: bool = False) -> tuple[Any, list[str]]:
    """The part that wears a BSDF, and the warnings."""
    shape = "rectangle" if textured else "sphere"
    mirror = '<shape type="cube" id="mirror"><bsdf type="conductor"/></shape>'
    text = f'<scene version="3.0.0"><shape type="{shape}" id="ball">{bsdf}</shape>{mirror}<emitter type="constant"/>'
    (folder / "scene.xml").write_text(text + "</scene>")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        scene = read_mitsuba_xml(folder / "scene.xml")
    said = [str(w.message) for w in caught if issubclass(w.category, RefletWarning)]
    return next(part for part in scene.parts if part.name == "ball"), said


def material(folder: Path, bsdf: str) -> Material:
    found: Material = read(folder, bsdf)[0].material
    return found


def number(name: str, value: float) -> str:
    return f'<float name="{name}" value="{value}"/>'


def both(folder: Path, bsdf: str, *, single_scattering: bool = False) -> tuple[Any, Any]:
    """Mitsuba's own BSDF, and our reference's of the material that was read. Mitsuba's loses what bounces between
    microfacets, as ours of ``single_scattering`` does."""
    part, _ = read(folder, bsdf)
    use_variant()
    theirs = next(s for s in mi.load_file(str(folder / "scene.xml")).shapes() if s.id() == "ball").bsdf()
    return theirs, MaterialPlugins("gltf", single_scattering).bsdf(part)


def towards(degrees: float, lanes: int = 1) -> Any:
    si = dr.zeros(mi.SurfaceInteraction3f, lanes)
    si.n, si.sh_frame = mi.Normal3f(0, 0, 1), mi.Frame3f(mi.Vector3f(0, 0, 1))
    si.wi = mi.Vector3f(float(np.sin(np.radians(degrees))), 0.0, float(np.cos(np.radians(degrees))))
    return si


def mirrored(bsdf: Any, degrees: float) -> np.ndarray:
    """What a lobe shows in the middle."""
    si = towards(degrees)
    wo = mi.Vector3f(-si.wi.x, si.wi.y, si.wi.z)
    return np.array(bsdf.eval(mi.BSDFContext(), si, wo)).ravel()


def furnace(bsdf: Any, degrees: float) -> np.ndarray:
    """What is reflected of constant light of 1."""
    lanes = 1 << 15
    u = np.random.default_rng(1).random((3, lanes)).astype(np.float32)
    u[1:] = np.stack([(np.arange(lanes) + 0.5) / lanes, np.mod(np.arange(lanes) * 0.6180339887, 1.0)])
    _, weight = bsdf.sample(mi.BSDFContext(), towards(degrees, lanes), mi.Float(u[0]), mi.Point2f(u[1:]))
    return np.array(np.array(weight).mean(1))


def test_diffuse_surfaces_reflect_nothing(tmp_path: Path) -> None:
    part, said = read(tmp_path, '<bsdf type="diffuse"/>')
    assert said == [] and not part.material.reflects and not part.reflective
    theirs, ours = both(tmp_path, '<bsdf type="diffuse"/>')
    np.testing.assert_allclose(mirrored(ours, 60), mirrored(theirs, 60), rtol=1e-5)  # single precision


@pytest.mark.parametrize("nonlinear", ["false", "true"])
def test_plastic_in_constant_light(tmp_path: Path, nonlinear: str) -> None:
    bsdf = f"""<bsdf type="plastic">{number("int_ior", 1.8)}{number("ext_ior", 1.0)}
      <rgb name="diffuse_reflectance" value="0.9 0.5 0.1"/><boolean name="nonlinear" value="{nonlinear}"/></bsdf>"""
    found = material(tmp_path, bsdf)
    assert (found.ior, found.perceptual_roughness, found.metallic) == (pytest.approx(1.8), 0.0, 0.0)
    if nonlinear == "false":
        assert found.base_color == pytest.approx((0.9, 0.5, 0.1))
    theirs, ours = both(tmp_path, bsdf)
    # exact but for Schlick's approximation, which is off by less than 0.01 up to 45°, and for 2¹⁵ samples
    for degrees in (0, 45):
        np.testing.assert_allclose(furnace(ours, degrees), furnace(theirs, degrees), atol=0.015)


def test_rough_plastic_and_its_specular(tmp_path: Path) -> None:
    bsdf = f"""<bsdf type="roughplastic">{GGX}{number("alpha", 0.09)}{number("int_ior", 1.5)}{number("ext_ior", 1.0)}
      {number("specular_reflectance", 0.5)}<rgb name="diffuse_reflectance" value="0 0 0"/></bsdf>"""
    part, said = read(tmp_path, bsdf)
    assert said == []
    assert part.material.perceptual_roughness == pytest.approx(0.3)
    np.testing.assert_allclose(part.material.dielectric_f0, 0.02, rtol=1e-5)
    theirs, ours = both(tmp_path, bsdf, single_scattering=True)
    np.testing.assert_allclose(mirrored(ours, 0), mirrored(theirs, 0), rtol=1e-4)  # single precision
    assert read(tmp_path, bsdf.replace(GGX, ""))[1] == [BECKMANN]


def test_coloured_specular_of_plastic(tmp_path: Path) -> None:
    tint = '<rgb name="specular_reflectance" value="0.8 0.4 0.2"/>'
    part, said = read(tmp_path, f'<bsdf type="plastic">{number("int_ior", 1.5)}{number("ext_ior", 1)}{tint}</bsdf>')
    np.testing.assert_allclose(part.material.dielectric_f0, np.array([0.8, 0.4, 0.2]) * 0.04, rtol=1e-5)
    assert said == ["Coloured reflections of plastics are white along the surface: ball."]


def test_rough_metal(tmp_path: Path) -> None:
    bsdf = f"""<bsdf type="roughconductor">{GGX}{number("alpha", 0.25)}
      <rgb name="eta" value="0.2 0.9 1.5"/><rgb name="k" value="3.9 2.4 1.9"/></bsdf>"""
    assert material(tmp_path, bsdf).perceptual_roughness == 0.5
    theirs, ours = both(tmp_path, bsdf, single_scattering=True)
    np.testing.assert_allclose(mirrored(ours, 0), mirrored(theirs, 0), rtol=1e-4)  # single precision
    assert read(tmp_path, '<bsdf type="conductor"/>')[1] == [], "no metal is named: a mirror, of no approximation"
    bare = material(tmp_path, '<bsdf type="roughconductor"/>')
    assert (bare.base_color, bare.perceptual_roughness) == ((1.0, 1.0, 1.0), pytest.approx(0.1**0.5))


def test_principled_metal_and_dielectric(tmp_path: Path) -> None:
    color = '<rgb name="base_color" value="0.8 0.4 0.2"/>'
    metal = f'<bsdf type="principled">{color}{number("metallic", 1)}{number("roughness", 0.5)}</bsdf>'
    part, said = read(tmp_path, metal)
    assert said == [] and part.material.perceptual_roughness == 0.5 and part.material.metallic == 1.0
    theirs, ours = both(tmp_path, metal, single_scattering=True)
    np.testing.assert_allclose(mirrored(ours, 0), mirrored(theirs, 0), rtol=1e-4)  # single precision
    for said_by, index in (("eta", 1.8), ("specular", 0.5)):
        found = material(tmp_path, f'<bsdf type="principled">{number(said_by, index)}</bsdf>')
        facing = (0.8 / 2.8) ** 2 if said_by == "eta" else 0.04
        np.testing.assert_allclose(found.dielectric_f0, facing, rtol=1e-6)
    assert not material(tmp_path, f'<bsdf type="principled">{number("specular", 0)}</bsdf>').dielectric_f0[0]
    tinted = material(tmp_path, f'<bsdf type="principled">{color}{number("spec_tint", 1)}{number("eta", 1.5)}</bsdf>')
    luminance = 0.8 * 0.212671 + 0.4 * 0.715160 + 0.2 * 0.072169
    np.testing.assert_allclose(tinted.dielectric_f0, 0.04 * np.array([0.8, 0.4, 0.2]) / luminance, rtol=1e-5)


@pytest.mark.parametrize("gloss", [0.0, 0.5])
def test_clear_coats_are_as_bright_in_their_middle(tmp_path: Path, gloss: float) -> None:
    bare = f'{number("roughness", 1)}{number("specular", 0)}<rgb name="base_color" value="0 0 0"/>'
    coat = number("clearcoat", 0.7) + number("clearcoat_gloss", gloss)
    found = material(tmp_path, f'<bsdf type="principled">{bare}{coat}</bsdf>')
    assert found.clearcoat == pytest.approx(0.7)
    theirs, ours = both(tmp_path, f'<bsdf type="principled">{bare}{coat}</bsdf>')
    np.testing.assert_allclose(mirrored(ours, 0), mirrored(theirs, 0), rtol=1e-3)  # single precision of D


def test_principled_glass(tmp_path: Path) -> None:
    color = '<rgb name="base_color" value="0.25 0.5 1"/>'
    inside = f"{color}{number('spec_trans', 1)}{number('roughness', 0)}"
    solid = material(tmp_path, f'<bsdf type="principled">{inside}{number("eta", 1.6)}</bsdf>')
    assert solid.refraction is not None and not solid.refraction.thin
    assert (solid.refraction.index, solid.refraction.transmission) == (pytest.approx(1.6), 1.0)
    assert solid.base_color == pytest.approx((0.5, 0.5**0.5, 1.0)), "once on the way in and once on the way out"
    sheet = material(tmp_path, f'<bsdf type="principledthin">{inside}</bsdf>')
    assert sheet.refraction is not None and sheet.refraction.thin
    assert sheet.base_color == pytest.approx((0.25, 0.5, 1.0))
    some, said = read(tmp_path, f'<bsdf type="principled">{number("spec_trans", 0.3)}</bsdf>')
    assert some.material.refraction is None
    assert "Principled materials that are glass for less than a half are shown opaque: ball." in said


@pytest.mark.parametrize(
    ("lines", "says"),
    [
        (number("sheen", 0.5), "The sheen of principled materials is left out"),
        (number("anisotropic", 0.5), "Brushed surfaces are shown as rough along as across"),
        (number("flatness", 0.5), "The flatness of principled materials is left out"),
        (number("clearcoat", 0.5), "Clear coats have GGX's highlights, as bright in their middle as Mitsuba's"),
    ],
)
def test_what_of_principled_materials_is_left_out(tmp_path: Path, lines: str, says: str) -> None:
    metal = number("metallic", 1)
    assert read(tmp_path, f'<bsdf type="principled">{metal}{lines}</bsdf>')[1] == [f"{says}: ball."]


def picture(path: Path, *codes: int) -> None:
    Image.fromarray(np.array([codes], np.uint8)).save(path)


def bitmap(name: str, file: str) -> str:
    raw = '<boolean name="raw" value="true"/>'
    return f'<texture type="bitmap" name="{name}"><string name="filename" value="{file}"/>{raw}</texture>'


def test_textures_of_roughness_metal_and_opacity(tmp_path: Path) -> None:
    picture(tmp_path / "a.png", 51, 204)
    picture(tmp_path / "holes.png", 0, 255)
    part, _ = read(tmp_path, f'<bsdf type="principled">{bitmap("roughness", "a.png")}</bsdf>', True)
    packed = part.material.metallic_roughness_texture
    assert packed is not None and packed.pixels[0, :, 1].tolist() == [51, 204]
    assert (part.material.perceptual_roughness, part.material.metallic) == (1.0, 0.0)
    part, said = read(tmp_path, f'<bsdf type="roughconductor">{GGX}{bitmap("alpha", "a.png")}</bsdf>', True)
    packed = part.material.metallic_roughness_texture
    # √(51/255)·255 = 114.04, √(204/255)·255 = 228.08
    assert said == [] and packed is not None and packed.pixels[0, :, 1].tolist() == [114, 228]
    grey = '<bsdf type="diffuse"/>'
    for file, mode in (("holes.png", "mask"), ("a.png", "blend")):
        part, said = read(tmp_path, f'<bsdf type="mask">{bitmap("opacity", file)}{grey}</bsdf>', True)
        assert said == [] and part.material.alpha_mode == mode and part.material.base_color == (0.5, 0.5, 0.5)
        codes = [0, 255] if mode == "mask" else [51, 204]
        assert part.material.base_color_texture_srgb.pixels[0, :, 3].tolist() == codes
    part, said = read(
        tmp_path, f'<bsdf type="blendbsdf">{bitmap("weight", "a.png")}{grey}<bsdf type="null"/></bsdf>', True
    )
    assert said == [] and part.material.base_color_texture_srgb.pixels[0, :, 3].tolist() == [204, 51]


@pytest.mark.parametrize("mirrored_by", [1, -1])
def test_normal_maps_bend_rays_as_in_mitsuba(tmp_path: Path, mirrored_by: int) -> None:
    """Also in an instance that mirrors and stretches."""
    Image.fromarray(np.full((2, 2, 3), (200, 160, 220), np.uint8)).save(tmp_path / "n.png")
    bsdf = f'<bsdf type="normalmap">{bitmap("normalmap", "n.png")}<bsdf type="conductor"/></bsdf>'
    text = f"""<scene version="3.0.0"><shape type="shapegroup" id="g"><shape type="rectangle" id="ball">{bsdf}</shape>
      </shape><shape type="instance"><ref id="g"/><transform name="to_world"><scale x="{2 * mirrored_by}"/>
      <rotate z="1" angle="40"/></transform></shape><emitter type="constant"/></scene>"""
    (tmp_path / "scene.xml").write_text(text)
    (part,) = read_mitsuba_xml(tmp_path / "scene.xml").parts
    mesh, picture_of = part.mesh, part.material.normal_texture
    assert mesh.tangents is not None and picture_of is not None
    x, y, z = 2.0 * picture_of.pixels[0, 0, :3] / 255.0 - 1.0
    n, t, w = mesh.normals[0].astype(float), mesh.tangents[0, :3].astype(float), mesh.tangents[0, 3]
    bent = x * t + y * w * np.cross(n, t) + z * n
    bent /= np.linalg.norm(bent)
    along = np.array([0.0, 0.0, -np.sign(n[2])])
    si = mi.load_file(str(tmp_path / "scene.xml")).ray_intersect(mi.Ray3f(mi.Point3f(-5.0 * along), mi.Vector3f(along)))
    image = {"type": "bitmap", "raw": True, "filename": str(tmp_path / "n.png")}
    theirs = mi.load_dict({"type": "normalmap", "normalmap": image, "bsdf": {"type": "conductor"}})
    drawn, _ = theirs.sample(mi.BSDFContext(), si, mi.Float(0.5), mi.Point2f(0.5))
    expected = along - 2.0 * (along @ bent) * bent
    np.testing.assert_allclose(np.array(si.to_world(drawn.wo)).ravel(), expected, atol=1e-5)  # single precision
