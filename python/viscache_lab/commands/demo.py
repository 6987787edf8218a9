"""A sweep of the quantized cache, and its report.

It renders a built-in room with exact visibility and with the cache, over two parameters. There is a
report after the first three settings, and one with all at the end. If there is a folder of scenes,
its living room is rendered too. Frames in the output folder are not rendered again.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import viscache as vc

#: The error that the reports open on.
TARGET = 0.01


@dataclass(frozen=True, slots=True)
class Part:
    """A sweep and its report.

    `scene` is a built-in name, or a path in the folder of scenes. `first` are the settings of the
    first report.
    """

    name: str
    scene: str
    over: dict[str, list[float]]
    first: Sequence[dict[str, float]]
    page: str


PARTS: tuple[Part, ...] = (
    Part(
        "room",
        "room?triangles=200000",
        {"c_e": [2, 4, 8, 16, 32], "c_z": [1, 4, 8]},
        [{"c_e": 4, "c_z": 4}, {"c_e": 8, "c_z": 4}, {"c_e": 16, "c_z": 4}],
        "report.html",
    ),
    Part(
        "living-room",
        "living-room/scene.xml",
        {"c_e": [4, 8, 16, 32], "c_n": [4, 8]},
        [],
        "living-room.html",
    ),
)


def table(dataset: Any) -> str:
    """One line per point: parameters, error, queries per ray, times, speed-ups over exact."""
    columns = ["rel_l1", "ray_reduction", "total_s", "cpu_s", "speedup", "cpu_speedup"]
    frame = dataset[columns].to_dataframe().reset_index()
    frame = frame.drop(columns=["repeat", "seed", "point"], errors="ignore")
    return str(frame.to_string(index=False, float_format="{:.4g}".format))


def reported(part: Part, scene: str, over: Any, options: argparse.Namespace, began: float) -> Path:
    """Sweep, write the report and print the table and its verdict."""
    dataset = vc.sweep(
        scene,
        "whitted",
        over=over,
        size=tuple(options.size),
        directory=options.output / part.name,
        progress=True,
    )
    page = vc.report.write(
        dataset, options.output / part.page, target=TARGET, progress=sys.stderr.isatty()
    )
    print(f"\n{part.name}: error and cost against exact visibility\n{table(dataset)}\n")
    found = vc.report.verdict(dataset, target=TARGET)
    print(found if found is not None else "")
    print(f"\n{page.resolve()} after {time.monotonic() - began:.0f} s", flush=True)
    return page


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--output", type=Path, default=Path("out/demo"), help="folder of the results"
    )
    parser.add_argument("--scenes", type=Path, default=Path("../shared/scenes"), help="real scenes")
    parser.add_argument("--size", type=int, nargs=2, default=(640, 400), metavar=("W", "H"))
    parser.add_argument("--first", action="store_true", help="only the first report")


def run(options: argparse.Namespace) -> int:
    """The report's path is the last line of the output."""
    began, pages = time.monotonic(), []
    for part in PARTS[:1] if options.first else PARTS:
        builtin = "?" in part.scene
        scene = part.scene if builtin else str(options.scenes / part.scene)
        if not builtin and not Path(scene).exists():
            print(f"{part.name}: left out, there is no {scene}", file=sys.stderr)
            continue
        page = options.output / part.page
        if part.first and (options.first or not page.exists()):
            reported(part, scene, part.first, options, began)
        if not options.first:
            reported(part, scene, part.over, options, began)
        pages.append(page)
    print()
    for page in reversed(pages):
        print(page.resolve())
    return 0
