"""Benchmarks: ratios against a named baseline of the same run."""

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
    peers = parser.add_argument_group("peers")
    peers.add_argument(
        "--environments", metavar="DIR", help="folder of the peers' virtual environments"
    )
    peers.add_argument(
        "--make-environments",
        action="store_true",
        help="make them there with venv and pip, and measure nothing",
    )
    own = parser.add_argument_group("parity")
    own.add_argument(
        "--only", metavar="GLOB", help="scenes with such names, e.g. 'material/*'; cases of peers"
    )
    own.add_argument("-o", "--output", metavar="DIR", help="folder of the page; of peers too")
    own.add_argument("--threads", type=int, metavar="N", help="all cores by default")


def run(arguments: argparse.Namespace) -> int:
    """Exit status 0: done; 1: an answer was wrong."""
    from viscache_lab import bench
    from viscache_lab.bench.peer_page import write_pages
    from viscache_lab.bench.text import text

    if arguments.name == "list":
        return _list(arguments.json)
    if arguments.make_environments:
        return _make_environments(arguments)
    own = _peers(arguments) if arguments.name == "peers" else _parity(arguments)
    results = []
    for name in bench.BENCHES if arguments.name == "all" else [arguments.name]:
        results.append(bench.run(name, arguments.quick, own))
        if name == "peers" and arguments.output is not None:
            write_pages(Path(arguments.output), results[-1])
        if not arguments.json:
            print(text(results[-1]), flush=True)
            if arguments.output is not None:
                print("  page:", Path(arguments.output) / "index.html")
    if arguments.json:
        print_json(results[0] if arguments.name != "all" else {"benches": results})
    return 0 if all(r["answers_hold"] for r in results) else 1


def _peers(arguments: argparse.Namespace) -> Callable[[bool], Any]:
    from viscache_lab.bench.against_peers import against_peers

    if arguments.threads is not None:
        raise ValueError("--threads is an option of the bench parity alone")
    only = {} if arguments.only is None else {"only": arguments.only}
    return partial(against_peers, environments=_environments(arguments), **only)


def _environments(arguments: argparse.Namespace) -> Path:
    from viscache_lab.bench.peer_environments import default_folder

    return default_folder() if arguments.environments is None else Path(arguments.environments)


def _make_environments(arguments: argparse.Namespace) -> int:
    """Exit status 1: one could not be made."""
    from viscache_lab.bench.peer_environments import make_environments

    if arguments.name != "peers":
        raise ValueError("--make-environments is an option of the bench peers alone")
    made = make_environments(_environments(arguments))
    if arguments.json:
        print_json({"environments": made})
    else:
        for name, why in made.items():
            print(f"{name}: {why or 'made'}")
    return 1 if any(made.values()) else 0


def _parity(arguments: argparse.Namespace) -> Callable[[bool], Any] | None:
    """The bench with the options that it alone takes; None without them."""
    from viscache_lab.bench.parity import parity

    given = {"only": arguments.only, "output": arguments.output, "threads": arguments.threads}
    set_ = {name: value for name, value in given.items() if value is not None}
    if arguments.name != "parity":
        if arguments.environments is not None:
            raise ValueError("--environments is an option of the bench peers alone")
        if arguments.output is not None:
            raise ValueError("--output is an option of the benches parity and peers alone")
        if set_:
            name = next(iter(set_))
            whose = "benches parity and peers" if name == "only" else "bench parity"
            raise ValueError(f"--{name} is an option of the {whose} alone")
        return None
    if arguments.threads is not None and arguments.threads < 1:
        raise ValueError(f"threads must be >= 1, got {arguments.threads}")
    if "output" in set_:
        set_["output"] = Path(arguments.output)
    return partial(parity, progress=sys.stderr.isatty(), **set_)


def _list(as_json: bool) -> int:
    from viscache_lab.bench import BENCHES

    if as_json:
        print_json({"benches": [{"bench": name} for name in BENCHES]})
        return 0
    for name, info in BENCHES.items():
        print(name, f"({info.description})")
    return 0
