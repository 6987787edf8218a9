"""`viscache tune SCENE --error 0.01`; `--target "rel_l1<=0.01"`, "flip<=.02", "seconds<=10"."""

from __future__ import annotations

import argparse
import re
import sys
from typing import Any

from viscache.commands.shared import (
    add_scene,
    add_shot,
    chosen_scene,
    chosen_shot,
    print_json,
    print_table,
)
from viscache.settings import by_name
from viscache.sweeps.samples import METRICS
from viscache.sweeps.tune import tune
from viscache.sweeps.tuned import Tuned

#: What a target may be of.
TARGETS = (*METRICS, "seconds")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_scene(parser)
    wanted = parser.add_mutually_exclusive_group()
    wanted.add_argument(
        "--error",
        type=float,
        default=0.01,
        metavar="REL_L1_REFLECTED",
        help="wanted error against exact visibility, of light on surfaces (default: 0.01)",
    )
    wanted.add_argument(
        "--target",
        type=target,
        metavar='"METRIC<=0.01"',
        help=f'the same with its metric: {", ".join(METRICS)}; or "seconds<=10" of a frame',
    )
    parser.add_argument(
        "--visibility",
        default="aqvc",
        choices=[name for name in by_name.NAMES["visibility"] if name != "exact"],
        help="the cache (default: aqvc)",
    )
    parser.add_argument(
        "--parameter",
        metavar="NAME",
        help="the number to search; of aqvc by default c_e, c_finest and bright together",
    )
    parser.add_argument(
        "--between",
        nargs=2,
        type=by_name.literal,
        metavar=("LOW", "HIGH"),
        help="where to search NAME; needed but for c_e",
    )
    parser.add_argument(
        "--passes",
        action="store_true",
        help="choose passes instead of one frame: exact, corrected or of picks (render --passes)",
    )
    parser.add_argument("--integrator", default="whitted", choices=["direct", "whitted", "ao"])
    add_shot(parser)
    parser.add_argument("--json", action="store_true", help="one JSON object")


def target(text: str) -> tuple[str, float]:
    """Metric and number of "rel_l1<=0.01", or "seconds" and theirs."""
    must = f"must be {' or '.join(f'{m}<=NUMBER' for m in TARGETS)}, got {text!r}"
    found = re.fullmatch(r"\s*(\w+)\s*<=\s*([0-9.eE+-]+)\s*", text)
    if found is None:
        raise argparse.ArgumentTypeError(must)
    try:
        return TARGETS[TARGETS.index(found[1])], float(found[2])
    except ValueError as error:
        raise argparse.ArgumentTypeError(must) from error


def run(arguments: argparse.Namespace) -> int:
    """Exit status 0: the target is reached, perhaps within noise; 1: it is missed."""
    chosen: dict[by_name.Role, object] = {
        "integrator": by_name.make("integrator", arguments.integrator),
        "visibility": by_name.make("visibility", arguments.visibility),
        "rays": by_name.make("rays", "embree"),
    }
    made = by_name.assign(chosen, arguments.set)
    wanted: tuple[str, Any] = arguments.target or (METRICS[0], arguments.error)
    parameter: Any = arguments.parameter
    if arguments.between is not None:
        if parameter is None:
            raise ValueError("--between must come with --parameter NAME")
        parameter = {parameter: tuple(arguments.between)}
    found = tune(
        chosen_scene(arguments),
        made["integrator"],
        **{wanted[0]: wanted[1]},
        visibility=made["visibility"],
        parameter=parameter,
        passes=arguments.passes,
        **chosen_shot(arguments),
        progress=sys.stderr.isatty(),
    )
    if arguments.json:
        print_json(found.as_dict())
    else:
        low, high = found.interval
        light_cells = {} if found.c_l is None else {"c_l": found.c_l}
        print_table(
            {
                **chosen_values(found),
                **light_cells,
                found.metric: found.error,
                "95 % interval": f"{low:.4g} … {high:.4g}",
                "target": found.target,
                "outcome": found.outcome,
                "queries per ray": found.ray_reduction,
                "seconds": found.wall_s,
                "CPU seconds": found.seconds,
                "exact CPU seconds": found.seconds_exact,
                "pilots": len(found.pilots),
            }
        )
        if found.message:
            print(found.message)
    return 1 if found.outcome == "missed" else 0


def chosen_values(found: Tuned) -> dict[str, Any]:
    """What to render with."""
    if found.passes is not None:
        way = "exact" if found.is_exact else "corrected"
        return {"passes": found.passes, "visibility": way, **found.also}
    if found.is_exact:
        return {"visibility": "exact"}
    return {found.parameter: found.value, **found.also}
