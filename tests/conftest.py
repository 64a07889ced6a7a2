"""Shapes and types of every annotated function are checked while tests run, and only then.

What hypothesis tries is the same on every run, however slow the machine. Processes that tests start hear Ctrl-C: a
shell that runs the tests in its background has it ignored, and they would inherit that.
"""

import signal
from pathlib import Path

from hypothesis import HealthCheck, settings
from jaxtyping import install_import_hook

settings.register_profile(
    "reflet", derandomize=True, deadline=None, suppress_health_check=[HealthCheck.too_slow], print_blob=True
)
settings.load_profile("reflet")

signal.signal(signal.SIGINT, signal.default_int_handler)

SOURCE = Path(__file__).parents[1] / "src"

# Modules whose functions others compile (numba, Dr.Jit) are left out: the checker's wrapper cannot be compiled.
COMPILED = ("numba", "dr.syntax")
CHECKED = [
    ".".join(path.relative_to(SOURCE).with_suffix("").parts)
    for path in sorted(SOURCE.glob("reflet/**/*.py"))
    if path.name != "__init__.py" and not any(word in path.read_text() for word in COMPILED)
]
install_import_hook(CHECKED, "typechecker.check")
