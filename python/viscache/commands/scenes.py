"""`viscache scenes`: the built-in procedural scenes."""

from __future__ import annotations

import argparse

from viscache.commands.shared import print_json


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--json", action="store_true", help="one JSON object")


def run(arguments: argparse.Namespace) -> int:
    from viscache.scenes import SCENES

    described = {
        name: {"description": entry.description, "parameters": dict(entry.parameters)}
        for name, entry in SCENES.items()
    }
    if arguments.json:
        print_json(described)
        return 0
    for name, entry in described.items():
        print(f"{name}: {entry['description']}")
        for parameter, default in dict(SCENES[name].parameters).items():
            print(f"    {parameter} = {default}")
    return 0
