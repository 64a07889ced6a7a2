"""Any isotropic BRDF in prefiltered maps: a measured table as lobes, beside the whole of it by brute force.

Run it with the folder to write to, and if you like with a table and an environment of your own::

    python examples/any_brdf.py out/any_brdf [satin.npz [studio.hdr]]

``any_brdf.png`` shows, for the table of examples/brdf_table.py (paint, an off-specular gloss, retroreflecting dust; 2 %
noise) in a studio of three lamps:

- at the top the table in the plane of incidence, for four viewers: how much light each direction gives, f·cos θ, as
  table, as one lobe, and as three;
- in the middle a few slices of the three-dimensional map: the studio filtered with the glossy and the retroreflecting
  lobe as they are at these view angles, as lat-long maps;
- at the bottom a sphere: the whole BRDF summed over all texels, then maps of three lobes and of one, with what they
  err, in units of the sphere's mean radiance.

What correct looks like: with three lobes hardly a difference but towards the outline, where highlights are longer
than round lobes can be. A single lobe must be glossy and matt at once; it loses the highlights, all of them.
"""

import sys
from io import BytesIO
from pathlib import Path

import numpy as np
from brdf_table import measured
from jaxtyping import Float
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure
from matplotlib.patches import Circle

from reflet.envmap.env_image import EnvImage
from reflet.envmap.parameterizations.cube import CUBE
from reflet.envmap.parameterizations.latlong import LatLong
from reflet.envmap.resampling.resample import resample
from reflet.files.atomic import atomic_write
from reflet.files.env_image_file import read_env_image
from reflet.files.measured_brdf_file import read_measured_brdf
from reflet.reflectance.brdfs.brdf import Brdf
from reflet.reflectance.brdfs.brdf_reference import reflected_reference
from reflet.reflectance.lobes.lobe_frame import cosine_weighted
from reflet.reflectance.lobes.lobes import KINDS, Lobes, fit_lobes
from reflet.reflectance.prefilter.brdf_map import BrdfMap3d, brdf_map_3d, reflected_radiance
from reflet.report.measures import picture_srgb

ERROR_MAX = 0.5  # of the sphere's mean radiance, at the top of the colour scale
INK, SOFT, TABLE, ONE, THREE = "#1d1d1f", "#6e6e73", "#b9b9be", "#d2691e", "#1f5fbf"


def main(
    out: Path,
    table: Path | None = None,
    source: Path | None = None,
    picture: int = 144,
    rows: int = 32,
    angles: int = 16,
) -> dict[str, float]:
    """Writes the figure: spheres ``picture`` pixels wide, a cube of ``rows``² texels a face as environment, ``angles``
    view angles. Returns the mean errors that it prints, in shares of the mean radiance.
    """
    brdf: Brdf = read_measured_brdf(table) if table else measured()
    light = resample(read_env_image(source), CUBE, rows) if source else studio(rows)
    one, three = fit_lobes(brdf, ("glossy",), angles), fit_lobes(brdf, KINDS, angles)
    normal, wo = sphere(picture)
    exact = reflected_reference(light, brdf, normal, wo)
    maps = [brdf_map_3d(light, lobes, LatLong(), rows) for lobes in (three, one)]
    shown = [reflected_radiance(each, normal, wo) for each in maps]
    errors = {
        name: float(np.abs(each - exact).mean() / exact.mean())
        for name, each in zip(("three lobes", "one lobe"), shown, strict=True)
    }

    figure = Figure(figsize=(10.0, 9.2), dpi=150, facecolor="white")
    top, middle, bottom = figure.subfigures(3, 1, height_ratios=[2.5, 2.7, 4.0])
    draw_profiles(top, brdf, one, three)
    draw_slices(middle, maps[0])
    draw_spheres(bottom, picture, exact, shown, list(errors.items()))
    file = BytesIO()
    figure.savefig(file, format="png", metadata={"Software": None})
    out.mkdir(parents=True, exist_ok=True)
    atomic_write(out / "any_brdf.png", file.getvalue())
    for name, error in errors.items():
        print(f"{name}: mean error {error:.1%} of the mean radiance")
    return errors


