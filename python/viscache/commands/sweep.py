"""`viscache sweep FILE.toml -o DIR`, or `viscache sweep SCENE --over c_e=4,8,16 -o DIR`."""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

from viscache.commands.shared import (
    add_loading,
    add_shot,
    add_workers,
    at_least_one,
    chosen_executor,
    chosen_shot,
    print_json,
    threads_of_a_worker,
)
from viscache.settings import by_name
from viscache.sweeps.sweep import SweepFile


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "what", metavar="FILE.toml|SCENE", help="a sweep file, or a scene with --over"
    )
    parser.add_argument("-o", "--output", metavar="DIR", required=True)
    add_loading(parser)
    add_workers(parser)
    scene = parser.add_argument_group("of a scene, without a file")
    scene.add_argument(
        "--over",
        metavar="NAME=VALUE,VALUE",
        action="append",
        default=[],
        help="the grid: c_e=4,8,16; repeat for more names; integrator.n_vpls=256,1024",
    )
    scene.add_argument("--integrator", help="(whitted)")
    scene.add_argument("--visibility", help="the cache (aqvc)")
    scene.add_argument("--rays", help="(embree)")
    add_shot(scene)
    scene.add_argument("--repeats", type=at_least_one, help="of other seeds (1)")
    parser.add_argument(
        "--apart",
        action=argparse.BooleanOptionalAction,
        default=None,
        help="one frame at a time, so that timings are undisturbed (the default"
        " without --workers and --dask)",
    )
    parser.add_argument(
        "--references", metavar="DIR", help="where sweeps share their finished references"
    )
    parser.add_argument("--json", action="store_true", help="one JSON object")


#: Options that a sweep file has as keys.
OF_A_SCENE = (
    *("over", "integrator", "visibility", "rays", "use", "set", "size", "spp", "repeats"),
    *("seed", "threads", "camera", "env"),
)


def run(arguments: argparse.Namespace) -> int:
    sweep = _from_file(arguments) if arguments.what.endswith(".toml") else _of_scene(arguments)
    # A switch of the command and a key of the file do the same
    if arguments.missing == "skip":
        sweep = replace(sweep, missing="skip")
    if arguments.allow_outside:
        sweep = replace(sweep, allow_outside=True)
    if sweep.threads is None:
        sweep = replace(sweep, threads=threads_of_a_worker(arguments))
    with chosen_executor(arguments) as executor:
        dataset = sweep.run(
            arguments.output,
            executor=executor,
            apart=arguments.apart,
            references=arguments.references,
            progress=True,
        )
    if "mended" in dataset.attrs:
        print(dataset.attrs["mended"], file=sys.stderr)
    table = Path(arguments.output) / "table.csv"
    if arguments.json:
        sizes = {str(k): v for k, v in dataset.sizes.items()}
        print_json({"directory": arguments.output, "table": str(table), "sizes": sizes})
    else:
        print(f"{table}\nviscache report {arguments.output} writes the report", file=sys.stdout)
    return 0


def _from_file(arguments: argparse.Namespace) -> SweepFile:
    for name in OF_A_SCENE:
        if getattr(arguments, name) not in (None, []):
            raise ValueError(f"--{name} must come with a scene; {arguments.what} has it as a key")
    return SweepFile.load(arguments.what)


def _of_scene(arguments: argparse.Namespace) -> SweepFile:
    if not arguments.over:
        raise ValueError(
            f"a sweep of a scene must have --over NAME=VALUE,VALUE, got {arguments.what} alone"
            " (sweep files end in .toml)"
        )
    given: dict[str, Any] = {"scene": arguments.what, "over": _grid(arguments.over)}
    given |= chosen_shot(arguments)
    if arguments.repeats is not None:
        given["repeats"] = arguments.repeats
    chosen: dict[by_name.Role, Any] = {
        "integrator": by_name.make("integrator", arguments.integrator or "whitted"),
        "visibility": by_name.make("visibility", arguments.visibility or "aqvc"),
        "rays": by_name.make("rays", arguments.rays or "embree"),
    }
    for role, settings in by_name.assign(chosen, arguments.set).items():
        given[role] = by_name.described(role, settings)
    return SweepFile(**given)


def _grid(over: list[str]) -> dict[str, list[Any]]:
    """`["c_e=4,8"]` → `{"c_e": [4, 8]}`."""
    grid: dict[str, list[Any]] = {}
    for text in over:
        name, equals, values = text.partition("=")
        if not equals or not name or not values:
            raise ValueError(f"--over must be NAME=VALUE,VALUE, got {text!r}")
        if name in grid:
            raise ValueError(f"--over must name {name} once, with all its values")
        grid[name] = [by_name.literal(value.strip()) for value in values.split(",")]
    return grid
