"""Shapes and types of every annotated function are checked while tests run, and only then.

Workers take whole files: those that take minutes come first, so that none is left alone with one at the end, and those
in a browser beside those that bake, so that no two compile the same functions at the same time (`make test` lets this
order be).

What hypothesis tries is the same on every run, however slow the machine. Processes that tests start hear Ctrl-C: a
shell that runs the tests in its background has it ignored, and they would inherit that.
"""

import signal
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings
from jaxtyping import install_import_hook

settings.register_profile(
    "reflet", derandomize=True, deadline=None, suppress_health_check=[HealthCheck.too_slow], print_blob=True
)
settings.load_profile("reflet")

signal.signal(signal.SIGINT, signal.default_int_handler)

TESTS = Path(__file__).parent
SOURCE = TESTS.parent / "src"
FIRST = [
    TESTS / place
    for place in ("view/test_kinds.py", "cli/test_end_to_end.py", "view/test_viewer.py", "view/test_embedding.py",
                  "pipelines", "trace", "render", "cli")
]  # fmt: skip


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    def place(item: pytest.Item) -> int:
        return next((k for k, path in enumerate(FIRST) if item.path.is_relative_to(path)), len(FIRST))

    items.sort(key=place)


# Modules whose functions others compile (numba, Dr.Jit) are left out: the checker's wrapper cannot be compiled.
COMPILED = ("numba", "dr.syntax")
CHECKED = [
    ".".join(path.relative_to(SOURCE).with_suffix("").parts)
    for path in sorted(SOURCE.glob("reflet/**/*.py"))
    if path.name != "__init__.py" and not any(word in path.read_text() for word in COMPILED)
]
install_import_hook(CHECKED, "typechecker.check")
