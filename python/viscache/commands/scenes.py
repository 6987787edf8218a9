"""`viscache scenes`: the built-in procedural scenes."""

from __future__ import annotations

import argparse

from viscache.commands.shared import print_json


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--json", action="store_true", help="one JSON object")


def run(arguments: argparse.Namespace) -> int:
    from viscache.scenes import SCENES

    described = {
        name: {
            "description": entry.description,
            "parameters": dict(entry.parameters),
            "ranges": {k: [r.low, r.high] for k, r in entry.ranges.items()},
        }
        for name, entry in SCENES.items()
    }
    if arguments.json:
        print_json(described)
        return 0
    for name, entry in SCENES.items():
        print(f"{name}: {entry.description}")
        for parameter, default in entry.parameters.items():
            limits = entry.ranges.get(parameter)
            print(f"    {parameter} = {default}{f' ({limits})' if limits else ''}")
    return 0
