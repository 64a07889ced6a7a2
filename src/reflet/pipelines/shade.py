"""Pictures of meshes of environment-mapped materials: mesh, environment and material by name, a camera, a picture."""

import warnings
from pathlib import Path

import numpy as np
from jaxtyping import Float32

from reflet.envmap.rotations import turn_about_vertical
from reflet.errors import RefletError, RefletWarning
from reflet.files.env_image_file import read_light
from reflet.files.ior_file import read_spectral_index
from reflet.files.measured_brdf_file import read_measured_brdf
from reflet.files.textures.texel_formats import LINEAR_FROM_SRGB
from reflet.files.unreadable import check_is_file
from reflet.progress import ProgressCallback, silent
from reflet.reflectance.brdfs.spectral import index_rgb
from reflet.reflectance.lobes.lobes import fit_lobes
from reflet.reflectance.materials.material import (
    BLACK,
    WHITE,
    Coated,
    Conductor,
    Dielectric,
    DielectricOverDiffuse,
    GlossyGgx,
    GlossyPhong,
    Mirror,
    Rgb,
    SurfaceMaterial,
)
from reflet.reflectance.materials.material_maps import EnvironmentMaps
from reflet.reflectance.materials.measured_material import Measured
from reflet.reflectance.materials.metals import METALS
from reflet.scene.bounds import bounding_sphere
from reflet.scene.builtin.newell import PARTS
from reflet.scene.builtin.teapot import teapot_mesh
from reflet.scene.material import Material
from reflet.scene.meshes.mesh import Mesh
from reflet.scene.meshes.primitives import sphere_mesh, torus_mesh
from reflet.scene.readers.gltf.read import read_gltf
from reflet.scene.readers.obj.read import read_obj
from reflet.scene.scene import Part
from reflet.scene.views.camera import Vec3
from reflet.scene.views.framing import ELEVATION_DEG, FOV_DEG
from reflet.scene.views.parameter_space import Orbit

OWN = "gltf"  # stands for the materials that a file gives its parts
BUILT_IN = ("sphere", "torus", "teapot")
_MARGIN = 1.05  # room around the mesh's bounding sphere
_AZIMUTH_DEG = -60.0  # before glTF's models, whose front is towards +z, and somewhat to their left

_VIEW_ANGLES = 12  # of a BRDF's lobes, whose maps take some tenths of a second each

# What comes after the colon
MATERIALS = {
    "mirror": None,
    "dielectric": "index of refraction",
    "dielectric+diffuse": "index of refraction",
    "coated": "index of refraction",
    "conductor": f"metal ({', '.join(METALS)}) or a .yml table of refractive indices",
    "phong": "exponent",
    "ggx": "perceptual roughness",
    "table": "table of a BRDF, a .npz file",
}


def load_mesh(source: str | Path) -> Mesh:
    """All triangles of a .glb, .gltf or .obj file as one mesh, or the built-in ``sphere``, ``torus`` or ``teapot``.

    Raises RefletError for anything else.
    """
    name = str(source)
    if name == "sphere":
        return sphere_mesh(around=256)
    if name == "torus":
        return torus_mesh()
    if name == "teapot":
        return joined([teapot_mesh(part) for part in PARTS])
    return joined([part.mesh for part in _parts(source)])


def _parts(source: str | Path) -> list[Part]:
    path = Path(source)
    suffix = path.suffix.lower()
    if suffix not in (".glb", ".gltf", ".obj"):
        raise RefletError(f"A mesh is a .glb, .gltf or .obj file, or one of {', '.join(BUILT_IN)}, not {source}.")
    check_is_file(path)
    parts = read_obj(path) if suffix == ".obj" else read_gltf(path)
    if not any(len(part.mesh.triangles) for part in parts):
        raise RefletError(f"{path} holds no triangles; export it with its meshes.")
    return parts


