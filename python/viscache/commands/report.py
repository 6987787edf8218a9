"""`viscache report DIR`."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from viscache import plots, report
from viscache.commands.shared import print_json
from viscache.report.pictures import MAX_WIDTH_PX
from viscache.sweeps.store import Store
from viscache.sweeps.table import open_dataset

MOST_NAMED = 5  # names shown of the files in a directory without a sweep


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("directory", metavar="DIR")
    parser.add_argument("-o", "--output", metavar="FILE.html", help="DIR/report.html by default")
    parser.add_argument(
        "--error", metavar="METRIC", help="of the plots: rel_l1_reflected; the sweep's first metric"
    )
    parser.add_argument(
        "--target",
        type=float,
        metavar="E",
        help="the wanted error, as 0.02: the verdict begins with it, and the page shows the"
        " cheapest setting of at most this error (1 %%, and the knee of the front)",
    )
    parser.add_argument(
        "--flip-maps",
        type=int,
        default=report.MOST_FLIP_MAPS,
        metavar="N",
        help="most FLIP maps, which take seconds each; the best settings first (%(default)s)",
    )
    parser.add_argument(
        "--width",
        type=int,
        default=MAX_WIDTH_PX,
        metavar="PX",
        help="widest picture; wider frames are shown as means over pixels (%(default)s)",
    )
    parser.add_argument(
        "--plots", metavar="FOLDER", help="write the plots there too, each as a file for papers"
    )
    parser.add_argument(
        "--format", action="append", choices=plots.FORMATS, help="of --plots; repeat for more (all)"
    )
    parser.add_argument("--json", action="store_true", help="one JSON object")


def run(arguments: argparse.Namespace) -> int:
    if arguments.format and arguments.plots is None:
        raise ValueError("--format must come with --plots FOLDER")
    _check_holds_a_sweep(Path(arguments.directory))
    written = report.write(
        arguments.directory,
        arguments.output,
        error=arguments.error,
        target=arguments.target,
        flip_maps=arguments.flip_maps,
        width=arguments.width,
        progress=sys.stderr.isatty(),
    )
    drawn: list[Path] = []
    if arguments.plots is not None:
        formats = arguments.format or plots.FORMATS
        dataset = open_dataset(arguments.directory)
        drawn = plots.save_all(dataset, arguments.plots, formats, error=arguments.error)
    if arguments.json:
        found = {"report": str(written), "bytes": written.stat().st_size}
        print_json(found | ({"plots": [str(p) for p in drawn]} if drawn else {}))
    else:
        print(written, *drawn, sep="\n")
    return 0


def _check_holds_a_sweep(directory: Path) -> None:
    """Raises an error unless DIR contains a sweep; the message says what it contains instead."""
    if not directory.exists():
        raise ValueError(f"no such directory: {directory}")
    must = "DIR must be a directory that `viscache sweep FILE.toml -o DIR` filled"
    if not directory.is_dir():
        raise ValueError(f"{must}, got the file {directory}")
    if not Store.exists(directory):
        names = sorted(p.name for p in directory.iterdir())
        more = f" and {len(names) - MOST_NAMED} more" if len(names) > MOST_NAMED else ""
        held = ", ".join(names[:MOST_NAMED]) + more or "nothing"
        raise ValueError(f"{must}, got {directory}: it has no sweep.sqlite and holds {held}")
