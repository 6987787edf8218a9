"""`viscache bench NAME|all|list`: the benchmarks of `viscache.bench`."""

from __future__ import annotations

import argparse

from viscache.commands.shared import print_json


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("name", metavar="NAME|all|list")
    parser.add_argument("--quick", action="store_true", help="small sizes, few repeats")
    parser.add_argument("--json", action="store_true", help="one JSON object")


def run(arguments: argparse.Namespace) -> int:
    """Exit status 0: done; 1: an answer was wrong."""
    from viscache import bench
    from viscache.bench.text import text

    if arguments.name == "list":
        return _list(arguments.json)
    results = []
    for name in bench.BENCHES if arguments.name == "all" else [arguments.name]:
        results.append(bench.run(name, arguments.quick))
        if not arguments.json:
            print(text(results[-1]), flush=True)
    if arguments.json:
        print_json(results[0] if arguments.name != "all" else {"benches": results})
    return 0 if all(r["answers_hold"] for r in results) else 1


def _list(as_json: bool) -> int:
    from viscache.bench import BENCHES

    if as_json:
        print_json({"benches": [{"bench": name} for name in BENCHES]})
        return 0
    for name, info in BENCHES.items():
        print(name, f"({info.description})")
    return 0
