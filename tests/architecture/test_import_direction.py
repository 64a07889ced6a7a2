"""Data flows one way: a room imports only the rooms above it, and heavy libraries stay in the rooms that own them."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest
from circles import circle

ROOT = Path(__file__).parents[2]
SOURCE = ROOT / "src" / "reflet"
ROOMS = [
    "envmap",
    "reflectance",
    "npr",
    "files",
    "scene",
    "trace",
    "infer",
    "pem",
    "shaders",
    "render",
    "view",
    "report",
]
# The pipelines know the order of all rooms, the command line knows the pipelines.
ORDER = [*ROOMS, "pipelines", "cli"]
OPEN_TO_ALL = {"errors", "progress"}
OWNERS = {"mitsuba": "trace", "drjit": "trace", "wgpu": "render"}
MODULES = sorted(path for path in SOURCE.rglob("*.py"))


def room_of(path: Path) -> str:
    return path.relative_to(SOURCE).with_suffix("").parts[0]


def imported_names(path: Path) -> list[str]:
    names: list[str] = []
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: imports are absolute"
            names.append(node.module or "")
    return names


@pytest.mark.parametrize("path", MODULES, ids=lambda p: str(p.relative_to(SOURCE)))
def test_rooms_import_only_rooms_above(path: Path) -> None:
    here = room_of(path)
    for name in imported_names(path):
        parts = name.split(".")
        if parts[0] in OWNERS:
            assert here == OWNERS[parts[0]], f"{path.name} imports {name}; only {OWNERS[parts[0]]}/ may"
        if parts[0] != "reflet" or len(parts) == 1:
            continue
        there = parts[1]
        if there in OPEN_TO_ALL or there == here:
            continue
        if here in ORDER:  # all but reflet/__init__.py, which names what is public
            assert ORDER.index(there) < ORDER.index(here), f"{path.name} imports {name}, a room below"


def imports_between(level: int) -> dict[str, set[str]]:
    """What imports what, each module named by its first ``level`` parts below `reflet`: rooms, sub-rooms, modules."""
    modules = {".".join(("reflet", *path.relative_to(SOURCE).with_suffix("").parts)) for path in MODULES}
    found: dict[str, set[str]] = {}
    for path in MODULES:
        here = path.relative_to(SOURCE).with_suffix("").parts
        for name in imported_names(path):
            there = tuple(name.split(".")[1:]) if name in modules else ()
            if there and there[:level] != here[:level]:
                found.setdefault(".".join(here[:level]), set()).add(".".join(there[:level]))
    return found


@pytest.mark.parametrize("level", [1, 2, 3], ids=["rooms", "sub-rooms", "modules"])
def test_nothing_imports_in_a_circle(level: int) -> None:
    """Not even where a module is imported only when a function is called; loose modules count like sub-rooms."""
    assert circle(imports_between(level)) == []


@pytest.mark.parametrize("folder", sorted({path.parent for path in MODULES}), ids=lambda p: str(p.relative_to(SOURCE)))
def test_folders_can_be_surveyed(folder: Path) -> None:
    """About fifteen files; beyond, a room is divided into sub-rooms."""
    names = [path.name for path in folder.iterdir() if path.suffix == ".py" and path.name != "__init__.py"]
    assert len(names) <= 18, names


def test_every_module_has_its_place() -> None:
    known = {*ORDER, *OPEN_TO_ALL, "__init__"}
    assert {room_of(path) for path in MODULES} <= known


@pytest.mark.parametrize(
    "path", [p for p in SOURCE.rglob("__init__.py") if p.parent != SOURCE], ids=lambda p: p.parent.name
)
def test_package_inits_stay_empty(path: Path) -> None:
    assert path.read_text() == ""


def test_no_file_grows_past_its_reader() -> None:
    long = {str(p.relative_to(ROOT)): n for p in MODULES if (n := len(p.read_text().splitlines())) > 400}
    assert not long


def test_all_rooms_but_their_owners_load_without_tracer_and_graphics_system() -> None:
    """Each module outside trace/, render/ and what needs them is imported in a process where both are blocked."""
    light = ["envmap", "reflectance", "npr", "files", "scene", "infer", "pem", "shaders", "report"]
    modules = [
        ".".join(path.relative_to(SOURCE.parent).with_suffix("").parts)
        for path in MODULES
        if room_of(path) in light and path.name != "__init__.py"
    ] + ["reflet", "reflet.trace.layers"]
    code = (
        "import sys\n"
        "for name in ('mitsuba', 'drjit', 'wgpu'): sys.modules[name] = None\n"
        f"import importlib\nfor name in {modules!r}: importlib.import_module(name)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_public_names_exist_and_are_documented() -> None:
    import reflet

    for name in reflet.__all__:
        assert (getattr(reflet, name).__doc__ or "").strip(), name


def test_the_project_speaks_of_the_product_alone() -> None:
    """No registry host and no absolute path of a build machine in any tracked text file."""
    forbidden = ["registry." + "npmjs", "pypi." + "org", "files.python" + "hosted", "/wo" + "rk/"]
    tracked = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=False).stdout
    for name in filter(None, tracked.split("\0")):
        path = ROOT / name
        if path.suffix in {".png", ".exr", ".jpg"} or not path.is_file():
            continue
        text = path.read_text(errors="replace")
        for word in forbidden:
            assert word not in text, f"{name} names {word}"
