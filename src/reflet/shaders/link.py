"""Puts WGSL programs together: a line ``#import name`` stands for the text of ``name.wgsl``, each file once."""

import re
from functools import cache
from importlib.resources import files

_IMPORT = re.compile(r"^#import ([a-z_]+)\n", re.MULTILINE)


@cache
def link(program: str) -> str:
    """The complete WGSL text of a program file, such as ``"picture.wgsl"``."""
    return link_text(_read(program))


def link_text(text: str) -> str:
    """WGSL text with all its imports in place, whatever they import first; for tests and benchmarks of single files."""
    return _expand(text, set())


def _expand(text: str, included: set[str]) -> str:
    def insert(line: re.Match[str]) -> str:
        name = line[1]
        if name in included:
            return ""
        included.add(name)
        return _expand(_read(f"{name}.wgsl"), included) + "\n"

    return _IMPORT.sub(insert, text)


def _read(name: str) -> str:
    return files(__package__).joinpath(name).read_text(encoding="utf-8")
