"""``reflet compare``."""

from pathlib import Path

import click

from reflet.cli.options import VARIANTS, asked_samples, pem_argument, samples_option, variant_option
from reflet.cli.progress import progress_bar


@click.command(short_help="Set a PEM beside ray tracing and older methods.")
@pem_argument
@click.option("--json", "json_path", type=click.Path(path_type=Path), metavar="FILE", help="Write the numbers here.")
@click.option("--figure", type=click.Path(path_type=Path), metavar="FILE", help="Write the figure here (.png).")
@click.option("--page", type=click.Path(path_type=Path), metavar="FILE", help="Write a page of it all here (.html).")
@click.option(
    "--images", type=click.Path(path_type=Path), metavar="DIR", help="Write the .exr behind each number here."
)
@samples_option("quick")
@click.option(
    "--spp", type=click.IntRange(1), default=256, show_default=True, help="Rays a pixel of the ray-traced reference."
)
@click.option("--rivals/--no-rivals", default=True, help="Infer and measure older methods too; the default.")
@variant_option
def compare(
    pem: Path,
    json_path: Path | None,
    figure: Path | None,
    page: Path | None,
    images: Path | None,
    samples: str,
    spp: int,
    rivals: bool,
    variant: str,
) -> None:
    """Ray-traces viewpoints of its own and measures what each method makes of them on the object's pixels.

    At the samples, halfway between them, 10° and 20° above, and all around: the PEM; static shells instead, with the
    object's own mesh traced and without; its distant layer alone, as played, of the joint set, and of static shells;
    the paper's layered PEM; single-layer PEMs of four geometries; a static environment map from the object's centre,
    the same projected on a box, and that as engines show it, prefiltered, by the split sum; and rough parts played as
    mirrors. Display PSNR, SSIM and FLIP, with error images in one figure.

    \b
    Examples:
      reflet compare teapot --figure compare.png
      reflet compare teapot --json compare.json --images pictures --samples 4
      reflet compare teapot --no-rivals
    """
    import json

    from reflet.errors import RefletError
    from reflet.files.atomic import atomic_write, check_writable
    from reflet.pem.container import open_pem
    from reflet.pipelines.compare import compare as compare_pem
    from reflet.report.figure import comparison_figure
    from reflet.report.page import result_page
    from reflet.report.table import comparison_table

    for written, suffix, what in ((figure, ".png", "figure"), (page, ".html", "page")):
        if written is not None and written.suffix.lower() != suffix:
            raise RefletError(f"A {what} is a {suffix}, not {written.name}.")
    with progress_bar() as progress:
        progress("read", 0, 1)
        opened = open_pem(pem)
        progress("read", 1, 1)
        for written in (json_path, figure, page, images and images / "sample.exr"):
            if written is not None:
                check_writable(written)
        comparison = compare_pem(
            opened,
            samples=asked_samples(samples),
            reference_spp=spp,
            variant=VARIANTS[variant],
            rivals=rivals,
            images=images,
            progress=progress,
        )
    click.echo(comparison_table(comparison))  # first: what cannot be written after all does not take it along
    if json_path:
        atomic_write(json_path, (json.dumps(comparison.as_json(), indent=1) + "\n").encode())
    if figure:
        atomic_write(figure, comparison_figure(comparison))
    if page:
        atomic_write(page, result_page(opened, comparison, name=str(pem)).encode())
