"""The comparison figure: methods side by side, places one under the other, the error under each picture; and curves."""

from io import BytesIO

import numpy as np
from jaxtyping import Float
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from reflet.report.comparison import METHODS, PLACES, Comparison, Exhibit
from reflet.report.curves import draw_curves
from reflet.report.measures import EXPOSURE, bounding_box, flip_map, tone_map

BACKGROUND = 0.96  # display value behind the object
ERROR_MAX = 0.5  # FLIP error at the top of the colour scale: such a pixel is plainly wrong
ERROR_COLOURS = colormaps["magma"]
INK, SOFT_INK = "#1d1d1f", "#6e6e73"
WIDTH, TITLE, CAPTION = 10.0, 0.4, 0.43  # inches: the figure's width, the heights of column titles and captions
CURVES, MARGIN = 2.6, 0.5  # inches: the height of the curves and of what lies around them

Picture = Float[np.ndarray, "height width 3"]


def comparison_figure(comparison: Comparison, exposure: float = EXPOSURE) -> bytes:
    """The figure as a PNG, 2000 pixels wide, laid out to be read at half that width.

    Columns are the ray-traced reference and the methods. For every place there is a row of pictures and a row of FLIP
    error images, with display PSNR, SSIM and FLIP (over all views of the place) as captions. Below, display PSNR by the
    camera's distance from the sampled orbit.
    """
    exhibits = comparison.exhibits
    shown = [method for method in comparison.methods if not method.startswith("distant-only")]
    columns = 1 + len(shown)
    title_size = min(8.4, 76.0 / columns)  # points: the longest word fits its column
    aspects = [exhibit.coverage.shape[0] / exhibit.coverage.shape[1] for exhibit in exhibits]
    heights = [TITLE]
    for aspect in aspects:
        heights += [WIDTH / columns * aspect, WIDTH / columns * aspect, CAPTION]
    heights.append(CURVES + MARGIN)
    figure = Figure(figsize=(WIDTH, sum(heights)), dpi=200, facecolor="white")
    grid = figure.add_gridspec(
        len(heights), columns, height_ratios=heights, left=0, right=1, bottom=0, top=1, hspace=0, wspace=0.02
    )

    def cell(row: int, column: int) -> Axes:
        axes = figure.add_subplot(grid[row, column])
        axes.set_axis_off()
        return axes

    _write(cell(0, 0), 0.5, "ray traced", size=title_size, weight="bold")
    for column, method in enumerate(shown, start=1):
        title = METHODS[method].replace(", ", "\n")
        _write(cell(0, column), 0.5, title, size=title_size, weight="bold" if method == comparison.played else "normal")
    for place, exhibit in enumerate(exhibits):
        row = 1 + 3 * place
        cell(row, 0).imshow(_over_background(exhibit.reference, exhibit, exposure))
        _describe(cell(row + 1, 0), exhibit)
        results = [comparison.result(exhibit.where, method) for method in shown]
        best = max(result.psnr_display for result in results)
        for column, result in enumerate(results, start=1):
            picture = exhibit.pictures[result.method]
            cell(row, column).imshow(_over_background(picture, exhibit, exposure))
            cell(row + 1, column).imshow(_error_image(picture, exhibit, exposure))
            caption = cell(row + 2, column)
            weight = "bold" if result.psnr_display == best else "normal"
            _write(caption, 0.8, f"{result.psnr_display:.1f} dB", size=8.4, weight=weight)
            _write(caption, 0.5, f"SSIM {_short(result.ssim)}", size=6.2, color=SOFT_INK)
            _write(caption, 0.24, f"FLIP {_short(result.flip)}", size=6.2, color=SOFT_INK)
    height = sum(heights)
    curves = figure.add_axes((MARGIN / WIDTH, MARGIN / height, 0.7, (CURVES - 0.1) / height))
    draw_curves(curves, comparison, shown, INK, SOFT_INK)
    out = BytesIO()
    # Without the library's version among the metadata, equal comparisons give equal files.
    figure.savefig(out, format="png", metadata={"Software": None})
    return out.getvalue()


def _write(axes: Axes, y: float, text: str, *, size: float, weight: str = "normal", color: str = INK) -> None:
    """One centred text at height ``y`` of an empty cell."""
    axes.text(
        0.5, y, text, ha="center", va="center", fontsize=size, fontweight=weight, color=color, transform=axes.transAxes
    )


def _describe(axes: Axes, exhibit: Exhibit) -> None:
    """Names the place beside its error images, and shows their colour scale."""
    _write(axes, 0.86, PLACES[exhibit.where], size=5.8, weight="bold")
    _write(axes, 0.68, f"azimuth {exhibit.azimuth_deg:.3g}°", size=5.8, color=SOFT_INK)
    _write(axes, 0.5, f"elevation {exhibit.elevation_deg:.3g}°", size=5.8, color=SOFT_INK)
    scale = axes.inset_axes((0.18, 0.26, 0.64, 0.07))
    scale.set_axis_off()
    scale.imshow(np.linspace(0.0, 1.0, 256)[None], aspect="auto", cmap=ERROR_COLOURS)
    _write(axes, 0.12, f"0   FLIP error   {ERROR_MAX:g}", size=5.8, color=SOFT_INK)


def _short(share: float) -> str:
    """Three decimals without the zero before them, which small type can spare."""
    return f"{share:.3f}".replace("0.", ".", 1)


def _over_background(radiance: Picture, exhibit: Exhibit, exposure: float) -> Picture:
    """The object as a display shows it, before light grey."""
    coverage = exhibit.coverage[..., None]
    return coverage * tone_map(radiance, exposure) + (1.0 - coverage) * BACKGROUND


def _error_image(radiance: Picture, exhibit: Exhibit, exposure: float) -> Picture:
    """FLIP error on the object's pixels in colour, before light grey."""
    rows, columns = bounding_box(exhibit.mask)
    error = np.zeros(exhibit.mask.shape)
    error[rows, columns] = flip_map(exhibit.reference, radiance, exhibit.mask, exposure)
    colour = ERROR_COLOURS(np.clip(error / ERROR_MAX, 0.0, 1.0))[..., :3]
    return np.where(exhibit.mask[..., None], colour, BACKGROUND)