def own_material(material: Material, colors: Float32[np.ndarray, "vertices 4"] | None = None) -> GlossyGgx:
    """glTF's metallic-roughness material, by `GlossyGgx`: textures and the vertices' ``colors`` count as their mean,
    glow is left out."""
    color, metallic, roughness = np.array(material.base_color), material.metallic, material.perceptual_roughness
    if material.base_color_texture_srgb is not None:
        pixels = material.base_color_texture_srgb.pixels
        color = color * LINEAR_FROM_SRGB[pixels[..., :3]].mean((0, 1))
    if colors is not None:
        color = color * colors[:, :3].mean(axis=0)
    if material.metallic_roughness_texture is not None:
        share = material.metallic_roughness_texture.pixels[..., 1:3].mean((0, 1)) / 255.0
        roughness, metallic = roughness * share[0], metallic * share[1]
    r, g, b = (float(channel) for channel in np.clip(color, 0.0, 1.0))
    return GlossyGgx((r, g, b), float(np.clip(metallic, 0.0, 1.0)), float(np.clip(roughness, 0.0, 1.0)))


def joined(meshes: list[Mesh]) -> Mesh:
    """Several meshes as one, without uv and tangents."""
    starts = np.cumsum([0] + [len(mesh.positions) for mesh in meshes])
    triangles = [mesh.triangles + np.uint32(start) for mesh, start in zip(meshes, starts, strict=False)]
    return Mesh(
        np.concatenate([mesh.positions for mesh in meshes]),
        np.concatenate([mesh.normals for mesh in meshes]),
        np.concatenate(triangles).astype(np.uint32),
    )


def surface_material(
    text: str, albedo: Rgb | None = None, specular: Rgb | None = None, metallic: float = 0.0
) -> SurfaceMaterial:
    """The material that ``text`` names: one of `MATERIALS`, mostly with a colon and a number, such as ``coated:1.5``.

    ``albedo`` is the diffuse colour, a mirror's reflectance and GGX's base colour: white where none is given, but black
    for Phong. ``specular`` is Phong's specular share, by default what the albedo leaves. Raises RefletError for what
    is unknown or out of range.
    """
    name, _, value = text.partition(":")
    if name not in MATERIALS:
        raise RefletError(f"A material is one of {', '.join(MATERIALS)} or {OWN}, not {name!r}.")
    what = MATERIALS[name]
    color = albedo or WHITE
    if what is None:
        if value:
            raise RefletError(f"The material {name} takes no number, and {value!r} came; write {name} alone.")
        return Mirror(color)
    if name == "conductor":
        return _metal(value)
    if name == "table":
        if not value:
            raise RefletError("The material table needs its file, such as table:satin.npz, as docs/brdf_table.md says.")
        return Measured(fit_lobes(read_measured_brdf(value), angles=_VIEW_ANGLES))
    try:
        number = float(value)
    except ValueError as error:
        example = {"phong": "50", "ggx": "0.3"}.get(name, "1.5")
        raise RefletError(f"The material {name} needs its {what}, such as {name}:{example}, not {text!r}.") from error
    match name:
        case "dielectric":
            return Dielectric(number)
        case "dielectric+diffuse":
            return DielectricOverDiffuse(number, color)
        case "coated":
            return Coated(number, color)
        case "phong":
            diffuse = albedo or BLACK
            r, g, b = (1.0 - channel for channel in diffuse)
            return GlossyPhong(number, specular or (r, g, b), diffuse)
    return GlossyGgx(color, metallic, number)


def _metal(value: str) -> Conductor:
    if value in METALS:
        return METALS[value]
    if Path(value).suffix.lower() not in (".yml", ".yaml"):
        raise RefletError(f"A conductor is a {MATERIALS['conductor']}, such as conductor:Au, not {value!r}.")
    n, k = index_rgb(read_spectral_index(value))
    return Conductor((n[0], n[1], n[2]), (k[0], k[1], k[2]))


