"""``reflet bake``."""

import shlex
from pathlib import Path

import click

from reflet.cli.options import VARIANTS, Vector, codec_option, from_option, layer_option, variant_option
from reflet.cli.progress import progress_bar
from reflet.envmap.geometry import KINDS, SHAPES
from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS
from reflet.envmap.parameterizations.parameterization import Parameterization
from reflet.envmap.rotations import SOURCE_FROM_UPRIGHT
from reflet.errors import RefletError
from reflet.pem.layout import Codec
from reflet.pem.pem import MOST_SHELLS
from reflet.scene.floor_kinds import KINDS as KINDS_OF_FLOOR
from reflet.scene.floor_kinds import Floor
from reflet.scene.roughness import TRACED_ROUGHNESS


@click.command(short_help="Bake a scene into a folder of environment maps.")
@click.argument("scene", metavar="SCENE")
@click.option("--environment", type=click.Path(path_type=Path), help="An environment map of any kind around the scene.")
@from_option
@layer_option
@click.option(
    "--up",
    type=click.Choice(list(SOURCE_FROM_UPRIGHT)),
    help="The axis of SCENE that points up; z turns +z to +y. By default y, or what a Mitsuba camera says.",
)
@click.option(
    "--views",
    type=click.IntRange(0),
    help="Number of viewpoints with maps of their own: by default none where local light is traced, else 3.",
)
@click.option(
    "--spacing",
    type=click.FloatRange(0, min_open=True),
    default=2.0,
    show_default=True,
    help="Degrees of azimuth from one viewpoint to the next.",
)
@click.option(
    "--axis",
    "axes",
    metavar="NAME=FROM:TO:COUNT",
    multiple=True,
    help="Viewpoints on a grid, instead of --views: COUNT of azimuth_deg, elevation_deg or distance; repeat for "
    "several axes. A whole turn of azimuths is closed: its end is its beginning.",
)
@click.option("--azimuth", type=float, help="Azimuth of the first viewpoint in degrees; 0 looks from +x, 90 from -z.")
@click.option("--elevation", type=click.FloatRange(-90, 90), help="Height of the viewpoints in degrees.")
@click.option("--distance", type=float, help="Metres from the target to the camera.")
@click.option("--target", type=Vector(), help="The point that the camera looks at.")
@click.option("--fov", type=float, help="Vertical field of view in degrees.")
@click.option("--image-size", type=click.IntRange(1), default=512, show_default=True, help="Pixels along an edge.")
@click.option(
    "--parameterization",
    type=click.Choice(list(PARAMETERIZATIONS)),
    default="cube",
    show_default=True,
    help="How maps lay directions out.",
)
@click.option(
    "--em-size",
    type=click.IntRange(1),
    help="Rows of a map's face; by default as fine as a cube of 256² texels a face.",
)
@click.option("--spp", type=click.IntRange(1), default=64, show_default=True, help="Rays traced a pixel.")
@click.option(
    "--distant",
    type=click.Choice(["auto", *KINDS]),
    default="auto",
    show_default=True,
    help="Geometry of the distant surroundings; relief: their own distances; auto: what shows them best; with a shape, "
    "as in the paper, each viewpoint has maps of its own and nothing else.",
)
@click.option(
    "--shells",
    type=click.IntRange(1, MOST_SHELLS),
    help="Shells that divide the distant surroundings, where reliefs describe them; by default as many as pay.",
)
@click.option(
    "--static",
    is_flag=True,
    help="Static maps only, seen from the object's centre: seconds of work, for any viewpoint.",
)
@click.option(
    "--joint-spacing",
    type=click.FloatRange(5.0, 180.0),
    help="Infer the maps for all viewpoints, from viewpoints so many degrees apart; by default 20 beside the baked "
    "viewpoints and 40 elsewhere, and with traced local light only if static maps show less.",
)
@click.option(
    "--local",
    type=click.Choice(["traced", *SHAPES]),
    default="traced",
    show_default=True,
    help="How parts show one another in their mirrors: their own mesh traced, or, as in the paper, maps around each "
    "part, on a shape.",
)
@click.option(
    "--reflect",
    multiple=True,
    metavar="NAME",
    help="A part that reflects, or 'none-of NAME' one that does not; may be given repeatedly.",
)
@click.option(
    "--floor",
    type=click.Choice(KINDS_OF_FLOOR),
    is_flag=False,
    flag_value="matte",
    help="Set SCENE on a floor that shows the environment and takes its shadow; polished: that mirrors it, too; "
    "shadow: of which nothing else is seen. --floor alone is matte.",
)
@click.option(
    "--floor-height",
    type=click.FloatRange(0, min_open=True),
    help="Metres above the floor from which the environment was photographed; by default SCENE's diagonal.",
)
@click.option(
    "--floor-radius",
    type=click.FloatRange(0, min_open=True),
    help="Metres from SCENE's middle to the floor's rim; by default 10 heights.",
)
@click.option(
    "--floor-roughness",
    type=click.FloatRange(0, TRACED_ROUGHNESS),
    help="Perceptual roughness of a polished floor.  [default: 0.1]",
)
@codec_option
@variant_option
@click.option("--resume", is_flag=True, help="Go on with a bake that was stopped, with the same options.")
@click.option("--out", type=click.Path(path_type=Path), required=True, help="Folder to write the PEM to.")
def bake(
    scene: str,
    environment: Path | None,
    source_is: Parameterization | None,
    layer: str | None,
    up: str | None,
    views: int | None,
    spacing: float,
    axes: tuple[str, ...],
    azimuth: float | None,
    elevation: float | None,
    distance: float | None,
    target: tuple[float, float, float] | None,
    fov: float | None,
    image_size: int,
    parameterization: str,
    em_size: int | None,
    spp: int,
    distant: str,
    shells: int | None,
    static: bool,
    joint_spacing: float | None,
    local: str,
    reflect: tuple[str, ...],
    floor: str | None,
    floor_height: float | None,
    floor_radius: float | None,
    floor_roughness: float | None,
    codec: Codec,
    variant: str,
    resume: bool,
    out: Path,
) -> None:
    """Traces SCENE from all around and infers the environment maps that show it best from everywhere; viewpoints may
    have maps of their own.

    SCENE is a .glb, .gltf or .obj file, a Mitsuba .xml scene, or the built-in teapot-room. Metal, glass and what is
    smooth reflect, under an environment all else too, each by its own material; a mesh without a material is a mirror.
    What is not given is chosen to frame the reflecting object.

    \b
    Examples:
      reflet bake teapot-room --out teapot
      reflet bake ball.glb --environment studio.hdr --out ball
      reflet bake ball.obj --up z --environment probe.exr --from angular --out ball
      reflet bake ball.glb --environment garden.hdr --floor --out ball
      reflet bake ball.glb --environment garden.hdr --floor polished --out ball
      reflet bake ball.glb --environment garden.hdr --floor shadow --out ball
      reflet bake shop.glb --reflect 'Vase*' --elevation 15 --out vase
      reflet bake shop.glb --static --out quick
      reflet bake shop.glb --distant box --local ellipsoid --views 24 --spacing 5 --out as-in-the-paper
      reflet bake ball.glb --parameterization octahedral --em-size 512 --out ball
      reflet bake shop.glb --views 24 --spacing 5 --out shop --resume
      reflet bake shop.glb --axis azimuth_deg=0:360:12 --axis elevation_deg=0:60:3 --out dome
    """
    if static and (views or axes or joint_spacing):
        raise RefletError(
            "Static maps are inferred from no viewpoints: give --static, or --views, --axis and --joint-spacing."
        )
    if axes and views is not None:
        raise RefletError("Viewpoints are given twice: give --views and --spacing, or --axis.")
    if floor is None and any(given is not None for given in (floor_height, floor_radius, floor_roughness)):
        raise RefletError("It is said what the floor is like, but there is none; add --floor.")
    with progress_bar() as progress:
        progress("read", 0, 3)  # also while modules are loaded
        from reflet.pem.reader import read_statistics
        from reflet.pipelines.bake import bake as bake_scene
        from reflet.pipelines.bake import default_views
        from reflet.pipelines.load import load_scene
        from reflet.report.distant_choice import base_choice, distant_choice
        from reflet.scene.views.axes import axis_from_text
        from reflet.scene.views.framing import frame_orbit
        from reflet.scene.views.parameter_space import ParameterSpace, orbit_space

        asked = tuple(axis_from_text(axis) for axis in axes)
        loaded = load_scene(
            scene,
            environment=environment,
            reflect=reflect,
            source_is=source_is,
            layer=layer,
            up=up,
            floor=None if floor is None else Floor(floor_height, floor_radius, floor, floor_roughness),
            progress=progress,
        )
        orbit = frame_orbit(
            loaded,
            azimuth_deg=azimuth,
            elevation_deg=elevation,
            distance=distance,
            target=target,
            fov_deg=fov,
            image_size=image_size,
        )
        space = orbit_space(orbit, default_views(local) if views is None else views, spacing)
        bake_scene(
            loaded,
            out,
            ParameterSpace(asked, orbit) if asked else space,
            parameterization=parameterization,
            em_size=em_size,
            spp=spp,
            distant=distant,
            shells=shells,
            static=static,
            joint_spacing_deg=joint_spacing,
            local=local,
            codec=codec,
            variant=VARIANTS[variant],
            resume=resume,
            progress=progress,
        )
    names, statistics = read_statistics(out)
    for name, choice in zip(names, statistics["distant"], strict=True):
        click.echo(distant_choice(name, choice))
    if "base" in statistics:
        click.echo(base_choice(statistics["base"]))
    click.echo(f"{out} is ready; look at it with: {shlex.join(['reflet', 'view', str(out)])}")
