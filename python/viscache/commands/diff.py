"""`viscache diff A.exr REF.exr`."""

from __future__ import annotations

import argparse
from pathlib import Path

from viscache import metrics, report, tonemap
from viscache.commands.shared import print_json, print_table
from viscache.frame import Frame


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("image", metavar="A.exr")
    parser.add_argument("reference", metavar="REF.exr")
    parser.add_argument("--png", metavar="FILE", help="16x signed difference around mid grey")
    parser.add_argument("--html", metavar="FILE", help="the difference viewer, one page")
    parser.add_argument("--json", action="store_true", help="one JSON object")


def run(arguments: argparse.Namespace) -> int:
    image, reference = Frame.load(arguments.image), Frame.load(arguments.reference)
    result = metrics.compare(image, reference)
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
    return 0
