"""How far Schlick's approximation of Fresnel's formulas is off, as a figure."""

import os
from collections.abc import Sequence

import numpy as np
from matplotlib import colormaps
from matplotlib.figure import Figure

from reflet.files.atomic import atomic_path
from reflet.reflectance.brdfs.fresnel_error import SchlickError

INK, SOFT_INK, PAPER = "#1d1d1f", "#6e6e73", "#ffffff"
COLOURS = colormaps["tab10"].colors  # type: ignore[attr-defined]


def write_schlick_figure(path: str | os.PathLike[str], errors: Sequence[SchlickError]) -> None:
    """Writes a PNG, 1600 pixels wide: reflectance over the angle, exact and Schlick's, and their difference."""
    figure = Figure(figsize=(10.0, 4.3), dpi=160, facecolor=PAPER)
    both, difference = figure.subplots(1, 2)
    for each, colour in zip(errors, COLOURS, strict=False):
        degrees = np.degrees(each.theta)
        words = f"n = {each.n:.3g}" + (f" − {each.k:.3g}i" if each.k else "")
        both.plot(degrees, each.exact, color=colour, linewidth=1.4)
        both.plot(degrees, each.schlick, color=colour, linewidth=1.2, linestyle=(0, (3, 2)))
        difference.plot(degrees, each.schlick - each.exact, color=colour, linewidth=1.4, label=words)
    difference.legend(loc="upper left", frameon=False, fontsize=8, labelcolor=INK)
    both.set_title("reflectance; Schlick's dashed", fontsize=9, color=INK, loc="left", weight="bold")
    difference.set_title("Schlick's minus exact", fontsize=9, color=INK, loc="left", weight="bold")
    difference.axhline(0.0, color="#c7c7cc", linewidth=0.8)
    both.set_ylim(0.0, 1.0)
    for axes in (both, difference):
        axes.set_xlim(0.0, 90.0)
        axes.set_xticks([0, 30, 60, 90], ["0°", "30°", "60°", "90°"])
        axes.set_xlabel("angle to the normal", fontsize=8, color=INK)
        axes.tick_params(labelsize=8, colors=SOFT_INK, length=2)
        axes.grid(color="#e5e5ea", linewidth=0.6)
        for side in ("top", "right"):
            axes.spines[side].set_visible(False)
        for side in ("left", "bottom"):
            axes.spines[side].set_color("#c7c7cc")
    figure.tight_layout()
    with atomic_path(path) as temporary:
        figure.savefig(temporary, format="png", metadata={"Software": None})
