"""Every command, option and make target that a sentence or a page names is there."""

import ast
import re
import shlex
from collections.abc import Iterator
from pathlib import Path

import click
import pytest

from reflet.cli.main import commands

ROOT = Path(__file__).parents[2]
SOURCES = sorted((ROOT / "src/reflet").rglob("*.py"))
PAGES = [ROOT / "README.md", ROOT / "CONVENTIONS.md", ROOT / "FORMAT.md", *sorted((ROOT / "docs").glob("*.md"))]
VERBS = commands.commands
OPTIONS = {
    name: {option for parameter in verb.params for option in (*parameter.opts, *parameter.secondary_opts)} | {"--help"}
    for name, verb in VERBS.items()
}
EVERY_OPTION = set.union(*OPTIONS.values())
PROSE = {"does", "reads", "cannot", "viewer"}  # what may follow the name where no command is meant


def words_of(node: ast.expr) -> str:
    """The text of an expression, with blanks where it depends on what happens."""
    if isinstance(node, ast.Constant):
        return node.value if isinstance(node.value, str) else " "
    if isinstance(node, ast.JoinedStr):
        return "".join(words_of(part) for part in node.values)
    if isinstance(node, ast.BinOp):
        return words_of(node.left) + words_of(node.right)
    if isinstance(node, ast.IfExp):
        return words_of(node.body) + " " + words_of(node.orelse)
    return " "


def sentences() -> Iterator[tuple[str, str]]:
    """Where and what: all constant text of a module but its docstrings."""
    for path in SOURCES:
        tree = ast.parse(path.read_text())
        docstrings = {
            id(node.body[0].value)
            for node in ast.walk(tree)
            if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef)
            and node.body
            and isinstance(node.body[0], ast.Expr)
        }
        inside = {id(part) for node in ast.walk(tree) if isinstance(node, ast.JoinedStr) for part in node.values}
        for node in ast.walk(tree):
            is_text = isinstance(node, ast.JoinedStr) or (
                isinstance(node, ast.Constant) and isinstance(node.value, str)
            )
            if is_text and id(node) not in docstrings | inside:
                yield f"{path.relative_to(ROOT)}:{node.lineno}", words_of(node)


def faults(text: str) -> list[str]:
    """Verbs and options in a text that no command has."""
    found = []
    for verb, rest in re.findall(r"\breflet ([a-z]+)\b(.*?)(?=[;:,.](?:\s|$)|[()`\n]|\breflet |$)", text):
        if verb in PROSE:
            continue
        if verb not in VERBS:
            found.append(f"reflet {verb}")
            continue
        found += [
            f"reflet {verb} … {option}"
            for option in re.findall(r"(?<![\w-])--?[a-z][a-z-]*", rest)
            if option not in OPTIONS[verb] and option not in ("-o",)
        ]
    return found


def test_verbs_and_their_options_in_sentences_are_there() -> None:
    said = {place: text for place, text in sentences() if "reflet " in text}
    assert len(said) > 20
    assert {place: faults(text) for place, text in said.items() if faults(text)} == {}


def test_options_in_sentences_are_options_of_some_verb() -> None:
    unknown = {}
    for place, text in sentences():
        if place.startswith("src/reflet/cli/") or "npx " in text or "apt" in text or " " not in text:
            continue  # declarations, and other programs' commands
        options = set(re.findall(r"(?<![\w-])--[a-z][a-z-]+", text)) - EVERY_OPTION
        if options:
            unknown[place] = options
    assert unknown == {}


def test_make_targets_in_sentences_and_pages_are_there() -> None:
    targets = set(re.findall(r"^([a-z][\w-]*):", (ROOT / "Makefile").read_text(), re.M))
    named = [
        (place, name) for place, text in sentences() for name in re.findall(r"(?:run: |`)make ([a-z][\w-]*)", text)
    ]
    named += [
        (page.name, name) for page in PAGES for name in re.findall(r"(?:^|`)make ([a-z][\w-]*)", page.read_text(), re.M)
    ]
    assert named
    assert [each for each in named if each[1] not in targets] == []


def lines_of_blocks(page: Path) -> list[str]:
    """Lines of a page's fenced blocks, without their comments."""
    text = re.sub(r"\\\n\s*", " ", page.read_text())
    blocks = re.findall(r"^```.*?\n(.*?)^```", text, re.M | re.S)
    return [line.split("  #")[0] for block in blocks for line in block.splitlines()]


def code_in(page: Path) -> list[str]:
    """These, and what stands between backticks."""
    prose = re.sub(r"^```.*?^```", "", page.read_text(), flags=re.M | re.S)
    return lines_of_blocks(page) + re.findall(r"`([^`\n]+)`", prose)


@pytest.mark.parametrize("page", PAGES, ids=lambda path: path.name)
def test_commands_in_pages_are_there(page: Path) -> None:
    assert [fault for line in code_in(page) for fault in faults(line)] == []


@pytest.mark.parametrize("verb", list(VERBS))
def test_examples_in_help_parse(verb: str, capsys: pytest.CaptureFixture[str]) -> None:
    examples = re.findall(rf"^\s+reflet ({verb} .*?)(?:\s{{3,}}.*)?$", VERBS[verb].help or "", re.M)
    assert examples
    for example in examples:
        name, *arguments = shlex.split(example)
        try:
            VERBS[name].make_context(name, arguments)
        except click.ClickException as error:
            pytest.fail(f"reflet {example}: {error.format_message()}")


def test_a_false_name_would_be_found() -> None:
    assert faults("mend it with: reflet polish") == ["reflet polish"]
    assert faults("reflet convert --polish mends it") == ["reflet convert … --polish"]
    assert faults("reflet convert a.hdr b.hdr --polish, which helps") == ["reflet convert … --polish"]
    assert faults("reflet convert --repair mends it") == []


@pytest.mark.parametrize("page", PAGES, ids=lambda path: path.name)
def test_commands_in_pages_parse(page: Path) -> None:
    for line in lines_of_blocks(page):
        if not re.match(r"\s*(\S*/)?reflet [a-z]+ [^…\[]*$", line):
            continue
        _, verb, *arguments = shlex.split(line, comments=True)
        try:
            VERBS[verb].make_context(verb, arguments)
        except click.ClickException as error:
            pytest.fail(f"{line}: {error.format_message()}")
