"""What methods score by how far the camera stands from the sampled orbit."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from matplotlib import colormaps
from matplotlib.axes import Axes

from reflet.report.comparison import METHODS, Comparison

BIN_DEG = 5.0  # viewpoints whose displacement differs by less are pooled into one point of a curve
_COLOURS = colormaps["tab20"]


def curve(comparison: Comparison, method: str) -> tuple[Float[np.ndarray, "points"], Float[np.ndarray, "points"]]:
    """Degrees of displacement and display PSNR in dB of one method: on the sampled range all viewpoints in one point,
    off it those of every `BIN_DEG` degrees. Squared errors are pooled, each viewpoint counting alike."""
    views = [view for view in comparison.views if view.method == method]
    away = np.array([view.viewpoint.away_deg for view in views])
    error = 10.0 ** (-0.1 * np.array([view.psnr_display for view in views]))
    _, bins = np.unique(np.ceil(away / BIN_DEG), return_inverse=True)
    count = np.bincount(bins)
    with np.errstate(divide="ignore"):  # where nothing differs
        psnr = -10.0 * np.log10(np.bincount(bins, error) / count)
    return np.bincount(bins, away) / count, psnr


def draw_curves(axes: Axes, comparison: Comparison, methods: Sequence[str], ink: str, soft_ink: str) -> None:
    """Draws the `curve` of each method and the reference's noise floor, with their names."""
    for method in methods:
        played = method == comparison.played
        colour = ink if played else _COLOURS(list(METHODS).index(method))
        axes.plot(
            *curve(comparison, method), marker="o", markersize=3, linewidth=2.0 if played else 1.1, color=colour,
            label=METHODS[method],
        )  # fmt: skip
    floor = comparison.context.get("reference_noise_psnr_display")
    if floor is not None:
        axes.axhline(floor, color=soft_ink, linewidth=0.8, linestyle=":", label="noise of the reference")
    axes.set_xlabel("degrees of the camera from the sampled orbit", fontsize=7.5, color=ink)
    axes.set_ylabel("display PSNR, dB", fontsize=7.5, color=ink)
    axes.tick_params(labelsize=7, colors=soft_ink)
    axes.grid(color="#e3e3e6", linewidth=0.6)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    axes.legend(fontsize=7, loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False)
