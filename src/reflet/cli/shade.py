"""``reflet shade``."""

from pathlib import Path

import click

from reflet.cli.options import Vector, from_option
from reflet.cli.progress import progress_bar
from reflet.envmap.parameterizations.parameterization import Parameterization

RGB = Vector()
RGB.name = "R,G,B"


@click.command(short_help="Draw a mesh of some material in an environment.")
@click.argument("mesh", metavar="MESH")
@click.argument("environment", metavar="[ENV]", type=click.Path(path_type=Path), required=False)
@click.option("--material", required=True, metavar="NAME[:VALUE]", help="See above.")
@click.option("--albedo", type=RGB, help="Diffuse colour, base colour, or a mirror's reflectance; linear, 0 to 1.")
@click.option("--specular", type=RGB, help="Phong's specular share; by default what --albedo leaves.")
@click.option("--metallic", type=click.FloatRange(0, 1), default=0.0, show_default=True, help="For ggx.")
@click.option("--azimuth", type=float, default=-60.0, show_default=True, help="Degrees; -90 looks from +z.")
@click.option("--elevation", type=click.FloatRange(-90, 90), default=22.0, show_default=True, help="Degrees.")
@click.option("--distance", type=float, help="Metres from the mesh's middle; by default such that all of it shows.")
@click.option(
    "--turn",
    type=float,
    default=0.0,
    help="Degrees by which the environment is turned about the vertical, counter-clockwise seen from above.",
)
@click.option("--samples", type=click.Choice(["1", "4", "16"]), default="16", show_default=True, help="Per pixel.")
@click.option("--size", type=click.IntRange(1), default=512, show_default=True, help="Pixels along an edge.")
@click.option("--exposure", type=float, default=1.6, show_default=True, help="Of a .png.")
@from_option
@click.option("--no-backdrop", is_flag=True, help="Leave what is behind the mesh transparent.")
@click.option("-o", "--output", type=click.Path(path_type=Path), required=True, help="The .png or .exr to write.")
def shade(
    mesh: str,
    environment: Path | None,
    material: str,
    albedo: tuple[float, float, float] | None,
    specular: tuple[float, float, float] | None,
    metallic: float,
    azimuth: float,
    elevation: float,
    distance: float | None,
    turn: float,
    samples: str,
    size: int,
    exposure: float,
    source_is: Parameterization | None,
    no_backdrop: bool,
    output: Path,
) -> None:
    """Draws MESH (a .glb, .gltf or .obj file, or sphere, torus, teapot) lit by ENV, an environment map of any kind.

    A .png holds the tone-mapped picture, an .exr linear radiance.

    \b
    Materials:
      mirror                  reflects --albedo at all angles
      dielectric:1.5          glass of this index of refraction: Fresnel's mirror over black
      dielectric+diffuse:1.5  the same, and --albedo lit diffusely, simply added
      coated:1.5              clear coat over --albedo, which gets what the coat lets through
      conductor:Au            polished metal: Au, Ag, Cu, Al, or a .yml from refractiveindex.info
      phong:50                Phong's lobe of this exponent
      ggx:0.3                 glTF's material of this perceptual roughness, with --metallic
      gltf                    the materials that MESH brings, each part its own; textures by their mean
      table:satin.npz         any isotropic BRDF, measured or computed (docs/brdf_table.md), as three lobes

    \b
    Without ENV, drawings on white paper (see reflet sketch), several joined by +:
      silhouette hatching window gooch, with a width in pixels: gooch+silhouette:3
    ENV itself, not tone-mapped, looked up by one of reflection normal view-reflection view-normal:
      map:view-normal         what reflet sketch draws; matcaps are map:view-reflection of a gazing_ball

    \b
    Examples:
      reflet shade teapot studio.hdr --material coated:1.5 --albedo 0.5,0.02,0.02 -o red.png
      reflet shade torus studio.hdr --material conductor:Au -o gold.exr
      reflet shade teapot studio.hdr --material table:satin.npz -o satin.png
      reflet shade chair.glb studio.ktx2 --material ggx:0.3 --metallic 1 --turn 90 -o chair.png
      reflet shade teapot --material gooch+silhouette -o drawing.png
    """
    import numpy as np

    from reflet.envmap.rotations import turn_about_vertical
    from reflet.errors import RefletError
    from reflet.files.env_image_file import read_light
    from reflet.files.pictures.exr import write_exr
    from reflet.files.pictures.picture_file import write_picture_file
    from reflet.files.pictures.png import write_png
    from reflet.pipelines.shade import OWN, frame_mesh, load_mesh, surface_material
    from reflet.pipelines.shade import shade as draw
    from reflet.pipelines.sketch import drawing_size, map_material, on_paper, shows_map, sketch
    from reflet.reflectance.materials.material_maps import EnvironmentMaps
    from reflet.report.measures import picture_srgb

    suffix = output.suffix.lower()
    if suffix not in (".png", ".exr"):
        raise RefletError(f"A picture is a .png or an .exr, not {output.name}.")
    if not (np.isfinite(turn) and 0.0 < exposure < np.inf):
        raise RefletError(f"A turn is a number of degrees, an exposure one above 0, not {turn:g} and {exposure:g}.")
    if shows_map(material):
        with progress_bar() as progress:
            progress("read", 0, 2)
            levels, lookup = map_material(material, environment, source_is, drawing_size(size))
            progress("read", 1, 2)
            shape = load_mesh(mesh)
            progress("read", 2, 2)
            progress("draw", 0, 1)
            orbit = frame_mesh(shape, azimuth_deg=azimuth, elevation_deg=elevation, distance=distance, image_size=size)
            drawn = sketch(shape, levels, orbit.camera(), lookup, int(samples), turn_about_vertical(turn))
            progress("draw", 1, 1)
        write_picture_file(output, drawn if no_backdrop else on_paper(drawn), {})
        click.echo(f"{output} is written.")
        return
    if environment is None:
        raise RefletError(
            f"The material {material} is lit by an environment, and none came; name a file after the mesh."
        )
    with progress_bar() as progress:
        progress("read", 0, 1)
        image = read_light(environment, source_is)
        progress("read", 1, 1)
        picture = draw(
            mesh,
            EnvironmentMaps(image, progress=lambda done, total: progress("filter", done, total)),
            material if material == OWN else surface_material(material, albedo, specular, metallic),
            azimuth_deg=azimuth,
            elevation_deg=elevation,
            distance=distance,
            image_size=size,
            turn_deg=turn,
            samples=int(samples),
            backdrop=not no_backdrop,
            progress=progress,
        )
    color, coverage = picture[..., :3], picture[..., 3:]
    if suffix == ".exr":
        write_exr(output, picture if no_backdrop else color)
    elif no_backdrop:
        # .png's alpha is not premultiplied.
        srgb = picture_srgb(np.divide(color, coverage, out=np.zeros_like(color), where=coverage > 0.0), exposure)
        write_png(output, np.concatenate([srgb, np.rint(255.0 * coverage).astype(np.uint8)], -1))
    else:
        write_png(output, picture_srgb(color, exposure))
    click.echo(f"{output} is written.")
