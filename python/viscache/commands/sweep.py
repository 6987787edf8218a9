"""`viscache sweep FILE.toml -o DIR`."""

from __future__ import annotations

import argparse
import importlib
import sys
from concurrent.futures import Executor
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

from viscache.commands.shared import at_least_one, print_json, worker_pool
from viscache.sweep import SweepFile


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("file", metavar="FILE.toml")
    parser.add_argument("-o", "--output", metavar="DIR", required=True)
    parser.add_argument("--workers", type=at_least_one, default=1, metavar="N",
                        help="processes; they disturb each other's timings")  # fmt: skip
    parser.add_argument("--dask", metavar="ADDRESS", help="a dask scheduler instead")
    parser.add_argument("--json", action="store_true", help="one JSON object")


def run(arguments: argparse.Namespace) -> int:
    sweep = SweepFile.load(arguments.file)
    with _executor(arguments) as executor:
        dataset = sweep.run(arguments.output, executor=executor, progress=True)
    table = Path(arguments.output) / "table.csv"
    if arguments.json:
        sizes = {str(k): v for k, v in dataset.sizes.items()}
        print_json({"directory": arguments.output, "table": str(table), "sizes": sizes})
    else:
        print(f"{table}\nviscache report {arguments.output} writes the report", file=sys.stdout)
    return 0


def _executor(arguments: argparse.Namespace) -> AbstractContextManager[Executor | None]:
    if arguments.dask is not None:
        try:
            distributed: Any = importlib.import_module("dask.distributed")
        except ImportError as error:
            raise ValueError(
                "--dask needs dask.distributed: pip install 'viscache[distributed]'"
            ) from error
        executor: AbstractContextManager[Executor] = distributed.Client(
            arguments.dask
        ).get_executor()
        return executor
    return worker_pool(arguments.workers)
