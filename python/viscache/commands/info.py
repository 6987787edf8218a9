"""`viscache info SCENE`: what a scene holds."""

from __future__ import annotations

import argparse

from viscache import sources
from viscache.commands.shared import print_json, print_table


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("scene", metavar="SCENE", help="a file, or a built-in name with parameters")
    parser.add_argument("--json", action="store_true", help="one JSON object")


def run(arguments: argparse.Namespace) -> int:
    info = sources.open_scene(arguments.scene).info()
    if arguments.json:
        print_json(info)
        return 0
    plain = {k: v for k, v in info.items() if k != "warnings"}
    for name in ("lights", "cameras"):
        plain[name] = len(info[name])
    print_table(plain)
    for warning in info["warnings"]:
        print(f"not modelled: {warning}")
    return 0
