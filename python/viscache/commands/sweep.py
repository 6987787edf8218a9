"""`viscache sweep FILE.toml -o DIR`."""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace
from pathlib import Path

from viscache.commands.shared import (
    add_loading,
    add_workers,
    chosen_executor,
    print_json,
    threads_of_a_worker,
)
from viscache.sweeps.sweep import SweepFile


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("file", metavar="FILE.toml")
    parser.add_argument("-o", "--output", metavar="DIR", required=True)
    add_loading(parser)
    add_workers(parser)
    parser.add_argument(
        "--apart",
        action=argparse.BooleanOptionalAction,
        default=None,
        help="one frame at a time, so that timings are undisturbed (the default"
        " without --workers and --dask)",
    )
    parser.add_argument(
        "--references", metavar="DIR", help="where sweeps share their finished references"
    )
    parser.add_argument("--json", action="store_true", help="one JSON object")


def run(arguments: argparse.Namespace) -> int:
    sweep = SweepFile.load(arguments.file)
    # A switch of the command and a key of the file do the same
    if arguments.missing == "skip":
        sweep = replace(sweep, missing="skip")
    if arguments.allow_outside:
        sweep = replace(sweep, allow_outside=True)
    if sweep.threads is None:
        sweep = replace(sweep, threads=threads_of_a_worker(arguments))
    with chosen_executor(arguments) as executor:
        dataset = sweep.run(
            arguments.output,
            executor=executor,
            apart=arguments.apart,
            references=arguments.references,
            progress=True,
        )
    if "mended" in dataset.attrs:
        print(dataset.attrs["mended"], file=sys.stderr)
    table = Path(arguments.output) / "table.csv"
    if arguments.json:
        sizes = {str(k): v for k, v in dataset.sizes.items()}
        print_json({"directory": arguments.output, "table": str(table), "sizes": sizes})
    else:
        print(f"{table}\nviscache report {arguments.output} writes the report", file=sys.stdout)
    return 0
