"""``reflet join``."""

from pathlib import Path

import click

from reflet.cli.options import PARAMETERIZATION, Vector, layout_option
from reflet.cli.progress import progress_bar
from reflet.envmap.parameterizations.parameterization import Parameterization
from reflet.envmap.resampling.projections import PROJECTIONS


@click.command(short_help="Join two fisheye or mirror ball pictures into one environment map.")
@click.argument("front", metavar="FRONT", type=click.Path(path_type=Path))
@click.argument("back", metavar="[BACK]", required=False, type=click.Path(path_type=Path))
@click.option("-o", "--output", type=click.Path(path_type=Path), required=True, help="The map to write.")
@click.option(
    "--projection",
    type=click.Choice(list(PROJECTIONS)),
    default="equidistant",
    show_default=True,
    help="Of the lens, or the mirror's shape.",
)
@click.option("--fov", type=float, help="Degrees across the circle; by default 180, for a mirror ball 360.")
@click.option("--circle", type=Vector(), metavar="X,Y,R", help="Middle and radius of the circle in pixels.")
@click.option(
    "--back-circle",
    type=Vector(),
    metavar="X,Y,R",
    help="The same in BACK, where it differs, or of the other circle in FRONT.",
)
@click.option(
    "--back-turn",
    type=Vector(),
    metavar="YAW,PITCH,ROLL",
    default=(180.0, 0.0, 0.0),
    help="How the back camera was turned, in degrees; by default 180,0,0.",
)
@click.option(
    "--blend", type=float, help="Degrees over which one fades into the other; by default all that both see, at most 20."
)
@click.option("--balance", is_flag=True, help="Match BACK's exposure to FRONT's where both see.")
@click.option("--to", type=PARAMETERIZATION, default="dual_paraboloid", show_default=True, help="What to make of them.")
@click.option("--size", type=int, help="Rows of a face; by default about as many texels as there are pixels.")
@layout_option
def join(
    front: Path,
    back: Path | None,
    output: Path,
    projection: str,
    fov: float | None,
    circle: tuple[float, float, float] | None,
    back_circle: tuple[float, float, float] | None,
    back_turn: tuple[float, float, float],
    blend: float | None,
    balance: bool,
    to: Parameterization,
    size: int | None,
    layout: str | None,
) -> None:
    """Joins two round pictures that were taken back to back; alpha between 0 and 1 hides the border.

    The middle of FRONT becomes +z. A mirror is photographed from the side it shows: FRONT from +z. Without BACK, a
    FRONT of 2:1 or 1:2 holds both circles, that of the front left or above, as 360° cameras write them (elsewhere:
    --circle and --back-circle); any other is mirrored for the other half.

    \b
    Examples:
      reflet join front.jpg back.jpg --fov 190 -o room.exr
      reflet join front.exr back.exr --fov 195 --blend 6 --balance --to latlong -o room.hdr
      reflet join ball1.hdr ball2.hdr --projection mirror_ball --blend 20 --circle 1024,1030,980 -o probe.exr
      reflet join camera360.jpg --fov 195 --to latlong -o room.exr
      reflet join sky.jpg -o sky.exr
    """
    from reflet.pipelines.join import camera_turn
    from reflet.pipelines.join import join as join_files

    with progress_bar() as progress:
        image = join_files(
            front,
            back,
            output,
            projection=projection,
            fov_deg=fov,
            circle=circle,
            back_circle=back_circle,
            front_from_back=camera_turn(*back_turn),
            blend_deg=blend,
            balance=balance,
            to=to,
            size=size,
            layout=layout,
            progress=progress,
        )
    click.echo(f"{output} is written: {image.parameterization}, {image.size} rows a face.")