def studio(rows: int) -> EnvImage:
    """Dim walls, warm below; a window to the left, a warm lamp to the right behind, and a small one overhead."""
    direction, _ = CUBE.texel_directions(rows)
    height = direction[..., 1:2]
    texels = 0.16 + 0.08 * height * np.array([-0.4, 0.4, 1.0])

    def lamp(towards: tuple[float, float, float], degrees: float, color: tuple[float, float, float]) -> np.ndarray:
        axis = np.array(towards) / np.linalg.norm(towards)
        angle = np.rad2deg(np.arccos(np.clip(direction @ axis, -1.0, 1.0)))[..., None]
        # An edge of three texels, so that their size does not matter
        return np.clip((degrees - angle) / (270.0 / rows) + 0.5, 0.0, 1.0) * np.array(color)

    texels = texels + lamp((-0.9, 0.45, 0.35), 22.0, (3.0, 3.4, 4.0)) + lamp((0.8, 0.3, -0.55), 12.0, (14.0, 9.5, 5.0))
    return EnvImage(CUBE, (texels + lamp((0.1, 1.0, 0.25), 8.0, (9.0, 9.0, 9.0))).astype(np.float32))


def sphere(picture: int) -> tuple[Float[np.ndarray, "n 3"], Float[np.ndarray, "n 3"]]:
    """Normals of a sphere's pixels, seen from far away along -z, and the directions to the viewer."""
    x, y = disc(picture)
    normal = np.stack([x, y, np.sqrt(1.0 - x * x - y * y)], -1)
    return normal, np.broadcast_to([0.0, 0.0, 1.0], normal.shape).copy()


def disc(picture: int) -> Float[np.ndarray, "2 n"]:
    """x and y of the pixels that show the sphere."""
    at = (np.arange(picture) + 0.5) / picture * 2.04 - 1.02
    x, y = np.meshgrid(at, -at)
    return np.stack([x, y])[:, x * x + y * y < 1.0]


def in_picture(values: Float[np.ndarray, "n 3"], picture: int, behind: float = 1.0) -> Float[np.ndarray, "h w 3"]:
    """The disc's pixels in their square."""
    at = (np.arange(picture) + 0.5) / picture * 2.04 - 1.02
    x, y = np.meshgrid(at, -at)
    square = np.full((picture, picture, 3), behind)
    square[x * x + y * y < 1.0] = values
    return square


def nearest(lobes: Lobes, degrees: float) -> int:
    """Number of the view angle."""
    return int(np.abs(np.arccos(lobes.cos_theta_o) - np.deg2rad(degrees)).argmin())


def draw_profiles(place: SubFigure, brdf: Brdf, one: Lobes, three: Lobes) -> None:
    """f·cos θ in the plane of incidence, by the light's angle."""
    angle = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 721)
    direction = np.stack([np.sin(angle), np.cos(angle), np.zeros_like(angle)], -1)
    place.subplots_adjust(left=0.06, right=0.985, bottom=0.2, top=0.84, wspace=0.25)
    for column, degrees in enumerate((20.0, 45.0, 60.0, 75.0)):
        k = nearest(three, degrees)
        view = np.rad2deg(np.arccos(three.cos_theta_o[k]))
        axes = place.add_subplot(1, 4, column + 1)
        exact = cosine_weighted(brdf, float(three.cos_theta_o[k]), direction)
        for values, color, width, label in (
            (exact, TABLE, 4.0, "table"), (one.cosine_weighted(k, direction), ONE, 1.0, "one lobe"),
            (three.cosine_weighted(k, direction), THREE, 1.0, "three lobes"),
        ):  # fmt: skip
            axes.plot(np.rad2deg(angle), values.mean(-1), color=color, linewidth=width, label=label)
        axes.axvline(view, color=SOFT, linewidth=0.6, linestyle=":")
        axes.axvline(-view, color=SOFT, linewidth=0.6, linestyle=":")
        axes.set_title(f"viewer at −{view:.0f}°", fontsize=8, color=INK)
        axes.set_xticks([-90, -45, 0, 45, 90], ["−90°", "−45°", "0°", "45°", "90°"])
        axes.set_xlim(-90, 90)
        axes.set_ylim(0, None)
        axes.tick_params(labelsize=6.5, colors=SOFT)
        axes.set_xlabel(f"light at; miss {one.error[k]:.0%} and {three.error[k]:.0%}", fontsize=7, color=INK)
        if column == 2:
            axes.legend(fontsize=6.5, frameon=False, loc="upper center")
    place.suptitle("f·cos θ in the plane of incidence (dotted: viewer and mirrored direction)", fontsize=8.5, color=INK)


