"""Shapes and types of every annotated function are checked while tests run, and only then."""

from pathlib import Path

from jaxtyping import install_import_hook

SOURCE = Path(__file__).parents[1] / "src"

# Modules with numba kernels are left out: the checker's wrapper cannot be compiled.
CHECKED = [
    ".".join(path.relative_to(SOURCE).with_suffix("").parts)
    for path in sorted(SOURCE.glob("reflet/**/*.py"))
    if path.name != "__init__.py" and "numba" not in path.read_text()
]
install_import_hook(CHECKED, "typechecker.check")
