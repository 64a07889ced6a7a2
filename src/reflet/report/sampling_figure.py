"""How evenly parameterizations sample directions: curves over the angle, the sphere in pictures, and a table."""

import os
from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator
from rich import box
from rich.table import Table

from reflet.envmap.sampling import SamplingRates
from reflet.files.atomic import atomic_path
from reflet.report.table import table_text

INK, SOFT_INK, PAPER = "#1d1d1f", "#6e6e73", "#ffffff"
LINES = colormaps["tab10"].colors  # type: ignore[attr-defined]
RATES = colormaps["RdBu"]  # red where texels lack, blue where there are too many
LEAST, MOST = 1 / 4, 4.0  # the ends of axes and colours
PICTURE = 320  # pixels across a picture of the sphere

COLUMNS = ("by area", "along the worst axis", "along the best axis")


def write_sampling_figure(path: str | os.PathLike[str], rates: Sequence[SamplingRates]) -> None:
    """Writes a PNG, 2000 pixels wide.

    On top the rates over the angle to each map's axis, one line a map, or a band where they change around the axis.
    Below, the whole sphere of each map, its axis in the middle, all places true in area.
    """
    figure = Figure(figsize=(10.0, 9.2), dpi=200, facecolor=PAPER)
    charts = figure.add_gridspec(1, 3, left=0.06, right=0.985, bottom=0.62, top=0.945, wspace=0.17)
    for column, (title, name) in enumerate(zip(COLUMNS, ("area", "least", "most"), strict=True)):
        axes = figure.add_subplot(charts[0, column])
        _chart(axes, f"texels {'a steradian' if column == 0 else 'a radian, ' + title}", rates, name)
        if column == 0:
            axes.set_ylabel("relative to an even map of as many texels", fontsize=7.5, color=INK)
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(
        handles, labels, ncols=len(rates), loc="upper center", bbox_to_anchor=(0.52, 0.578), frameon=False,
        fontsize=7.5, handlelength=1.3, columnspacing=1.4,
    )  # fmt: skip
    pictures = figure.add_gridspec(
        3, len(rates), left=0.06, right=0.985, bottom=0.075, top=0.515, hspace=0.06, wspace=0.06
    )
    norm = LogNorm(LEAST, MOST)
    for row, (title, name) in enumerate(zip(COLUMNS, ("area", "least", "most"), strict=True)):
        for column, each in enumerate(rates):
            axes = figure.add_subplot(pictures[row, column])
            image = axes.imshow(sphere_picture(getattr(each, name)), cmap=RATES, norm=norm, interpolation="nearest")
            axes.set_xticks([])
            axes.set_yticks([])
            axes.set_frame_on(False)
            if row == 0:
                axes.set_title(_words(each), fontsize=7.0, color=INK, pad=4)
            if column == 0:
                axes.set_ylabel(title, fontsize=7.5, color=INK, labelpad=6)
    bar = figure.colorbar(image, cax=figure.add_axes((0.3, 0.045, 0.4, 0.012)), orientation="horizontal", extend="both")
    _ticks(bar.ax.xaxis)
    bar.outline.set_visible(False)  # type: ignore[operator]
    bar.ax.tick_params(labelsize=7, colors=SOFT_INK, length=2)
    with atomic_path(path) as temporary:
        figure.savefig(temporary, format="png")


def sphere_picture(rates: Float[np.ndarray, "angles azimuths"]) -> Float[np.ndarray, "pixels pixels"]:
    """The sphere in Lambert's equal-area projection, angle 0 in the middle, π on the rim; NaN outside.

    Rates beyond the colours' ends are taken as these, for 0 has no logarithm.
    """
    place = (2.0 * np.arange(PICTURE) + 1.0) / PICTURE - 1.0
    radius = np.hypot(place[None, :], place[:, None])
    angle = 2.0 * np.arcsin(np.minimum(radius, 1.0)) / np.pi
    azimuth = np.arctan2(-place[:, None], place[None, :]) / (2.0 * np.pi) % 1.0
    angles, azimuths = rates.shape
    row = np.minimum((angle * angles).astype(int), angles - 1)
    column = np.minimum((azimuth * azimuths).astype(int), azimuths - 1)
    return np.where(radius <= 1.0, np.clip(rates[row, column], LEAST, MOST), np.nan)


def sampling_table(rates: Sequence[SamplingRates]) -> str:
    """Extremes of all rates, their ratio by area, the longest texel, and what resolving all directions costs."""
    table = Table("texels, relative to an even map", box=box.SIMPLE_HEAD)
    for heading in ("a steradian", "ratio", "a radian, worst axis … best", "longest texel", "cost"):
        table.add_column(heading, justify="right")
    for each in rates:
        table.add_row(
            each.parameterization,
            _span(each.area_extremes),
            _number(each.area_ratio),
            _span(each.axis_extremes),
            _number(each.longest_texel) + " : 1",
            _number(each.cost),
        )
    return (
        table_text(table)
        + "\n  cost: how many times the texels of an even map resolve as much everywhere along every axis"
    )


def _chart(axes: Axes, title: str, rates: Sequence[SamplingRates], name: str) -> None:
    for k, (each, colour) in enumerate(zip(rates, LINES, strict=False)):
        values: np.ndarray = getattr(each, name)
        degrees = np.degrees(each.angle)
        low, high = values.min(1), values.max(1)
        # Every other line is dashed and above the rest: where two are one, both are seen.
        style = {"linestyle": (0, (4, 2)) if k % 2 else "solid", "zorder": 3 + k % 2, "color": colour}
        if np.ptp(values, axis=1).max() > 1e-9:
            axes.fill_between(degrees, low, high, color=colour, alpha=0.18, linewidth=0)
            axes.plot(degrees, high, linewidth=0.7, **style)
        axes.plot(degrees, low, linewidth=1.3, label=_words(each, " "), **style)
    axes.set_title(title, fontsize=8.5, color=INK, loc="left", weight="bold")
    axes.set_yscale("log")
    axes.set_ylim(LEAST, MOST)
    axes.set_xlim(0.0, 180.0)
    axes.set_xticks([0, 45, 90, 135, 180], ["0°", "45°", "90°", "135°", "180°"])
    _ticks(axes.yaxis)
    axes.tick_params(labelsize=7, colors=SOFT_INK, length=2)
    axes.grid(color="#e5e5ea", linewidth=0.6)
    axes.set_xlabel("angle to the map's axis", fontsize=7.5, color=INK)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    for side in ("left", "bottom"):
        axes.spines[side].set_color("#c7c7cc")


def _ticks(axis) -> None:  # type: ignore[no-untyped-def]
    axis.set_major_locator(FixedLocator([0.25, 0.5, 1.0, 2.0, 4.0]))
    axis.set_minor_locator(NullLocator())
    axis.set_major_formatter(FuncFormatter(lambda value, _: {0.25: "¼", 0.5: "½"}.get(value, f"{value:g}")))


def _words(rates: SamplingRates, gap: str = "\n") -> str:
    axis = next(f"{'-' if c < 0 else '+'}{'xyz'[k]}" for k, c in enumerate(rates.axis) if c)
    return f"{rates.parameterization.replace('_', ' ')}{gap}({axis})"


def _span(extremes: tuple[float, float]) -> str:
    return f"{_number(extremes[0])} … {_number(extremes[1])}"


def _number(value: float) -> str:
    return f"{value:.2f}" if np.isfinite(value) else "∞"
