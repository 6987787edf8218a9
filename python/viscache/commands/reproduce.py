"""`viscache reproduce NAME|all|list`: figures and tables of the papers."""

from __future__ import annotations

import argparse

from viscache.commands.shared import print_json
from viscache.settings import NotThereYetError, nearest

#: Names of the figures; none of them is there yet.
FIGURES = (
    *(f"aqvc-fig{n}" for n in range(2, 9)),
    "aqvc-claims",
    "vlf-fig1",
    "vismap-fig1",
    "vismap-temporal",
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("name", metavar="NAME|all|list")
    parser.add_argument("-o", "--output", metavar="DIR")
    parser.add_argument("--quick", action="store_true", help="small sizes")
    parser.add_argument("--json", action="store_true", help="one JSON object")


def run(arguments: argparse.Namespace) -> int:
    if arguments.name == "list":
        if arguments.json:
            print_json({"figures": [{"figure": name, "available": False} for name in FIGURES]})
        else:
            for name in FIGURES:
                print(f"{name}: not there yet")
        return 0
    if arguments.name != "all" and arguments.name not in FIGURES:
        raise ValueError(f"unknown figure {arguments.name!r}{nearest(arguments.name, FIGURES)}")
    raise NotThereYetError(
        f"reproduce {arguments.name} is not there yet in this version of viscache"
    )
