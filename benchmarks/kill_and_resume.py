"""Kills a bake at random moments, resumes it each time, and compares its files with those of an undisturbed bake.

Run it with a scene (any that ``reflet bake`` takes) and the number of kills::

    python benchmarks/kill_and_resume.py teapot-room 10

A bake that finishes between two kills is compared and begun anew. Prints a line for each kill and each comparison; ends
with status 1 if any byte of any file differs.
"""

import hashlib
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from reflet.pipelines.baking.timings import TIMINGS

BAKE = [sys.executable, "-c", "from reflet.cli.main import main; main()", "bake"]
OPTIONS = ["--views", "16", "--image-size", "224", "--em-size", "64", "--spp", "16"]  # viewpoints outlast the start


def contents(folder: Path) -> dict[str, str]:
    """The digest of every file of a bake but its timings."""
    files = (path for path in folder.rglob("*") if path.is_file() and path.name != TIMINGS)
    return {str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


def differences(whole: Path, broken: Path) -> int:
    """Number of files that differ, which are printed."""
    expected, found = contents(whole), contents(broken)
    different = sorted(name for name in {*expected, *found} if expected.get(name) != found.get(name))
    print(f"{len(expected)} files, {len(different)} differ", *different, sep="\n    ", flush=True)
    return len(different)


def bake(scene: str, out: Path, seconds: float | None = None) -> bool:
    """Whether the bake ended by itself within so many seconds; else it is killed."""
    process = subprocess.Popen([*BAKE, scene, *OPTIONS, "--out", str(out), "--resume"], stdout=subprocess.DEVNULL)
    try:
        if process.wait(seconds):
            sys.exit(f"the bake failed with status {process.returncode}")
    except subprocess.TimeoutExpired:
        process.send_signal(signal.SIGKILL)
        process.wait()
        return False
    return True


def main(scene: str, kills: int) -> int:
    """Exit status of the whole."""
    rng, killed, different = random.Random(1), 0, 0
    with tempfile.TemporaryDirectory() as temporary:
        whole, broken = Path(temporary) / "whole", Path(temporary) / "broken"
        began = time.monotonic()
        bake(scene, whole)
        duration = time.monotonic() - began
        while killed < kills:
            moment = rng.uniform(0.0, duration)
            if bake(scene, broken, moment):
                different += differences(whole, broken)
                shutil.rmtree(broken)
            else:
                killed += 1
                samples = len(list(broken.glob("maps/*/sample.json")))
                print(f"kill {killed}: after {moment:.1f} s, {samples} viewpoints on disk", flush=True)
        bake(scene, broken)
        different += differences(whole, broken)
    return 1 if different else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], int(sys.argv[2])))
