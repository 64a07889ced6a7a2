"""docs/papers.md: every function that it names is there, and every number of the papers has its row."""

import ast
import re
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs/papers.md").read_text()
COLUMNS = 3
# Numbered equations and figures of each paper, in the page's order.
NUMBERED = {"Hakura": (0, 7), "Heidrich, Seidel 1998": (7, 8), "Heidrich 2000": (20, 15), "Cabral": (0, 5)}


@cache
def names_in(path: Path) -> frozenset[str]:
    """Functions, classes, constants and ``Class.member`` of a Python module; functions, structs and constants of a
    shader; exports of a TypeScript module."""
    text = path.read_text()
    if path.suffix == ".wgsl":
        return frozenset(re.findall(r"^(?:fn|struct|const|override) (\w+)", text, re.M))
    if path.suffix == ".ts":
        kinds = "function|class|const|interface|type"
        return frozenset(re.findall(rf"^export (?:async |abstract )*(?:{kinds}) (\w+)", text, re.M))
    return frozenset(defined(ast.parse(text).body, ""))


def defined(body: list[ast.stmt], before: str) -> list[str]:
    names: list[str] = []
    for node in body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            names.append(before + node.name)
        if isinstance(node, ast.ClassDef):
            names += defined(node.body, f"{node.name}.")
        if isinstance(node, ast.Assign | ast.AnnAssign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            names += [before + target.id for target in targets if isinstance(target, ast.Name)]
    return names


def named(text: str) -> list[tuple[str, str]]:
    """Path and name wherever a text says ``path::name``."""
    return re.findall(r"`([\w./-]+\.\w+)::([\w.]+)`", text)


def is_there(path: str, name: str) -> bool:
    places = (ROOT / "src/reflet" / path, ROOT / path)
    return any(place.is_file() and name in names_in(place) for place in places)


def rows(section: str) -> list[list[str]]:
    lines = [line for line in section.splitlines() if line.startswith("| ")]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines if not line.startswith("| where ")]


SECTIONS = dict(zip(NUMBERED, PAGE.split("\n## ")[1:], strict=True))


def test_every_function_that_the_page_names_is_there() -> None:
    assert PAGE.count("::") == len(named(PAGE)) > 150
    assert [f"{path}::{name}" for path, name in named(PAGE) if not is_there(path, name)] == []


@pytest.mark.parametrize(
    ("path", "name"),
    [
        ("infer/solve.py", "solved"),
        ("infer/solver.py", "solve"),
        ("envmap/shapes.py", "Box.polish"),
        ("shaders/pem.wgsl", "incident"),
        ("web/src/gpu/playback/resident-maps.ts", "Resident"),
    ],
)
def test_a_false_name_would_be_found(path: str, name: str) -> None:
    assert not is_there(path, name)


def test_every_row_says_where_it_is_or_that_it_is_not() -> None:
    for title, section in SECTIONS.items():
        assert title in section.splitlines()[0]
        for row in rows(section):
            assert len(row) == COLUMNS, row
            where = row[-1]
            assert named(where) or where.startswith(("not built", "nothing to build")), row


@pytest.mark.parametrize("paper", NUMBERED)
def test_every_numbered_equation_and_figure_has_a_row(paper: str) -> None:
    places = " ; ".join(row[0] for row in rows(SECTIONS[paper]))
    equations, figures = NUMBERED[paper]
    assert {int(number) for number in re.findall(r"\beq\. (\d+)", places)} == set(range(1, equations + 1))
    assert {int(number) for number in re.findall(r"\bFigure (\d+)", places)} == set(range(1, figures + 1))
