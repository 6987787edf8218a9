"""`viscache bench NAME|all|list`: the benchmarks of `viscache.bench`."""

from __future__ import annotations

import argparse
import importlib
from collections.abc import Callable
from typing import Any

from viscache.commands.shared import print_json
from viscache.settings import NotThereYetError, nearest

#: Every benchmark the interface names, whether it is there yet or not.
NAMES = (
    "rays",
    "correlation",
    "aqvc-frame",
    "aqvc-lookup",
    "vlf-build",
    "vlf-ao",
    "vismap-variance",
    "sweep",
    "peers",
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("name", metavar="NAME|all|list")
    parser.add_argument("--quick", action="store_true", help="small sizes, few repeats")
    parser.add_argument("--json", action="store_true", help="one JSON object")


def registry() -> dict[str, Callable[..., dict[str, Any]]]:
    """The benchmarks that are there: name → function(quick=...) → what `bench --json` prints."""
    try:
        module: Any = importlib.import_module("viscache.bench")
    except ModuleNotFoundError as error:
        if error.name != "viscache.bench":
            raise
        return {}
    return dict(module.registry)


def run(arguments: argparse.Namespace) -> int:
    there = registry()
    known = list(dict.fromkeys([*NAMES, *there]))
    if arguments.name == "list":
        if arguments.json:
            print_json({"benches": [{"bench": n, "available": n in there} for n in known]})
        else:
            for name in known:
                print(name if name in there else f"{name}: not there yet")
        return 0
    if arguments.name != "all" and arguments.name not in known:
        raise ValueError(f"unknown bench {arguments.name!r}{nearest(arguments.name, known)}")
    names = list(there) if arguments.name == "all" else [arguments.name]
    if not names or names[0] not in there:
        raise NotThereYetError(
            f"bench {arguments.name} is not there yet in this version of viscache"
        )
    results = [there[name](quick=arguments.quick) for name in names]
    if arguments.json:
        print_json(results[0] if arguments.name != "all" else {"benches": results})
    else:
        for result in results:
            _print(result)
    return 0 if all(r["answers_checked"] for r in results) else 1


def _print(result: dict[str, Any]) -> None:
    print(f"{result['bench']} on {result['machine']}")
    for f in result["figures"]:
        goal = "" if f.get("goal") is None else f", goal {f['goal']}: {_holds(f.get('holds'))}"
        error = "" if f.get("rel_l1") is None else f", rel_l1 {f['rel_l1']:.4g}"
        spread = "" if f.get("low") is None else f" [{f['low']:.3g}, {f['high']:.3g}]"
        print(f"  {f['name']}: {f['value']:.4g} {f['unit']}, {f['ratio']:.3g}x{spread}"
              f" of {f['baseline']}{error}{goal}")  # fmt: skip
    print("  answers checked" if result["answers_checked"] else "  AN ANSWER IS WRONG")


def _holds(value: bool | None) -> str:
    return "not judged" if value is None else "holds" if value else "missed"
