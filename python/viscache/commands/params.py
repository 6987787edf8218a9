"""`viscache params [NAME]`: parameters of integrators, rays and caches by the papers' symbols."""

from __future__ import annotations

import argparse
import textwrap
from typing import Any

from viscache.commands.shared import print_json
from viscache.settings import by_name
from viscache.settings.parameter_docs import parameter_docs
from viscache.settings.spelling import nearest

WIDTH = 100


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "name", metavar="NAME", nargs="?", help="aqvc, whitted, embree, ...; all names without it"
    )
    parser.add_argument("--json", action="store_true", help="one JSON object")


def run(arguments: argparse.Namespace) -> int:
    if arguments.name is None:
        _names(arguments.json)
    else:
        _parameters(arguments.name, arguments.json)
    return 0


def _names(as_json: bool) -> None:
    names = {role: list(known) for role, known in by_name.NAMES.items()}
    if as_json:
        print_json(names)
        return
    for role, known in names.items():
        print(f"{role}: {', '.join(known)}")


def _parameters(name: str, as_json: bool) -> None:
    roles = {n: role for role, known in by_name.NAMES.items() for n in known}
    if name not in roles:
        raise ValueError(f"unknown name {name!r}{nearest(name, roles)}")
    cls = by_name.settings_class(roles[name], name)
    found = parameter_docs(cls)
    if as_json:
        told: dict[str, Any] = {"name": name, "role": roles[name], "class": cls.__name__}
        rows = [
            {"name": p.name, "default": p.default, "kind": p.kind, "text": p.text} for p in found
        ]
        print_json(told | {"parameters": rows})
        return
    print(f"{name}: {roles[name]}, vc.{cls.__name__}")
    for p in found:
        print(f"\n{p.name} = {p.default}" + (f"   ({p.kind})" if p.kind else ""))
        if p.text:
            print(textwrap.fill(p.text, WIDTH, initial_indent="    ", subsequent_indent="    "))
