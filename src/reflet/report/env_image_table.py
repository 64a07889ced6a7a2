"""What an environment map file holds, as a table for the terminal."""

from collections.abc import Iterable, Sequence

from rich.table import Table

from reflet.envmap.env_image import EnvImage
from reflet.envmap.facts import BRIGHTEST_SHARE, Vec3, azimuth_and_elevation, facts
from reflet.files.file_facts import FileFacts
from reflet.report.table import table_text

_CHANNELS = {1: "grey", 2: "grey and alpha", 3: "RGB", 4: "RGB and alpha"}


def env_image_table(file: FileFacts, levels: Sequence[EnvImage]) -> str:
    """Kind, size, range and energy of the finest of a file's mip levels, with where its light comes from."""
    finest = levels[0]
    faces, rows, columns, channels = finest.texels.shape
    found = facts(finest)
    table = Table(box=None, show_header=False)
    table.add_row("file", ", ".join(word for word in (file.form, file.texel_format, file.supercompression) if word))
    layout = f", {file.layout}" if file.layout not in (None, "single", "cube", "layers") else ""
    table.add_row("kind", finest.parameterization.name + layout)
    size = f"{columns}×{rows}" + (f", {faces} faces" if faces > 1 else "")
    table.add_row("size", f"{size}, {_CHANNELS[channels]}" + (f", {len(levels)} mip levels" if len(levels) > 1 else ""))
    table.add_row("radiance", f"{found.least:.4g} to {found.greatest:.4g}")
    table.add_row("mean radiance", _numbers(found.mean))
    table.add_row("total over all directions", f"{_numbers(found.power)} (∫ L dω, radiance·sr)")
    table.add_row(f"in the brightest {BRIGHTEST_SHARE:.2%}", f"{found.flux_of_brightest:.1%} of the luminance")
    table.add_row("brightest texel", _numbers(found.brightest_radiance))
    table.add_row("  seen", _place(found.brightest))
    table.add_row("light comes from", f"{_place(found.dominant)}, {found.directedness:.0%} directed")
    return table_text(table)


def _numbers(values: Iterable[float]) -> str:
    return " ".join(f"{value:.4g}" for value in values)


def _place(direction: Vec3) -> str:
    azimuth, elevation = azimuth_and_elevation(direction)
    x, y, z = direction
    return f"at azimuth {azimuth:.1f}°, elevation {elevation:.1f}° ({x:.3f}, {y:.3f}, {z:.3f})"
