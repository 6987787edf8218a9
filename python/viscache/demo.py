"""The demonstration behind `scripts/demo`: sweep the quantized cache and write a report.

`python -m viscache.demo` renders a built-in room with exact visibility and with the cache, over two
parameters. If there is a folder of scenes, its living room is rendered too. Frames in the output
folder are not rendered again.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

import viscache as vc

#: Output name, scene (a built-in name, or a path in the folder of scenes), swept parameters.
SWEEPS: tuple[tuple[str, str, dict[str, list[float]]], ...] = (
    ("living-room", "living-room/scene.xml", {"c_e": [4, 8, 16, 32], "c_n": [4, 8]}),
    ("room", "room?triangles=200000", {"c_e": [2, 4, 8, 16, 32], "c_z": [1, 4, 8]}),
)


def table(dataset: Any) -> str:
    """One line per point: parameters, error, queries per ray, times, speed-ups over exact."""
    columns = ["rel_l1", "ray_reduction", "total_s", "cpu_s", "speedup", "cpu_speedup"]
    frame = dataset[columns].to_dataframe().reset_index().drop(columns=["repeat", "seed"])
    return str(frame.to_string(index=False, float_format="{:.4g}".format))


def main(arguments: list[str] | None = None) -> int:
    """Run the demonstration; the report's path is the last line of the output."""
    parser = argparse.ArgumentParser(prog="scripts/demo", description=__doc__)
    parser.add_argument(
        "--output", type=Path, default=Path("out/demo"), help="folder of the results"
    )
    parser.add_argument("--scenes", type=Path, default=Path("../shared/scenes"), help="real scenes")
    parser.add_argument("--size", type=int, nargs=2, default=(640, 400), metavar=("W", "H"))
    options = parser.parse_args(arguments)

    for name, place, over in SWEEPS:
        builtin = "?" in place
        scene = place if builtin else str(options.scenes / place)
        if not builtin and not Path(scene).exists():
            print(f"{name}: left out, there is no {scene}", file=sys.stderr)
            continue
        folder = options.output / name
        dataset = vc.sweep(
            scene, "whitted", over=over, size=tuple(options.size), directory=folder, progress=True
        )
        report = options.output / ("report.html" if name == "room" else f"{name}.html")
        vc.report.write(dataset, report, progress=True)
        print(f"\n{name}: error and cost against exact visibility\n{table(dataset)}\n")
        print(report.resolve())
    return 0


if __name__ == "__main__":
    sys.exit(main())
