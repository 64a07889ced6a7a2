"""Bakes every model of a folder small, three viewpoints each, and prints how it went or why it was refused.

Run it with a folder of .glb, .gltf and .obj files (searched recursively) and an environment to light them::

    python benchmarks/bake_models.py models studio.hdr
    python benchmarks/bake_models.py models studio.hdr --reflect '*'

Whatever follows the environment is handed to ``reflet bake``.
Ends with status 1 if a model fails otherwise than with one sentence.
"""

import subprocess
import sys
import tempfile
import time
from pathlib import Path

BAKE = [sys.executable, "-c", "from reflet.cli.main import main; main()", "bake"]
OPTIONS = ["--views", "3", "--image-size", "128", "--em-size", "32", "--spp", "8"]


def main(folder: Path, environment: Path, more: list[str]) -> int:
    """Exit status of the whole."""
    failures = 0
    for model in sorted(path for path in folder.rglob("*") if path.suffix.lower() in (".glb", ".gltf", ".obj")):
        with tempfile.TemporaryDirectory() as temporary:
            began = time.monotonic()
            command = [
                *BAKE,
                str(model),
                "--environment",
                str(environment),
                *OPTIONS,
                *more,
                "--out",
                f"{temporary}/pem",
            ]
            done = subprocess.run(command, capture_output=True, text=True, check=False)
            seconds = time.monotonic() - began
        said = done.stderr.strip().splitlines()
        warnings = [line for line in said if line.startswith("Warning: ")]
        if done.returncode == 0:
            verdict = f"baked in {seconds:.0f} s"
        elif done.returncode == 2 and len(said) == len(warnings) + 1:
            verdict = f"refused: {said[-1]}"
        else:
            verdict, failures = f"FAILED with status {done.returncode}: {said[-1] if said else ''}", failures + 1
        print(f"{model.name}: {verdict}", *warnings, sep="\n    ", flush=True)
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]), Path(sys.argv[2]), sys.argv[3:]))
