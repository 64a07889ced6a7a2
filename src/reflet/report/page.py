"""A page that shows a bake's result, in one file that needs nothing else."""

import base64
import html
import shlex
from io import BytesIO
from pathlib import PurePath

import numpy as np
from jaxtyping import UInt8
from PIL import Image

from reflet.envmap.env_map import EnvMap
from reflet.pem.pem import Layer, ParameterizedEnvironmentMap
from reflet.report.comparison import METHODS, PLACES, Comparison
from reflet.report.figure import comparison_figure
from reflet.report.maps_figure import env_map_sheet
from reflet.report.measures import picture_srgb
from reflet.report.table import pem_table

PAGE_STYLE = """
:root { color-scheme: light; --ink: #1d1d1f; --soft: #6e6e73; --line: #e3e3e6; }
body { margin: 0 auto; padding: 3rem 1.25rem 5rem; max-width: 62rem; color: var(--ink); background: #fff;
       font: 16px/1.55 system-ui, sans-serif; }
h1 { font-size: 2.1rem; line-height: 1.15; margin: 0 0 .4rem; letter-spacing: -.02em; }
h2 { font-size: 1.25rem; margin: 3rem 0 .6rem; }
p { max-width: 46rem; } .soft, figcaption { color: var(--soft); font-size: .9rem; }
figure { margin: 1.2rem 0; } img { display: block; max-width: 100%; height: auto; }
.pair { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(24rem, 100%), 1fr)); gap: 1rem; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; width: 100%; }
th, td { padding: .35rem .6rem; border-bottom: 1px solid var(--line); text-align: right; white-space: nowrap; }
th:first-child, td:first-child { text-align: left; } tr.best td { font-weight: 650; }
small { color: var(--soft); font-weight: 400; }
pre { background: #f5f5f7; border-radius: .6rem; padding: .9rem 1.1rem; overflow-x: auto; font-size: .82rem;
      line-height: 1.4; }
"""


_WHICH = {
    True: "All layers of the first viewpoint. Every mip level is inferred on its own, so none is merely a filtered "
    "copy of the finer one. What no sample saw stays close to the static map.",
    False: "The maps of distant light, which serve every viewpoint: what stands near has an alpha of its own.",
}


def result_page(pem: ParameterizedEnvironmentMap, comparison: Comparison, *, name: str) -> str:
    """A self-contained HTML page: pictures, comparison, numbers, the inferred maps, statistics, and what to do next.

    ``name`` is the PEM's folder as the reader will type it.
    """
    title = html.escape(PurePath(name).name)
    words = html.escape(shlex.quote(name), quote=False)
    traced = _image(picture_srgb(comparison.reference_picture), "Ray traced")
    baked = _image(picture_srgb(comparison.played_picture), "Played back from the maps")
    sheets = {"distant": "", "local": ""}
    own = pem.maps[0] if len(pem.maps) else pem.base
    shown = pem.layers if len(pem.maps) else [pem.layers[index] for index in pem.distant_layers]
    for layer, env_map in zip(shown, own, strict=True):
        sheets[layer.kind] += _map_figure(layer, env_map)
    return f"""<!doctype html>
<html lang="en">
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title}: parameterized environment maps</title>
<style>{PAGE_STYLE}</style>
<h1>{title}</h1>
<p class="soft">Ray-traced reflections, baked into parameterized environment maps by reflet.</p>
<div class="pair">
<figure>{traced}<figcaption>Ray traced</figcaption></figure>
<figure>{baked}<figcaption>Played back from the maps</figcaption></figure>
</div>
<h2>Look at it</h2>
<pre>reflet view {words}
reflet render {words} -o view.png</pre>
<h2>Beside ray tracing and older methods</h2>
<p>Each picture with its FLIP error below, on the object's pixels. A static map misses the object's reflection of
itself; a single layer shows it, but moves it wrongly between viewpoints.</p>
<figure class="scroll"><img alt="Comparison of methods" src="{_data_uri(comparison_figure(comparison))}"></figure>
<div class="scroll">{_table(comparison)}</div>
<p class="soft">{_circumstances(comparison)}</p>
<h2>The inferred maps</h2>
<p>{_WHICH[bool(len(pem.maps))]}</p>
{sheets["distant"]}
<div class="pair">{sheets["local"]}</div>
<h2>Statistics</h2>
<pre>{html.escape(pem_table(pem))}</pre>
</html>
"""


def _table(comparison: Comparison) -> str:
    """Every number of the comparison: display PSNR, SSIM and FLIP, a row for each method."""
    places = [place for place in PLACES if any(result.where == place for result in comparison.results)]
    heads = "".join(f"<th>{PLACES[place]}</th>" for place in places)
    rows = "".join(
        f'<tr class="{"best" if method == comparison.played else ""}"><td>{METHODS[method]}</td>'
        + "".join(
            f"<td>{r.psnr_display:.2f} dB<br><small>{r.ssim:.3f} · {r.flip:.3f}</small></td>"
            for r in (comparison.result(place, method) for place in places)
        )
        + "</tr>"
        for method in comparison.methods
    )
    return f"<table><tr><th>display PSNR<br><small>SSIM · FLIP</small></th>{heads}</tr>{rows}</table>"


def _circumstances(comparison: Comparison) -> str:
    """The comparison's context in one line."""
    facts = []
    for name, value in comparison.context.items():
        words = ", ".join(value) if isinstance(value, list) else f"{value:.4g}" if isinstance(value, float) else value
        facts.append(f"{name.replace('_', ' ')}: {words}")
    return html.escape(" · ".join(facts))


def _map_figure(layer: Layer, env_map: EnvMap) -> str:
    """One layer's map laid flat, with its caption."""
    name = html.escape(layer.name)
    geometry = layer.geometry.kind.replace("_", " ")
    alpha = "; below, its alpha" if layer.channels == 4 else ""
    return (
        f"<figure>{_image(env_map_sheet(env_map), f'{layer.name}: all faces and mip levels')}"
        f"<figcaption>{name}: {geometry}, {layer.size}² texels a face{alpha}</figcaption></figure>\n"
    )


def _image(pixels: UInt8[np.ndarray, "height width 3"], alt: str) -> str:
    buffer = BytesIO()
    Image.fromarray(pixels).save(buffer, format="PNG", optimize=True)
    return f'<img alt="{html.escape(alt)}" src="{_data_uri(buffer.getvalue())}">'


def _data_uri(png: bytes) -> str:
    return "data:image/png;base64," + base64.b64encode(png).decode()
