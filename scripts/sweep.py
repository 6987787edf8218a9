#!/usr/bin/env python3
"""Run or resume a ready sweep and write its report: scripts/sweep.py c_e [DIRECTORY]."""

from __future__ import annotations

import sys
from pathlib import Path

from viscache.cli import main

SWEEPS = Path(__file__).parent / "sweeps"


def run(arguments: list[str]) -> int:
    ready = sorted(path.stem for path in SWEEPS.glob("*.toml"))
    if not arguments or arguments[0] not in ready:
        print(
            f"usage: scripts/sweep.py NAME [DIRECTORY]; NAME: {', '.join(ready)}", file=sys.stderr
        )
        return 2
    directory = arguments[1] if len(arguments) > 1 else f"out/sweeps/{arguments[0]}"
    status = main(["sweep", str(SWEEPS / f"{arguments[0]}.toml"), "-o", directory])
    return status or main(["report", directory])


if __name__ == "__main__":
    sys.exit(run(sys.argv[1:]))
