#!/usr/bin/env python3
"""Statistics and pictures of scenes: scripts/correlation.py SCENE ... [-o DIR] [-- OPTIONS]
OPTIONS are those of `viscache correlate`; the paper's scale is --points 195000."""

from __future__ import annotations

import argparse
import re
import sys

from viscache.cli import main


def run(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenes", nargs="+", metavar="SCENE")
    parser.add_argument("-o", "--output", default="out/correlation", metavar="DIR")
    end = arguments.index("--") if "--" in arguments else len(arguments)
    chosen = parser.parse_args(arguments[:end])
    for scene in chosen.scenes:
        folder = f"{chosen.output}/{re.sub(r'[^A-Za-z0-9]+', '-', scene).strip('-')}"
        words = ["correlate", scene, "-o", f"{folder}/statistics.nc", "--plot", folder]
        if status := main([*words, *arguments[end + 1 :]]):
            return status
    return 0


if __name__ == "__main__":
    sys.exit(run(sys.argv[1:]))
