"""Versions, a self-test, and numerical extremes."""

from __future__ import annotations

import argparse
import json
import os
import sys
from pathlib import Path
from typing import Any

from viscache.base import provenance
from viscache.base.files import finite
from viscache.commands.shared import print_json
from viscache_lab import extremes
from viscache_lab.commands.self_test import checks
from viscache_lab.extremes.compare import differences


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--json", action="store_true", help="one JSON object")
    parser.add_argument(
        "--extremes",
        action="store_true",
        help="also check numerical extremes: under three minutes on two cores",
    )
    parser.add_argument(
        "--full", action="store_true", help="--extremes with more cases, on every instruction set"
    )
    parser.add_argument(
        "--only",
        action="append",
        metavar="FAMILY",
        help="of --extremes, this family of checks; may be repeated",
    )
    parser.add_argument(
        "--compare",
        nargs=2,
        metavar=("A.json", "B.json"),
        help="compare two outputs of --json instead",
    )


def run(arguments: argparse.Namespace) -> int:
    """Exit status 0: every check holds; 1: one does not, or it holds in one report alone."""
    if arguments.compare:
        return _compare(*arguments.compare, as_json=arguments.json)
    active, best = provenance.isa()
    made = provenance.provenance()
    report: dict[str, Any] = {
        "versions": {name: made[name] for name in ("viscache", "numpy", "python", "embree")},
        "isa": {"active": active, "best": best, "asked": os.environ.get("VISCACHE_ISA")},
        "cpu": provenance.cpu_model(),
        "threads": made["threads"],
    }
    if not arguments.json:
        _print_versions(report)
    told = _progress if arguments.json else _print_check
    found = checks(active, best)
    for check in found:
        told(check)
    if arguments.extremes or arguments.full or arguments.only:
        found += extremes.run(arguments.only, full=arguments.full, told=told)
    report["checks"] = [check.as_dict() for check in found]
    report["ok"] = all(check.holds for check in found)
    if arguments.json:
        print_json(report)
    else:
        failed = sum(not check.holds for check in found)
        print(
            f"{len(found)} checks, {failed} failed" if failed else f"all {len(found)} checks hold"
        )
    return 0 if report["ok"] else 1


def _print_versions(report: dict[str, Any]) -> None:
    for name, version in report["versions"].items():
        print(f"{name} {version}")
    print(f"kernels {report['isa']['active']} (best here: {report['isa']['best']})")
    print(f"{report['cpu']}, {report['threads']} thread(s)")


def _print_check(check: extremes.Check) -> None:
    print(check.line(), flush=True)


def _progress(check: extremes.Check) -> None:
    """Standard output is for the JSON alone."""
    if sys.stderr.isatty() or not check.holds:
        print(check.line(), file=sys.stderr)


def _compare(first: str, second: str, *, as_json: bool) -> int:
    """Exit status 1 where a check holds in one report alone."""
    reports = [_read(first), _read(second)]
    found = differences(*reports)
    if as_json:
        keys = ("name", "what", "a", "b")
        print_json({"differences": [dict(zip(keys, d, strict=True)) for d in found]})
    else:
        for path, report in zip((first, second), reports, strict=True):
            print(f"{path}: {report['cpu']}, {report['isa']['active']}, Embree "
                  f"{report['versions']['embree']}, {len(report['checks'])} checks")  # fmt: skip
        for name, what, a, b in found:
            print(f"{name}: {what} {finite(a)} and {finite(b)}")
        print(f"{len(found)} differences")
    return 1 if any(what == "holds" for _, what, _, _ in found) else 0


def _read(path: str) -> dict[str, Any]:
    try:
        report: dict[str, Any] = json.loads(Path(path).read_text("utf-8"))
        names = [check["name"] for check in report["checks"]]
    except (json.JSONDecodeError, UnicodeDecodeError, KeyError, TypeError) as error:
        raise ValueError(f"{path}: must be an output of viscache doctor --json: {error}") from None
    assert names is not None
    return report
