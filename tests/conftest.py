"""Shapes and types of every annotated function are checked while tests run, and only then."""

from pathlib import Path

from jaxtyping import install_import_hook

SOURCE = Path(__file__).parents[1] / "src"

# Modules whose functions others compile (numba, Dr.Jit) are left out: the checker's wrapper cannot be compiled.
COMPILED = ("numba", "dr.syntax")
CHECKED = [
    ".".join(path.relative_to(SOURCE).with_suffix("").parts)
    for path in sorted(SOURCE.glob("reflet/**/*.py"))
    if path.name != "__init__.py" and not any(word in path.read_text() for word in COMPILED)
]
install_import_hook(CHECKED, "typechecker.check")
