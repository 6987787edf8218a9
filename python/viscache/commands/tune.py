"""`viscache tune SCENE --error 0.01`."""

from __future__ import annotations

import argparse

from viscache import sources
from viscache.commands.shared import at_least_one, print_json, print_table, size
from viscache.settings import by_name
from viscache.sweeps.tune import tune


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("scene", metavar="SCENE", help="a file, or a built-in name with parameters")
    parser.add_argument(
        "--error",
        type=float,
        default=0.01,
        metavar="REL_L1",
        help="that is wanted against exact visibility (default: 0.01)",
    )
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


def run(arguments: argparse.Namespace) -> int:
    """Exit status 0: the target is reached; 1: it is not."""
    chosen: dict[by_name.Role, object] = {
        "integrator": by_name.make("integrator", arguments.integrator),
        "visibility": by_name.make("visibility", "aqvc"),
        "rays": by_name.make("rays", "embree"),
    }
    made = by_name.assign(chosen, arguments.set)
    found = tune(
        sources.open_scene(arguments.scene),
        made["integrator"],
        rel_l1=arguments.error,
        visibility=made["visibility"],
        size=arguments.size,
        spp=arguments.spp,
        seed=arguments.seed,
        threads=arguments.threads,
        camera=arguments.camera,
        env=arguments.env,
    )
    if arguments.json:
        print_json(found.as_dict())
    else:
        low, high = found.interval
        print_table(
            {
                "c_e": found.c_e,
                "c_l": found.as_dict()["c_l"],
                "rel_l1": found.rel_l1,
                "95 % interval": f"{low:.4g} … {high:.4g}",
                "target": found.target,
                "reached": "yes" if found.reached else "no",
                "queries per ray": found.ray_reduction,
                "pilots": len(found.pilots),
            }
        )
        if found.message:
            print(found.message)
    return 0 if found.reached else 1
