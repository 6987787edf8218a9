"""`viscache reproduce NAME|all|list`: figures and tables of the papers."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from viscache.commands.shared import print_json
from viscache.commands.shared import size as pixels


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("name", metavar="NAME|all|list")
    parser.add_argument("-o", "--output", metavar="DIR", default="out/reproduce",
                        help="where pictures and tables go (default: out/reproduce)")  # fmt: skip
    parser.add_argument("--quick", action="store_true", help="small sizes")
    parser.add_argument("--size", metavar="WxH", type=pixels,
                        help="of the pictures of the figures that allow it")  # fmt: skip
    parser.add_argument("--json", action="store_true", help="one JSON object")


def run(arguments: argparse.Namespace) -> int:
    """Exit status 0: every band holds; 1: one does not."""
    from viscache import figures

    if arguments.name == "list":
        return _list(arguments.json)
    there = [name for name, info in figures.FIGURES.items() if info.is_there]
    results = []
    everything = arguments.name == "all"
    for name in there if everything else [arguments.name]:
        size = arguments.size if not everything or figures.FIGURES[name].sized else None
        results.append(figures.reproduce(name, arguments.output, quick=arguments.quick,
                                         progress=sys.stderr.isatty(), size=size))  # fmt: skip
        if not arguments.json:
            print((Path(arguments.output) / f"{name}.md").read_text("utf-8"))
            for left in results[-1]["skipped"]:
                print(f"skipped: {left['what']}: {left['reason']}")
    if arguments.json:
        print_json(results[0] if arguments.name != "all" else {"figures": results})
    return 0 if all(result["holds"] for result in results) else 1


def _list(as_json: bool) -> int:
    from viscache.figures import FIGURES

    if as_json:
        rows = [{"figure": name, "available": info.is_there} for name, info in FIGURES.items()]
        print_json({"figures": rows})
        return 0
    for name, info in FIGURES.items():
        print(name if info.is_there else f"{name}: not there yet", f"({info.description})")
    return 0
