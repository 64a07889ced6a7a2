"""What a bake notes of its own work: seconds, which play no part in its result, and how solving went."""

import json
from contextlib import suppress
from pathlib import Path
from typing import Any

from reflet.infer.records import Solution

TIMINGS = "timings.jsonl"


def log_timing(folder: Path, **entry: float) -> None:
    """Appends a line to the bake's timings."""
    with suppress(OSError), (folder / TIMINGS).open("a") as file:
        file.write(json.dumps(entry) + "\n")


def solution_statistics(solution: Solution) -> dict[str, Any]:
    """A solution without its texels."""
    return {
        "iterations": solution.iterations,
        "relative_residual": solution.relative_residual,
        "seen_share": solution.seen_share,
    }
