"""Data flows one way through the viewer's sources too."""

import re
from pathlib import Path

import pytest
from circles import circle

SOURCE = Path(__file__).parents[2] / "web" / "src"
ORDER = ["maths", "files", "scene", "panels", "gpu", "players", "page"]  # and reflet-viewer.ts, which opens the page
MODULES = sorted(SOURCE.rglob("*.ts"))
SPECIFIER = re.compile(r"""(?:\bfrom|\bimport)\s*\(?\s*["'](\.[^"']*)["']""")


def named(path: Path) -> tuple[str, ...]:
    return path.relative_to(SOURCE).with_suffix("").parts


def imported(path: Path) -> list[tuple[str, ...]]:
    """The modules that a file imports, types alone or not; those of packages and what is no module are left out."""
    paths = [Path(f"{(path.parent / specifier).resolve()}.ts") for specifier in SPECIFIER.findall(path.read_text())]
    return [named(found) for found in paths if found in MODULES]


def imports_between(level: int) -> dict[str, set[str]]:
    """What imports what, each module named by its first ``level`` parts: rooms, sub-rooms, modules."""
    found: dict[str, set[str]] = {}
    for path in MODULES:
        here = named(path)[:level]
        found.setdefault("/".join(here), set()).update(
            "/".join(there[:level]) for there in imported(path) if there[:level] != here
        )
    return found


def test_imports_are_seen() -> None:
    assert ("gpu", "device", "shaders") in imported(SOURCE / "gpu/device/picture-sum.ts")
    specifiers = SPECIFIER.findall(
        "import a from './a';\nexport { b } from \"../b\";\nimport './c'; await import('./d')"
    )
    assert specifiers == ["./a", "../b", "./c", "./d"]


@pytest.mark.parametrize("path", MODULES, ids=lambda p: "/".join(named(p)))
def test_rooms_import_only_rooms_above(path: Path) -> None:
    here = named(path)[0]
    if here == "reflet-viewer":
        return
    for there in imported(path):
        assert there[0] in ORDER, f"{path.name} imports the loose module {there[0]}"
        assert ORDER.index(there[0]) <= ORDER.index(here), f"{path.name} imports {'/'.join(there)}, of a room below"


@pytest.mark.parametrize("level", [1, 2, 3], ids=["rooms", "sub-rooms", "modules"])
def test_nothing_imports_in_a_circle(level: int) -> None:
    assert circle(imports_between(level)) == []


def test_every_module_has_its_place() -> None:
    assert {named(path)[0] for path in MODULES} == {*ORDER, "reflet-viewer"}


@pytest.mark.parametrize("folder", sorted({path.parent for path in MODULES}), ids=lambda p: str(p.relative_to(SOURCE)))
def test_folders_can_be_surveyed(folder: Path) -> None:
    assert len(list(folder.glob("*.ts"))) <= 15


def test_no_file_grows_past_its_reader() -> None:
    assert not {"/".join(named(p)): n for p in MODULES if (n := len(p.read_text().splitlines())) > 400}
