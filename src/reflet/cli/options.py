"""Values and options that several verbs share."""

from pathlib import Path
from typing import Any

import click

from reflet.envmap.parameterizations import PARAMETERIZATIONS
from reflet.files.cube_layouts import LAYOUTS

VARIANTS = {"llvm": "llvm_ad_rgb", "cuda": "cuda_ad_rgb"}  # Mitsuba's names of what ours mean

pem_argument = click.argument("pem", metavar="PEM", type=click.Path(path_type=Path))
variant_option = click.option(
    "--variant",
    type=click.Choice(list(VARIANTS)),
    default="llvm",
    show_default=True,
    help="Trace on the CPU (llvm) or on an NVIDIA GPU (cuda).",
)
samples_option = click.option(
    "--samples",
    type=click.Choice(["4", "16"]),
    default=None,
    help="Samples a pixel; by default those that the maps were inferred for.",
)
PARAMETERIZATION = click.Choice(list(PARAMETERIZATIONS))
from_option = click.option(
    "--from", "source_is", type=PARAMETERIZATION, help="What the file holds, where it does not tell by itself."
)
layout_option = click.option(
    "--layout",
    type=click.Choice([*LAYOUTS, "openexr"]),
    help="How the faces of a cube lie in a picture; openexr for .exr files as OpenEXR's own tools have them.",
)
mips_option = click.option(
    "--mips/--no-mips", default=None, help="Store all mip levels; by default in .ktx2, .ktx and .dds."
)
texel_format_option = click.option(
    "--texel-format",
    type=click.Choice(["half", "float", "rgb9e5", "r11g11b10f"]),
    help="How texels are stored; by default half in textures, float in .exr.",
)
zstd_option = click.option("--zstd", is_flag=True, help="Pack a .ktx2 by Zstandard.")


class Vector(click.ParamType):
    """Three numbers with commas between, such as 0,0.15,0."""

    name = "X,Y,Z"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[float, float, float]:
        """The three numbers, or click's usage error."""
        if isinstance(value, tuple):
            return value
        try:
            x, y, z = (float(number) for number in value.split(","))
        except ValueError:
            self.fail(f"three numbers with commas between are expected, such as 0,0.15,0, not {value!r}", param, ctx)
        return x, y, z