def draw_slices(place: SubFigure, maps: BrdfMap3d) -> None:
    """A lobe a row."""
    place.subplots_adjust(left=0.01, right=0.99, bottom=0.02, top=0.82, wspace=0.03, hspace=0.12)
    at = [nearest(maps.lobes, degrees) for degrees in (75.0, 60.0, 45.0, 20.0)]
    for row, (lobe, slices) in enumerate(zip(maps.lobes.lobes, maps.slices, strict=True)):
        most = max(float(slices[k].texels.max()) for k in at)
        for column, k in enumerate(at):
            axes = place.add_subplot(2, 4, 4 * row + column + 1)
            axes.imshow(picture_srgb(slices[k].texels[0], 2.0 / most))
            view = np.rad2deg(np.arccos(maps.lobes.cos_theta_o[k]))
            title(axes, f"{lobe.name}, {view:.0f}°")
    place.suptitle("slices of the three-dimensional map, by lobe and view angle", fontsize=8.5, color=INK)


def draw_spheres(
    place: SubFigure, picture: int, exact: np.ndarray, shown: list[np.ndarray], errors: list[tuple[str, float]]
) -> None:
    """Above what is shown, below what it errs."""
    place.subplots_adjust(left=0.01, right=0.99, bottom=0.02, top=0.94, wspace=0.03, hspace=0.1)

    def add(number: int, values: np.ndarray, words: str) -> None:
        axes = place.add_subplot(2, 3, number)
        shown = axes.imshow(in_picture(values, picture), interpolation="lanczos")
        middle = 0.5 * (picture - 1)
        shown.set_clip_path(Circle((middle, middle), 0.972 * 0.5 * picture, transform=axes.transData))
        title(axes, words)

    def seen(values: np.ndarray) -> np.ndarray:
        return picture_srgb(values[None].astype(np.float32))[0] / 255.0

    add(1, seen(exact), "the whole BRDF, by brute force")
    for column, (values, (name, error)) in enumerate(zip(shown, errors, strict=True), start=2):
        add(column, seen(values), name)
        off = np.abs(values - exact).mean(-1) / exact.mean()
        add(
            3 + column,
            colormaps["magma"](np.minimum(off / ERROR_MAX, 1.0))[:, :3],
            f"error of {name}: mean {error:.1%}",
        )
    scale = place.add_axes((0.06, 0.24, 0.22, 0.025))
    scale.imshow(np.linspace(0.0, 1.0, 256)[None], aspect="auto", cmap="magma", extent=(0.0, ERROR_MAX, 0.0, 1.0))
    scale.set_yticks([])
    scale.tick_params(labelsize=6.5, colors=SOFT)
    scale.set_title("error, in units of the sphere's mean radiance", fontsize=7, color=INK)


def title(axes: Axes, words: str) -> None:
    """A picture without axes, under its title."""
    axes.set_axis_off()
    axes.set_title(words, fontsize=7.5, color=INK, pad=3)


if __name__ == "__main__":
    main(Path(sys.argv[1]), *(Path(each) for each in sys.argv[2:4]))
