"""Mip levels by plain means of 2×2 texels beside ours: mirror spheres, and what happens to the light in all."""

import os
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from matplotlib.figure import Figure
from matplotlib.ticker import PercentFormatter

from reflet.files.atomic import atomic_path
from reflet.report.measures import picture_srgb

INK, SOFT_INK, PAPER = "#1d1d1f", "#6e6e73", "#ffffff"
PLAIN, WEIGHTED = "#d62728", "#1f77b4"
ROWS = ("means of 2×2", "by solid angle", "footprints of\nthe finest level")

Picture = Float[np.ndarray, "pixels pixels 3"]


@dataclass(frozen=True)
class MipComparison:
    """One parameterization: pictures with one coarse level, in the order of `ROWS`, and the error of the total radiance
    ∫ L dω on every level, relative to the finest, where levels are plain means and where they are ours."""

    title: str
    pictures: tuple[Picture, Picture, Picture]
    plain_error: Float[np.ndarray, "levels"]
    our_error: Float[np.ndarray, "levels"]


def write_mip_figure(path: str | os.PathLike[str], comparisons: Sequence[MipComparison]) -> None:
    """Writes a PNG, 1500 pixels wide: a column for each parameterization, spheres above, charts below."""
    figure = Figure(figsize=(10.0, 7.4), dpi=150, facecolor=PAPER)
    grid = figure.add_gridspec(
        4, len(comparisons), left=0.085, right=0.99, bottom=0.075, top=0.955, wspace=0.06, hspace=0.06,
        height_ratios=(1.0, 1.0, 1.0, 0.95),
    )  # fmt: skip
    highest = max(np.abs(each.plain_error).max() for each in comparisons)
    for column, each in enumerate(comparisons):
        for row, (title, picture) in enumerate(zip(ROWS, each.pictures, strict=True)):
            axes = figure.add_subplot(grid[row, column])
            axes.imshow(picture_srgb(picture), interpolation="lanczos")
            axes.set_xticks([])
            axes.set_yticks([])
            axes.set_frame_on(False)
            if row == 0:
                axes.set_title(each.title, fontsize=8, color=INK, pad=5)
            if column == 0:
                axes.set_ylabel(title, fontsize=8, color=INK)
        axes = figure.add_subplot(grid[3, column])
        axes.axhline(0.0, color=SOFT_INK, linewidth=0.5)
        levels = np.arange(len(each.plain_error))
        axes.plot(levels, each.plain_error, color=PLAIN, linewidth=1.2, marker="o", markersize=2.5, label=ROWS[0])
        axes.plot(levels, each.our_error, color=WEIGHTED, linewidth=1.2, marker="o", markersize=2.5, label=ROWS[1])
        axes.set_ylim(-1.1 * highest, 1.1 * highest)
        axes.set_xlabel("mip level", fontsize=7, color=INK, labelpad=2)
        axes.set_xticks(levels[::2])
        axes.tick_params(labelsize=6.5, colors=SOFT_INK, length=2, labelleft=column == 0)
        axes.yaxis.set_major_formatter(PercentFormatter(1.0, decimals=0))
        for side in ("top", "right"):
            axes.spines[side].set_visible(False)
        if column == 0:
            axes.set_ylabel("light gained or lost", fontsize=8, color=INK)
            axes.legend(fontsize=6.5, frameon=False, loc="lower left", handlelength=1.2)
    with atomic_path(path) as temporary:
        figure.savefig(temporary, format="png")
