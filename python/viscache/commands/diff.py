"""`viscache diff A.exr REF.exr`, with `--limit "rel_l1<=0.02"` as a check."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from viscache import metrics, report
from viscache.base import tonemap
from viscache.commands.shared import print_json, print_table
from viscache.frame import Frame
from viscache.testing.limits import Limit, parsed


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("image", metavar="A.exr")
    parser.add_argument("reference", metavar="REF.exr")
    parser.add_argument("--png", metavar="FILE", help="16x signed difference around mid grey")
    parser.add_argument("--html", metavar="FILE", help="the difference viewer, one page")
    parser.add_argument(
        "--limit",
        metavar='"METRIC<=0.02"',
        action="append",
        type=_limit,
        default=[],
        help='status 1 unless it is met; repeat for more: "energy<=0.01" (both ways), "ssim>=0.98"',
    )
    parser.add_argument("--json", action="store_true", help="one JSON object")


def run(arguments: argparse.Namespace) -> int:
    """Exit status 0: all limits are met; 1: one is not."""
    image, reference = Frame.load(arguments.image), Frame.load(arguments.reference)
    result = metrics.compare(image, reference, progress=sys.stderr.isatty())
    if arguments.png is not None:
        pixels = tonemap.difference8(image.image, reference.image)
        Path(arguments.png).write_bytes(tonemap.encode(pixels))
    if arguments.html is not None:
        name, reference_name = (Path(p).name for p in (arguments.image, arguments.reference))
        report.write_difference(
            image,
            reference,
            arguments.html,
            name=name,
            reference_name=reference_name,
            width=image.size[0],
        )
    (print_json if arguments.json else print_table)(result.as_dict())
    missed = [limit for limit in arguments.limit if not limit.holds(result)]
    for limit in missed:
        told = " ".join(limit.told(result).split())
        print(f"{limit.metric} {told}", file=sys.stderr)
    return 1 if missed else 0


def _limit(text: str) -> Limit:
    try:
        return parsed(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from error
