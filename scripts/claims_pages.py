#!/usr/bin/env python3
"""Writes the tables of full runs into the documentation.

`scripts/claims_pages.py out/reproduce --machine C` first takes the results in that folder, which
come from `viscache reproduce`; figures that are not in it keep their last run.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from pathlib import Path

from viscache_lab.experiment.full_run import FILE, RUNS, kept, written
from viscache_lab.figures import FIGURES

ROOT = Path(__file__).resolve().parents[1]


def take(folder: Path, machine: str) -> None:
    """Put the results of a folder into the file of full runs."""
    files = {name: folder / f"{name}.json" for name in FIGURES}
    found = {n: json.loads(file.read_text("utf-8")) for n, file in files.items() if file.exists()}
    runs = RUNS | {name: kept(result, machine) for name, result in found.items()}
    FILE.write_text(written({name: runs[name] for name in FIGURES if name in runs}), "utf-8")


def fill() -> None:
    """Write the tables of `FILE` into the pages."""
    from viscache_lab.experiment.claims_pages import PAGES, filled

    for page in PAGES:
        path = ROOT / page
        path.write_text(filled(page, path.read_text("utf-8")), "utf-8")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", nargs="?", type=Path, help="of `viscache reproduce -o`")
    parser.add_argument("--machine", help="its name in docs/performance/method.md")
    given = parser.parse_args()
    if given.folder is None:
        fill()
    elif given.machine is None:
        parser.error("--machine must name the machine of the run")
    else:
        take(given.folder, given.machine)
        subprocess.run([sys.executable, __file__], check=True)  # the pages read the new file
