"""Benchmarks: ratios against a named baseline of the same run."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from viscache.commands.shared import print_json
from viscache_lab.experiment.registry import print_list


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


#: Benches that take an option, in words.
OPTIONS = {
    "environments": ("peers",),
    "output": ("parity", "peers"),
    "only": ("parity", "peers"),
    "threads": ("parity",),
}


def run(arguments: argparse.Namespace) -> int:
    """Exit status 0: done; 1: an answer was wrong."""
    from viscache_lab import bench
    from viscache_lab.bench.peer_page import write_pages
    from viscache_lab.bench.text import text

    if arguments.name == "list":
        return print_list(bench.BENCHES, as_json=arguments.json)
    if arguments.make_environments:
        return _make_environments(arguments)
    options = _options(arguments)
    results = []
    for name in bench.BENCHES if arguments.name == "all" else [arguments.name]:
        results.append(
            bench.run_bench(name, arguments.quick, progress=sys.stderr.isatty(), **options)
        )
        if name == "peers" and arguments.output is not None:
            write_pages(Path(arguments.output), results[-1])
        if not arguments.json:
            print(text(results[-1]), flush=True)
            if arguments.output is not None:
                print("  page:", Path(arguments.output) / "index.html")
    if arguments.json:
        print_json(results[0] if arguments.name != "all" else {"benches": results})
    return 0 if all(r["answers_hold"] for r in results) else 1


def _options(arguments: argparse.Namespace) -> dict[str, Any]:
    """The options of the bench alone; the peers' page is written here."""
    given = {name: getattr(arguments, name) for name in OPTIONS}
    given = {name: value for name, value in given.items() if value is not None}
    for name in given:
        benches = OPTIONS[name]
        if arguments.name not in benches:
            whose = f"bench{'es' * bool(benches[1:])} {' and '.join(benches)}"
            raise ValueError(f"--{name} is an option of the {whose} alone")
    if given.get("threads", 1) < 1:
        raise ValueError(f"threads must be >= 1, got {arguments.threads}")
    if arguments.name == "peers":
        given.pop("output", None)
    return given | {n: Path(given[n]) for n in ("environments", "output") if n in given}


def _environments(arguments: argparse.Namespace) -> Path:
    from viscache_lab.bench.peers import default_folder

    return default_folder() if arguments.environments is None else Path(arguments.environments)


def _make_environments(arguments: argparse.Namespace) -> int:
    """Exit status 1: one could not be made."""
    from viscache_lab.bench.peers import make_environments

    if arguments.name != "peers":
        raise ValueError("--make-environments is an option of the bench peers alone")
    made = make_environments(_environments(arguments))
    if arguments.json:
        print_json({"environments": made})
    else:
        for name, why in made.items():
            print(f"{name}: {why or 'made'}")
    return 1 if any(made.values()) else 0
