"""The linker of WGSL files."""

import re
from importlib.resources import files

import pytest

from reflet.shaders.link import link, link_text

PROGRAMS = (
    "picture", "probe", "backdrop", "accumulate", "display", "map_view", "mipmap",
    "material_picture", "within", "paraboloid_two_pass", "matte", "warp", "map_levels",
)  # fmt: skip


@pytest.mark.parametrize("program", PROGRAMS)
def test_programs_are_complete_and_name_nothing_twice(program: str) -> None:
    text = link(f"{program}.wgsl")
    assert "#import" not in text
    names = re.findall(r"^(?:fn|struct|const|override) (\w+)", text, re.MULTILINE)
    assert len(names) == len(set(names))


def test_a_file_comes_in_once() -> None:
    assert link_text("#import geometry\n#import geometry\n").count("fn lookup_direction") == 1


def test_the_readme_names_every_file() -> None:
    folder = files("reflet.shaders")
    readme = folder.joinpath("README.md").read_text(encoding="utf-8")
    for entry in folder.iterdir():
        if entry.name.endswith(".wgsl"):
            assert re.search(rf"\b{entry.name.removesuffix('.wgsl')}\b", readme), entry.name
