"""`viscache report DIR`."""

from __future__ import annotations

import argparse
from pathlib import Path

from viscache import report
from viscache.commands.shared import print_json


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("directory", metavar="DIR")
    parser.add_argument("-o", "--output", metavar="FILE.html", help="DIR/report.html by default")
    parser.add_argument("--json", action="store_true", help="one JSON object")


def run(arguments: argparse.Namespace) -> int:
    if not Path(arguments.directory).is_dir():
        raise ValueError(f"no such directory: {arguments.directory}")
    written = report.write(arguments.directory, arguments.output)
    if arguments.json:
        print_json({"report": str(written), "bytes": written.stat().st_size})
    else:
        print(written)
    return 0
