"""`viscache bench NAME|all|list`: the benchmarks of `viscache.bench`."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from viscache.commands.shared import print_json


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("name", metavar="NAME|all|list")
    parser.add_argument("--quick", action="store_true", help="small sizes, few repeats")
    parser.add_argument("--json", action="store_true", help="one JSON object")
    own = parser.add_argument_group("parity")
    own.add_argument("--only", metavar="GLOB", help="scenes with such names, e.g. 'material/*'")
    own.add_argument("-o", "--output", metavar="DIR", help="folder of the page and its scene files")
    own.add_argument("--threads", type=int, metavar="N", help="all cores by default")


def run(arguments: argparse.Namespace) -> int:
    """Exit status 0: done; 1: an answer was wrong."""
    from viscache import bench
    from viscache.bench.text import text

    if arguments.name == "list":
        return _list(arguments.json)
    own = _parity(arguments)
    results = []
    for name in bench.BENCHES if arguments.name == "all" else [arguments.name]:
        results.append(bench.run(name, arguments.quick, own))
        if not arguments.json:
            print(text(results[-1]), flush=True)
            if arguments.output is not None:
                print("  page:", Path(arguments.output) / "index.html")
    if arguments.json:
        print_json(results[0] if arguments.name != "all" else {"benches": results})
    return 0 if all(r["answers_hold"] for r in results) else 1


def _parity(arguments: argparse.Namespace) -> Callable[[bool], Any] | None:
    """The bench with the options that it alone takes; None without them."""
    from viscache.bench.parity import parity

    given = {"only": arguments.only, "output": arguments.output, "threads": arguments.threads}
    set_ = {name: value for name, value in given.items() if value is not None}
    if arguments.name != "parity":
        if set_:
            raise ValueError(f"--{next(iter(set_))} is an option of the bench parity alone")
        return None
    if arguments.threads is not None and arguments.threads < 1:
        raise ValueError(f"threads must be >= 1, got {arguments.threads}")
    if "output" in set_:
        set_["output"] = Path(arguments.output)
    return partial(parity, progress=sys.stderr.isatty(), **set_)


def _list(as_json: bool) -> int:
    from viscache.bench import BENCHES

    if as_json:
        print_json({"benches": [{"bench": name} for name in BENCHES]})
        return 0
    for name, info in BENCHES.items():
        print(name, f"({info.description})")
    return 0
