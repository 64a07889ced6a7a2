"""Values and options that several verbs share."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from reflet.envmap.parameterizations.by_name import PARAMETERIZATIONS
from reflet.envmap.rotations import SOURCE_FROM_UPRIGHT
from reflet.files.pictures.cube_layouts import LAYOUTS
from reflet.pem.layout import CODECS
from reflet.scene.views.sample_pattern import NAMED_SAMPLES, SAMPLE_COUNTS, Adaptive

VARIANTS = {"llvm": "llvm_ad_rgb", "cuda": "cuda_ad_rgb"}  # Mitsuba's names of what ours mean

pem_argument = click.argument("pem", metavar="PEM", type=click.Path(path_type=Path))
variant_option = click.option(
    "--variant",
    type=click.Choice(list(VARIANTS)),
    default="llvm",
    show_default=True,
    help="Trace on the CPU (llvm) or on an NVIDIA GPU (cuda).",
)
codec_option = click.option(
    "--codec",
    type=click.Choice(CODECS),
    default="av1",
    show_default=True,
    help="How maps and environment are stored: coded small, or none: half floats in KTX2, and floats.",
)
_SAMPLES: dict[str, int | Adaptive] = {**NAMED_SAMPLES, **{str(n): n for n in SAMPLE_COUNTS}}


def samples_option(default: str) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Samples a pixel, as `asked_samples` takes them."""
    return click.option(
        "--samples",
        type=click.Choice(list(_SAMPLES)),
        default=default,
        show_default=True,
        help="Samples a pixel; adaptive: 16, and 256 where those disagree, as the viewer at rest; quick: 16, and 64; "
        "motion: 4, and 16.",
    )


PARAMETERIZATION = click.Choice(list(PARAMETERIZATIONS.values()))
from_option = click.option(
    "--from", "source_is", type=PARAMETERIZATION, help="What the file holds, where it does not tell by itself."
)
layer_option = click.option(
    "--layer", metavar="NAME", help="Which layer of an .exr to read, such as ViewLayer.Combined."
)
up_option = click.option(
    "--up",
    type=click.Choice(list(SOURCE_FROM_UPRIGHT)),
    default="y",
    show_default=True,
    help="The axis that points up in the file; z turns +z to +y and +y to -z.",
)
layout_option = click.option(
    "--layout",
    type=click.Choice([*LAYOUTS, "openexr"]),
    help="How the faces of a cube lie in a picture; openexr for .exr files as OpenEXR's own tools have them.",
)
_MAP_FILES = (
    layout_option,
    click.option("--mips/--no-mips", default=None, help="Store all mip levels; by default in .ktx2, .ktx and .dds."),
    click.option(
        "--texel-format",
        type=click.Choice(["half", "float", "rgb9e5", "r11g11b10f"]),
        help="How texels are stored; by default half in textures, float in .exr.",
    ),
    click.option("--zstd", is_flag=True, help="Pack a .ktx2 by Zstandard."),
    from_option,
)


def asked_samples(samples: str) -> int | Adaptive:
    """What `samples_option` chose, as renderers take it."""
    return _SAMPLES[samples]


def map_file_options(verb: Callable[..., None]) -> Callable[..., None]:
    """Options of a verb that reads a map and writes another: ``layout mips texel_format zstd`` and ``source_is``."""
    for option in reversed(_MAP_FILES):  # as decorators above each other
        verb = option(verb)
    return verb


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
