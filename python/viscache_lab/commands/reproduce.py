"""Figures and tables of the papers."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from viscache.commands.shared import print_json
from viscache.commands.shared import size as pixels
from viscache_lab.experiment.registry import print_list


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("name", metavar="NAME|all|list")
    parser.add_argument(
        "-o",
        "--output",
        metavar="DIR",
        default="out/reproduce",
        help="where pictures and tables go (default: out/reproduce)",
    )
    parser.add_argument("--quick", action="store_true", help="small sizes")
    parser.add_argument(
        "--size", metavar="WxH", type=pixels, help="of the pictures of the figures that allow it"
    )
    parser.add_argument(
        "--older", action="store_true", help="all: take what other versions of the code left in DIR"
    )
    parser.add_argument("--json", action="store_true", help="one JSON object")


def run(arguments: argparse.Namespace) -> int:
    """Exit status 0: every band holds; 1: one does not, or a figure ended with an error."""
    from viscache_lab import figures

    if arguments.name == "list":
        return print_list(figures.FIGURES, as_json=arguments.json)
    if arguments.name == "all":
        return _all(arguments)
    result = figures.reproduce(
        arguments.name,
        arguments.output,
        quick=arguments.quick,
        progress=sys.stderr.isatty(),
        size=arguments.size,
    )
    if arguments.json:
        print_json(result)
    else:
        _print(result, arguments.output)
    return 0 if result["holds"] else 1


def _all(arguments: argparse.Namespace) -> int:
    from viscache_lab import figures

    def told(result: dict[str, Any], known: bool) -> None:
        if known:
            print(f"{result['figure']}: taken from {arguments.output}")
        else:
            _print(result, arguments.output)
        sys.stdout.flush()

    summary = figures.reproduce_all(
        arguments.output,
        quick=arguments.quick,
        size=arguments.size,
        older=arguments.older,
        progress=sys.stderr.isatty(),
        on_result=None if arguments.json else told,
    )
    if arguments.json:
        print_json(summary)
    else:
        bands = summary["bands"]
        print(f"{bands['hold']} of {bands['all']} bands hold; {len(summary['failing'])} failures:")
        for row in summary["failing"]:
            print(f"  {row['figure']}: {row['error'] if 'error' in row else _missed(row)}")
        claims = summary["claims"]
        print(
            f"the papers' claims: found in {claims['found']} figures, not found in "
            f"{claims['not_found']}, not stated in {claims['not_stated']}, "
            f"not judged by quick runs in {claims['not_judged']}"
        )
        print(summary["page"])
    return 0 if summary["holds"] else 1


def _missed(row: dict[str, Any]) -> str:
    low, high = (end if end is None else f"{end:.4g}" for end in row["band"])
    measured = "nothing" if row["measured"] is None else f"{row['measured']:.4g}"
    return f"{row['what']}: {measured} is not in {low or '-inf'} … {high or 'inf'}"


def _print(result: dict[str, Any], folder: str) -> None:
    if "error" in result:
        print(f"{result['figure']} ended with an error: {result['error']}")
        return
    print((Path(folder) / f"{result['figure']}.md").read_text("utf-8"))
    for note in result["notes"]:
        print(note)
    for left in result["skipped"]:
        print(f"skipped: {left['what']}: {left['reason']}")
