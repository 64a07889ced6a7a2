"""The page that shows one environment in all parameterizations."""

import html
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from reflet.envmap.sampling import SamplingRates
from reflet.report.page import PAGE_STYLE

_STYLE = """
body { max-width: 74rem; }
.row { display: grid; grid-template-columns: minmax(0, 1fr) minmax(0, 1fr); gap: 1.4rem; align-items: center; }
.views { display: grid; grid-template-columns: repeat(2, minmax(0, 1fr)); gap: .5rem; }
.views.four { grid-template-columns: repeat(4, minmax(0, 1fr)); }
.views figure, .row > figure { margin: 0; } .views img { border-radius: .4rem; width: 100%; }
.flat img { width: 100%; }
section { margin: 3.2rem 0; } section p { margin-top: .2rem; }
@media (max-width: 46rem) { .row { grid-template-columns: 1fr; } }
"""


@dataclass(frozen=True)
class View:
    """One picture of a mirror with an environment map on it."""

    title: str
    file: str
    psnr_display: float  # against the reference of the same view, dB


@dataclass(frozen=True)
class Showcase:
    """One parameterization: its map laid flat, mirrors that wear it, and what to see there."""

    name: str
    size: str
    rates: SamplingRates
    watch: str
    flat_file: str
    views: tuple[View, ...]


def parameterizations_page(showcases: Sequence[Showcase], references: Sequence[View], texels: int, source: str) -> str:
    """The HTML page; pictures are files beside it. ``references`` are the views with a map of far more texels."""
    heads = "".join(f"<th>{html.escape(view.title)}</th>" for view in references)
    rows = "".join(
        f'<tr><td><a href="#{s.name}">{_words(s.name)}</a></td><td>{s.size}</td><td>{_number(s.rates.area_ratio)}</td>'
        f"<td>{_number(s.rates.longest_texel)}</td><td>{_number(s.rates.cost)}</td>"
        + "".join(f"<td>{view.psnr_display:.1f}</td>" for view in s.views)
        + "</tr>"
        for s in showcases
    )
    sections = "".join(
        f"""<section id="{s.name}"><h2>{_words(s.name).capitalize()}</h2><p>{html.escape(s.watch)}</p>
<div class="row"><figure class="flat"><img alt="{_words(s.name)}, laid flat" src="{s.flat_file}">
<figcaption>The map, {s.size} texels</figcaption></figure>
<div class="views">{"".join(_figure(view, f"{view.psnr_display:.1f} dB") for view in s.views)}</div></div></section>
"""
        for s in showcases
    )
    return f"""<!doctype html>
<html lang="en">
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>One environment, seven parameterizations</title>
<style>{PAGE_STYLE}{_STYLE}</style>
<h1>One environment, seven parameterizations</h1>
<p>{html.escape(source)}, stored in seven ways with about {texels:,} texels over all directions each, and mirrored in a
sphere and a torus from two sides. Look for lines that bend or break where faces meet, for texels that show, and for
text: what a mirror shows is mirrored, what lies behind it reads as it should.</p>
<div class="views four">
{"".join(_figure(view, "reference") for view in references)}</div>
<h2>Numbers</h2>
<div class="scroll"><table>
<tr><th>parameterization</th><th>texels</th><th>densest<br>: sparsest</th><th>longest<br>texel</th><th>cost</th>
{heads}</tr>
{rows}</table></div>
<p class="soft">Display PSNR in dB on the mirror's pixels, against the same view drawn with a map of many times the
texels. Densest : sparsest compares texels a steradian; the longest texel is its length over its width; cost is how
many times the texels of an even map it takes to resolve as much everywhere along every axis
(<code>reflet sampling</code>).</p>
{sections}
</html>
"""


def _figure(view: View, caption: str) -> str:
    return (
        f'<figure><img alt="{html.escape(view.title)}" src="{view.file}">'
        f"<figcaption>{html.escape(view.title)}, {caption}</figcaption></figure>"
    )


def _words(name: str) -> str:
    return {"latlong": "lat-long"}.get(name, name.replace("_", " "))


def _number(value: float) -> str:
    return f"{value:.1f}" if np.isfinite(value) else "∞"
