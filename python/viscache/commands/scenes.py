"""`viscache scenes`: the built-in procedural scenes."""

from __future__ import annotations

import argparse
import importlib
from typing import Any

from viscache.commands.shared import print_json
from viscache.settings import NotThereYetError


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--json", action="store_true", help="one JSON object")


def run(arguments: argparse.Namespace) -> int:
    vc: Any = importlib.import_module("viscache")
    scenes = getattr(vc, "scenes", None)
    if scenes is None:
        raise NotThereYetError("the built-in scenes are not there yet in this version of viscache")
    described: dict[str, dict[str, Any]] = {
        name: {"description": entry.description, "parameters": dict(entry.parameters)}
        for name, entry in scenes.SCENES.items()
    }
    if arguments.json:
        print_json(described)
        return 0
    for name, entry in described.items():
        print(f"{name}: {entry['description']}")
        for parameter, default in entry["parameters"].items():
            print(f"    {parameter} = {default}")
    return 0
