"""Distant light in shells beside the paper's way: a map a viewpoint, on a box.

    python benchmarks/shells.py furniture_room|half_open|SCENE FOLDER [--views 3] [--spacing 2] [--joint-spacing 40] …

Bakes the scene both ways into FOLDER (and goes on with bakes that are there), and prints the display PSNR of the
distant layer alone, under the traced local layer: of maps of viewpoints on a box, of what the shells' PEM plays, of its
joint set alone, of static shells, and of the whole object, at the samples and all around. Beside them, the seconds that
the joint set took a viewpoint.
"""

import argparse
import json
from dataclasses import replace
from pathlib import Path

import furniture_rooms

from reflet.pem.container import open_pem
from reflet.pem.reader import read_statistics
from reflet.pipelines.bake import bake
from reflet.pipelines.compare import compare
from reflet.pipelines.load import load_scene
from reflet.report.comparison import PLACES, Comparison
from reflet.report.distant_choice import distant_choice
from reflet.scene.views.framing import frame_orbit
from reflet.scene.views.parameter_space import orbit_space

SCENES = {"furniture_room": (furniture_rooms.furniture_room, 10.0), "half_open": (furniture_rooms.half_open, 30.0)}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene")
    parser.add_argument("folder", type=Path)
    parser.add_argument("--environment")
    parser.add_argument("--reflect", action="append", default=[])
    parser.add_argument("--views", type=int, default=3)
    parser.add_argument("--spacing", type=float, default=2.0)
    parser.add_argument("--azimuth", type=float)
    parser.add_argument("--joint-spacing", type=float)
    parser.add_argument("--image-size", type=int, default=512)
    parser.add_argument("--em-size", type=int, default=256)
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--figures", action="store_true", help="also write a figure of each comparison")
    asked = parser.parse_args()

    if asked.scene in SCENES:
        make, azimuth = SCENES[asked.scene]
        scene = make()
    else:
        scene, azimuth = load_scene(asked.scene, environment=asked.environment, reflect=asked.reflect), None
    orbit = replace(frame_orbit(scene, azimuth_deg=asked.azimuth or azimuth), image_size=asked.image_size)
    space = orbit_space(orbit, asked.views, asked.spacing)
    rows: dict[str, tuple[Comparison, str]] = {}
    for name in ("box", "auto"):
        folder = asked.folder / name
        bake(
            scene, folder, space, distant=name, local="ellipsoid", em_size=asked.em_size, spp=asked.spp,
            joint_spacing_deg=asked.joint_spacing, resume=folder.exists(),
        )  # fmt: skip
        pem = open_pem(folder)
        if name == "auto":
            print(*map(distant_choice, *_choices(folder)), sep="\n")
            print(f"fades within {pem.fade_deg:g}°; {_joint_seconds(folder)}")
        comparison = compare(pem, rivals=False)
        if asked.figures:
            from reflet.report.figure import comparison_figure

            (asked.folder / f"{name}.png").write_bytes(comparison_figure(comparison))
        words = {"distant-only": "own maps", "distant-only-joint": "joint", "distant-only-static": "static"}
        for method, what in words.items():
            if method in comparison.methods:
                rows[f"{name}, {what}"] = comparison, method
        rows[f"{name}, whole object"] = comparison, "layered"
    places = [place for place in PLACES if any(result.where == place for result in rows["box, own maps"][0].results)]
    print(f"{'':22}" + "".join(f"{PLACES[place]:>16}" for place in places))
    for name, (comparison, method) in rows.items():
        values = (comparison.result(place, method).psnr_display for place in places)
        print(f"{name:22}" + "".join(f"{value:16.2f}" for value in values), flush=True)


def _choices(folder: Path) -> tuple[list[str], list[dict]]:
    names, statistics = read_statistics(folder)
    return names, statistics["distant"]


def _joint_seconds(folder: Path) -> str:
    lines = [json.loads(line) for line in (folder / "timings.jsonl").read_text().splitlines()]
    told = [line for line in lines if "joint_seconds" in line]
    (line,) = told
    count = line["joint_viewpoints"]
    return f"joint set of {count}, {line['joint_seconds'] / count:.2f} s a viewpoint"


if __name__ == "__main__":
    main()
