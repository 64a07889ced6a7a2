"""Tables for the terminal."""

from io import StringIO

import numpy as np
from rich import box
from rich.console import Console
from rich.table import Table

from reflet.pem.folder_facts import FolderFacts
from reflet.pem.pem import Layer, ParameterizedEnvironmentMap
from reflet.report.comparison import METHODS, PLACES, Comparison
from reflet.report.distant_choice import base_choice, distant_choice


def comparison_table(comparison: Comparison) -> str:
    """Display PSNR in dB of every method at every place."""
    places = [place for place in PLACES if any(result.where == place for result in comparison.results)]
    table = Table("display PSNR, dB", box=box.SIMPLE_HEAD)
    for place in places:
        table.add_column(PLACES[place], justify="right")
    for method in comparison.methods:
        values = (f"{comparison.result(place, method).psnr_display:.2f}" for place in places)
        table.add_row(METHODS[method], *values, style="bold" if method == comparison.played else None)
    return table_text(table)


def pem_table(pem: ParameterizedEnvironmentMap, files: FolderFacts | None = None) -> str:
    """What a PEM holds: its scene, viewpoints, layers, means over all samples of how inference went, files."""
    scene, orbit = pem.scene, pem.space.orbit
    facts = Table(box=None, show_header=False)
    facts.add_row("scene", f"{len(scene.parts)} parts, {scene.triangle_offsets[-1]:,} triangles")
    for item in scene.objects:
        names = ", ".join(scene.parts[part].name for part in item.parts)
        facts.add_row("reflective object", f"{item.name}: {names}")
    reflecting = np.concatenate(
        [pem.on_hull[scene.triangle_offsets[p] : scene.triangle_offsets[p + 1]] for o in scene.objects for p in o.parts]
    )
    facts.add_row("on the convex hull", f"{reflecting.mean():.1%} of the reflective triangles")
    for item, choice in zip(scene.objects, pem.statistics.get("distant", []), strict=False):
        facts.add_row("distant light", distant_choice(item.name, choice))
    for axis in pem.space.axes:
        reach = f", {axis.values[0]:g} to {axis.values[-1]:g}" if axis.values else ""
        around = "" if axis.period is None else f", closed after {axis.period:g}"
        facts.add_row("viewpoints", f"{len(axis.values)} along {axis.name}{reach}{around}")
    if pem.base:
        joint = pem.statistics.get("joint")
        fades = f"; viewpoints' own maps fade to it within {pem.fade_deg:g}°" if pem.space.sample_count else ""
        source = f"inferred from {joint['viewpoints']} viewpoints" if joint else "static, seen from the object's centre"
        if "base" in pem.statistics:
            source += f" ({base_choice(pem.statistics['base'])})"
        facts.add_row("from everywhere", source + fades)
    facts.add_row(
        "camera", f"elevation {orbit.elevation_deg:g}°, distance {orbit.distance:g} m, {orbit.fov_deg:g}° wide"
    )
    facts.add_row("inferred for", f"{pem.sample_count} samples a pixel, LOD bias {pem.lod_bias:g}")
    if pem.most_hits:
        facts.add_row("local light", f"traced through the mirrors' own meshes, up to {pem.most_hits} hits")
        if pem.surface is not None:
            count, texels = pem.surface.light.shape[:2]
            facts.add_row("of rough parts", f"from everywhere, at {count:,} sites of {texels} directions")
        if pem.companions:
            facts.add_row("met beside them", ", ".join(scene.parts[part].name for part in pem.companions))
    facts.add_row("parameterization", ", ".join(sorted({layer.parameterization.name for layer in pem.layers})))
    if files:
        facts.add_row("codec of maps", files.codec)
        for kind, size in {**files.sizes, "all files": sum(files.sizes.values())}.items():
            facts.add_row(kind, f"{size / 1e6:.3f} MB")
    table = Table("layer", "kind", "geometry", box=box.SIMPLE_HEAD)
    for heading in ("size", "iterations", "residual", "texels seen"):
        table.add_column(heading, justify="right")
    for number, layer in enumerate(pem.layers):
        table.add_row(layer.name, layer.kind, layer.geometry.kind, _size(layer), *_inference(pem, number))
    return table_text(facts) + "\n" + table_text(table)


def _inference(pem: ParameterizedEnvironmentMap, number: int) -> tuple[str, str, str]:
    """Means over the samples of what the solver says of one layer; dashes where nothing is known."""
    solves = [sample["layers"][number] for sample in pem.statistics.get("samples", []) if "layers" in sample]
    if not solves:
        return "–", "–", "–"
    iterations, residual, seen = (
        np.mean([solve[name] for solve in solves]) for name in ("iterations", "relative_residual", "seen_share")
    )
    return f"{iterations:.0f}", f"{residual:.3f}", f"{seen:.0%}"


def _size(layer: Layer) -> str:
    """Columns, rows and faces."""
    faces, rows, columns = layer.chain.level_shape(0)
    return f"{columns}×{rows}" + (f"×{faces}" if faces > 1 else "")


def table_text(table: Table) -> str:
    """The table in 100 columns, without colours."""
    console = Console(file=StringIO(), width=100)
    console.print(table)
    return "\n".join(line.rstrip() for line in console.file.getvalue().rstrip().splitlines())  # type: ignore[attr-defined]
