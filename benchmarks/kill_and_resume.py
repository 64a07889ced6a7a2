"""Kills a bake at random moments, again and again, resumes it, and compares its files with those of an undisturbed bake.

Run it with a scene (any that ``reflet bake`` takes) and the number of kills::

    python benchmarks/kill_and_resume.py teapot-room 10

Prints one line a kill and, at the end, whether every file is the same, byte for byte; ends with status 1 if not.
"""

import hashlib
import random
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from reflet.bake import TIMINGS

BAKE = [sys.executable, "-c", "from reflet.cli.main import main; main()", "bake"]
OPTIONS = "--views 6 --spacing 2 --image-size 96 --em-size 32 --spp 8".split()


def contents(folder: Path) -> dict[str, str]:
    """The digest of every file of a bake but its timings."""
    files = (path for path in folder.rglob("*") if path.is_file() and path.name != TIMINGS)
    return {str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


def main(scene: str, kills: int) -> int:
    """Exit status of the whole."""
    rng = random.Random(1)
    with tempfile.TemporaryDirectory() as temporary:
        whole, broken = Path(temporary) / "whole", Path(temporary) / "broken"
        began = time.monotonic()
        subprocess.run([*BAKE, scene, *OPTIONS, "--out", str(whole)], check=True)
        duration = time.monotonic() - began
        for kill in range(kills):
            process = subprocess.Popen([*BAKE, scene, *OPTIONS, "--out", str(broken), "--resume"])
            moment = rng.uniform(0.05, 0.9) * duration
            try:
                process.wait(moment)
            except subprocess.TimeoutExpired:
                process.send_signal(signal.SIGKILL)
                process.wait()
            samples = len(list(broken.glob("maps/*/sample.json")))
            print(f"kill {kill + 1}: after {moment:.1f} s, {samples} viewpoints on disk", flush=True)
        subprocess.run([*BAKE, scene, *OPTIONS, "--out", str(broken), "--resume"], check=True)
        expected, found = contents(whole), contents(broken)
    different = sorted(name for name in {*expected, *found} if expected.get(name) != found.get(name))
    print(f"{len(expected)} files, {len(different)} differ" + "".join(f"\n  {name}" for name in different))
    return 1 if different else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], int(sys.argv[2])))