def frame_mesh(
    mesh: Mesh,
    *,
    azimuth_deg: float | None = None,
    elevation_deg: float | None = None,
    distance: float | None = None,
    image_size: int = 512,
) -> Orbit:
    """An orbit around the middle of a mesh's bounding box, by default as far as shows all of it."""
    centre, radius = bounding_sphere(mesh.positions.astype(np.float64))
    target: Vec3 = (float(centre[0]), float(centre[1]), float(centre[2]))
    return Orbit(
        target=target,
        azimuth_deg=_AZIMUTH_DEG if azimuth_deg is None else azimuth_deg,
        elevation_deg=ELEVATION_DEG if elevation_deg is None else elevation_deg,
        distance=_MARGIN * radius / float(np.sin(np.radians(FOV_DEG) / 2.0)) if distance is None else distance,
        fov_deg=FOV_DEG,
        image_size=image_size,
    )


def shade(
    mesh: str | Path | Mesh,
    environment: str | Path | EnvironmentMaps,
    material: str | SurfaceMaterial,
    *,
    azimuth_deg: float | None = None,
    elevation_deg: float | None = None,
    distance: float | None = None,
    image_size: int = 512,
    turn_deg: float = 0.0,
    samples: int = 16,
    backdrop: bool = True,
    progress: ProgressCallback = silent,
) -> Float32[np.ndarray, "height width 4"]:
    """Linear radiance of a mesh before an environment at infinity, and coverage of the mesh in alpha.

    ``mesh`` is what `load_mesh` takes, ``environment`` what `read_light` does, ``material`` what `surface_material`
    does; or each the thing itself. With the material ``gltf`` each part of a file has its own (`own_material`).
    ``turn_deg`` turns the environment about the vertical. ``samples`` are 1, 4 or 16 a pixel. ``progress`` hears when
    the mesh is read and when the picture is drawn.
    """
    progress("mesh", 0, 1)
    from reflet.render.materials.parts_renderer import PartsRenderer, ShadedPart

    if material != OWN:
        surface = surface_material(material) if isinstance(material, str) else material
        parts = [ShadedPart(mesh if isinstance(mesh, Mesh) else load_mesh(mesh), surface)]
    elif isinstance(mesh, Mesh) or str(mesh) in BUILT_IN:
        raise RefletError(f"The material {OWN} is that of a .glb, .gltf or .obj file; choose another for this mesh.")
    else:
        found = _parts(mesh)
        if any(part.material.base_color_texture_srgb or part.material.metallic_roughness_texture for part in found):
            text = f"{Path(mesh).name} has textures, which are not honoured: their mean colour and roughness are shown."
            warnings.warn(text, RefletWarning, stacklevel=2)
        if any(part.mesh.colors is not None and np.ptp(part.mesh.colors[:, :3], axis=0).any() for part in found):
            text = f"{Path(mesh).name} has vertex colours that vary, which are not honoured: their mean is shown."
            warnings.warn(text, RefletWarning, stacklevel=2)
        glass = [part.name for part in found if part.material.refraction is not None]
        if glass:
            listed = ", ".join(glass[:8]) + (", …" if len(glass) > 8 else "")
            text = f"Glass is shown opaque here: {listed}. It is seen through in what `reflet bake` makes."
            warnings.warn(text, RefletWarning, stacklevel=2)
        parts = [
            ShadedPart(part.mesh, own_material(part.material, part.mesh.colors), part.material.double_sided)
            for part in found
        ]
    orbit = frame_mesh(
        joined([part.mesh for part in parts]),
        azimuth_deg=azimuth_deg,
        elevation_deg=elevation_deg,
        distance=distance,
        image_size=image_size,
    )
    progress("mesh", 1, 1)
    camera = orbit.camera()
    maps = environment if isinstance(environment, EnvironmentMaps) else EnvironmentMaps(read_light(environment))
    turn = turn_about_vertical(turn_deg) if turn_deg else None
    progress("draw", 0, 1)
    picture = PartsRenderer(parts, maps).picture(camera, frame=turn, samples=samples, backdrop=backdrop)
    progress("draw", 1, 1)
    return picture
