"""`viscache tune SCENE --error 0.01`, or `--target "rel_l1<=0.01"` of the paper's metric."""

from __future__ import annotations

import argparse
import re
import sys
from typing import get_args

from viscache.commands.shared import (
    add_scene,
    at_least_one,
    chosen_scene,
    print_json,
    print_table,
    size,
)
from viscache.settings import by_name
from viscache.sweeps.samples import ErrorMetric
from viscache.sweeps.tune import tune

METRICS: tuple[ErrorMetric, ...] = get_args(ErrorMetric)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_scene(parser)
    wanted = parser.add_mutually_exclusive_group()
    wanted.add_argument(
        "--error",
        type=float,
        default=0.01,
        metavar="REL_L1",
        help="wanted error against exact visibility, of light on surfaces (default: 0.01)",
    )
    wanted.add_argument(
        "--target",
        type=target,
        metavar='"METRIC<=0.01"',
        help=f"the same with its metric: {' or '.join(METRICS)}",
    )
    parser.add_argument(
        "--visibility",
        default="aqvc",
        choices=[name for name in by_name.NAMES["visibility"] if name != "exact"],
        help="the cache (default: aqvc)",
    )
    parser.add_argument("--parameter", metavar="NAME", help="the number to search: c_e of aqvc")
    parser.add_argument(
        "--between",
        nargs=2,
        type=by_name.literal,
        metavar=("LOW", "HIGH"),
        help="where to search; needed but for c_e",
    )
    parser.add_argument("--use", choices=["replace", "correct"], help="how the cache is used")
    parser.add_argument("--integrator", default="whitted", choices=["direct", "whitted", "ao"])
    parser.add_argument(
        "--set",
        metavar="NAME=VALUE",
        action="append",
        default=[],
        help="a parameter by its symbol: c_n=8, integrator.n_vpls=256",
    )
    parser.add_argument("--size", type=size, metavar="WxH", help="pixels; the camera's by default")
    parser.add_argument("--spp", type=at_least_one, default=1, help="samples per pixel")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--threads", type=at_least_one)
    parser.add_argument("--camera", metavar="NAME")
    parser.add_argument("--env", metavar="FILE", help="environment light")
    parser.add_argument("--json", action="store_true", help="one JSON object")


def target(text: str) -> tuple[ErrorMetric, float]:
    """Metric and number of "rel_l1<=0.01"."""
    must = f"must be {' or '.join(f'{m}<=NUMBER' for m in METRICS)}, got {text!r}"
    found = re.fullmatch(r"\s*(\w+)\s*<=\s*([0-9.eE+-]+)\s*", text)
    if found is None:
        raise argparse.ArgumentTypeError(must)
    try:
        return METRICS[METRICS.index(found[1])], float(found[2])
    except ValueError as error:
        raise argparse.ArgumentTypeError(must) from error


def run(arguments: argparse.Namespace) -> int:
    """Exit status 0: the target is reached; 1: it is not."""
    chosen: dict[by_name.Role, object] = {
        "integrator": by_name.make("integrator", arguments.integrator),
        "visibility": by_name.make("visibility", arguments.visibility),
        "rays": by_name.make("rays", "embree"),
    }
    made = by_name.assign(chosen, arguments.set)
    metric, error = arguments.target or (METRICS[0], arguments.error)
    found = tune(
        chosen_scene(arguments),
        made["integrator"],
        rel_l1=error,
        metric=metric,
        visibility=made["visibility"],
        parameter=arguments.parameter,
        between=arguments.between,
        use=arguments.use,
        size=arguments.size,
        spp=arguments.spp,
        seed=arguments.seed,
        threads=arguments.threads,
        camera=arguments.camera,
        env=arguments.env,
        progress=sys.stderr.isatty(),
    )
    if arguments.json:
        print_json(found.as_dict())
    else:
        low, high = found.interval
        light_cells = {} if found.c_l is None else {"c_l": found.c_l}
        print_table(
            {
                found.parameter: found.value,
                **light_cells,
                found.metric: found.error,
                "95 % interval": f"{low:.4g} … {high:.4g}",
                "target": found.target,
                "reached": "yes" if found.reached else "no",
                "queries per ray": found.ray_reduction,
                "CPU seconds": found.seconds,
                "exact CPU seconds": found.seconds_exact,
                "pilots": len(found.pilots),
            }
        )
        if found.message:
            print(found.message)
    return 0 if found.reached else 1
