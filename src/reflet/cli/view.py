"""``reflet view``."""

import shlex
from pathlib import Path
from tempfile import TemporaryDirectory

import click

from reflet.cli.options import from_option
from reflet.cli.progress import progress_bar
from reflet.cli.shade import RGB
from reflet.envmap.parameterizations.parameterization import Parameterization


@click.command(short_help="Look at a PEM, or at a mesh in an environment, in the browser.")
@click.argument("scene", metavar="PEM|MESH")
@click.argument("environment", metavar="[ENV]", type=click.Path(path_type=Path), required=False)
@click.option("--material", "materials", multiple=True, metavar="NAME[:VALUE]", help="To open with; may be repeated.")
@click.option("--albedo", type=RGB, help="Diffuse colour, base colour, or a mirror's reflectance; linear, 0 to 1.")
@click.option("--specular", type=RGB, help="Phong's specular share; by default what --albedo leaves.")
@click.option("--metallic", type=click.FloatRange(0, 1), default=0.0, show_default=True, help="For ggx.")
@click.option("--azimuth", type=float, help="Of the first view of a mesh, in degrees.")
@click.option("--elevation", type=click.FloatRange(-90, 90), help="Likewise.")
@click.option("--distance", type=float, help="Metres from the mesh's middle; by default such that all of it shows.")
@from_option
@click.option(
    "--export", "out", type=click.Path(path_type=Path), help="Write a page for any web host into this folder."
)
@click.option("--port", type=click.IntRange(0, 65535), default=0, help="Port on this machine; 0 takes a free one.")
@click.option(
    "--host",
    "hosts",
    multiple=True,
    metavar="NAME|ADDRESS",
    help="A name to answer to beside localhost, such as a proxy's, or the address to listen on, such as 0.0.0.0.",
)
@click.option("--no-browser", is_flag=True, help="Print the address only.")
def view(
    scene: str,
    environment: Path | None,
    materials: tuple[str, ...],
    albedo: tuple[float, float, float] | None,
    specular: tuple[float, float, float] | None,
    metallic: float,
    azimuth: float | None,
    elevation: float | None,
    distance: float | None,
    source_is: Parameterization | None,
    out: Path | None,
    port: int,
    hosts: tuple[str, ...],
    no_browser: bool,
) -> None:
    """Serves a PEM, an exported page, or a MESH (a .glb, .gltf or .obj file, or sphere, torus, teapot) lit by ENV, and
    the viewer to this machine alone, and opens the browser. Ctrl-C ends it.

    In the viewer material, colours, gloss, light and camera change at once: maps are filtered on the graphics device.
    Materials are those of reflet shade, but for gltf; without ENV, its drawings.

    \b
    Examples:
      reflet view teapot                                       a PEM's folder
      reflet view teapot studio.hdr --material ggx:0.3 --metallic 1
      reflet view teapot studio.hdr --material table:satin.npz
      reflet view chair.glb studio.hdr --export site           a page to upload
      reflet view site                                         the same, here
      reflet view teapot --host hub.example.org                behind a proxy of that name
      reflet view teapot --material gooch+silhouette --material hatching
    """
    from reflet.errors import RefletError
    from reflet.pipelines.shade import BUILT_IN
    from reflet.pipelines.view_materials import write_materials_view
    from reflet.view.export import export_viewer
    from reflet.view.server import serve

    def show(folder: str | Path) -> None:
        if out is None:
            serve(folder, port=port, open_browser=not no_browser, name=scene, hosts=hosts)
        else:
            index = export_viewer(folder, out)
            look = shlex.join(["reflet", "view", str(out)])
            click.echo(
                f"{index} is written, for a web server: opened as a file it draws nothing. Look at it with: {look}"
            )

    if environment is None and not materials:
        if (scene in BUILT_IN and not Path(scene).exists()) or Path(scene).suffix.lower() in (".glb", ".obj"):
            raise RefletError(
                f"The mesh {scene} needs an environment map after it, or a drawing, such as --material gooch."
            )
        if Path(scene).is_file() and Path(scene).suffix.lower() not in (".gltf", ".xml"):
            command = shlex.join(["reflet", "view", "teapot", scene])
            raise RefletError(f"{scene} is no PEM's folder; an environment map is seen on a mesh: {command}")
        show(scene)
        return
    with TemporaryDirectory(prefix="reflet-view-") as folder:
        with progress_bar() as progress:
            write_materials_view(
                folder,
                scene,
                environment,
                materials,
                source_is=source_is,
                albedo=albedo,
                specular=specular,
                metallic=metallic,
                azimuth_deg=azimuth,
                elevation_deg=elevation,
                distance=distance,
                progress=progress,
            )
        show(folder)
