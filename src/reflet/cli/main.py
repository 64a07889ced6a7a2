"""The command line: `reflet VERB`. Turns errors into sentences and exit statuses."""

import os
import shlex
import sys
import tempfile
import warnings
from typing import Any

import click

from reflet import __version__
from reflet.cli.bake import bake
from reflet.cli.compare import compare
from reflet.cli.convert import convert
from reflet.cli.encode import encode
from reflet.cli.info import info
from reflet.cli.interruption import interrupted
from reflet.cli.join import join
from reflet.cli.prefilter import prefilter
from reflet.cli.render import render
from reflet.cli.sampling import sampling
from reflet.cli.shade import shade
from reflet.cli.sketch import sketch
from reflet.cli.verify import verify
from reflet.cli.view import view
from reflet.errors import RefletError, RefletWarning
from reflet.files.atomic import REASONS


@click.group(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.version_option(__version__, prog_name="reflet")
def commands() -> None:
    """Bakes ray-traced reflections into parameterized environment maps (PEMs) and plays them back in real time.

    \b
    Start here:
      reflet bake teapot-room --views 3 --out teapot   bake the built-in scene into a folder
      reflet view teapot                               look at it in the browser
      reflet render teapot --azimuth 61 -o view.png    draw one view without a window
      reflet compare teapot --figure compare.png       set it beside ray tracing and older methods

    Environment maps of every kind:

    \b
      reflet info studio.hdr                           what it holds, with a picture in the terminal
      reflet convert studio.hdr studio.ktx2 --to cube  from any parameterization and format to any other
      reflet join front.jpg back.jpg -o room.exr       two fisheye or mirror ball pictures into one map
      reflet sampling                                  what each parameterization spends its texels on

    \b
    Materials:
      reflet prefilter studio.hdr --engine gltf -o out               diffuse, GGX and sheen maps for engines
      reflet shade teapot studio.hdr --material phong:50 -o pot.png  a mesh in an environment
      reflet view teapot studio.hdr                                  the same live, in the browser
      reflet sketch gooch+silhouette -o map.ktx2                     a drawn map, for non-photorealistic pictures

    `reflet VERB --help` explains each verb with examples.
    """


for verb in (bake, render, compare, verify, view, info, encode, convert, join, prefilter, sampling, shade, sketch):
    commands.add_command(verb)


def main(arguments: list[str] | None = None) -> None:
    """Runs one command and ends the process: status 0, 2 for anything the user can put right, 130 after Ctrl-C."""
    arguments = sys.argv[1:] if arguments is None else arguments
    # Where no desktop session set it, graphics drivers complain on stderr that it is missing.
    os.environ.setdefault("XDG_RUNTIME_DIR", tempfile.gettempdir())
    with warnings.catch_warnings():
        warnings.simplefilter("always", RefletWarning)
        warnings.showwarning = _show_warning
        sys.exit(_run(arguments))


def _run(arguments: list[str]) -> int:
    """The exit status of one command, after its error is said."""
    try:
        return int(commands.main(arguments, prog_name="reflet", standalone_mode=False) or 0)
    except (Exception, KeyboardInterrupt) as error:
        if isinstance(error, click.Abort) or interrupted(error):
            click.echo(_stopped(arguments), err=True)
            return 130
        if isinstance(error, click.exceptions.NoArgsIsHelpError):
            error.show()
        else:
            click.echo(f"reflet: {_sentence(error)}", err=True)
        return 2


def _sentence(error: BaseException) -> str:
    """What the user can put right; raises the error again where that is nothing."""
    if isinstance(error, RefletError):
        return str(error)
    if isinstance(error, click.ClickException):
        context = getattr(error, "ctx", None)
        command = context.command_path if context else "reflet"
        message = error.format_message()
        return f"{message}{'' if message.endswith(('.', '?')) else '.'} Try {command} --help."
    if isinstance(error, OSError) and error.errno in REASONS:  # of no file that was asked for
        place = error.filename or "What is printed, compiled functions (NUMBA_CACHE_DIR) or temporary files (TMPDIR)"
        return f"{place} cannot be written: {REASONS[error.errno]}."
    if isinstance(error, MemoryError):
        return "There is not enough memory; choose a smaller size."
    raise error


def _stopped(arguments: list[str]) -> str:
    """What to say after Ctrl-C: a bake goes on where it was stopped."""
    if arguments[:1] != ["bake"]:
        return "Stopped."
    again = arguments if "--resume" in arguments else [*arguments, "--resume"]
    return f"Stopped; go on with: {shlex.join(['reflet', *again])}"


def _show_warning(message: Any, category: type[Warning], *_: Any, **__: Any) -> None:
    """Warnings of our own take one line; those of libraries are not for the user."""
    if issubclass(category, RefletWarning):
        click.echo(f"Warning: {message}", err=True)
