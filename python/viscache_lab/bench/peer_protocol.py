"""The protocol of the peers' processes: jobs and reports are lines of JSON."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

#: A job gets the given arrays and its fields, and returns new arrays.
Job: TypeAlias = Callable[[Mapping[str, Any], Mapping[str, Any]], dict[str, Any]]


def serve(about: Mapping[str, Any], jobs: Mapping[str, Job]) -> None:
    """Answer jobs until standard input ends. Only the job itself is timed.

    A job's numbers are in its report. Its own `wall_s` and `cpu_s` take the place of what it took
    in all.
    """
    folder = Path(sys.argv[1])
    given: dict[str, Any] = {}
    made: dict[str, Any] = {}
    _say({**about, "jobs": list(jobs)})
    for line in sys.stdin:
        fields = json.loads(line)
        wall, cpu = time.perf_counter(), time.process_time()
        if fields["job"] == "load":
            with np.load(folder / "input.npz") as file:
                given = dict(file)
        elif fields["job"] == "save":
            np.savez(folder / "output.npz", **made)
        else:
            made = jobs[fields["job"]](given, fields)
        seconds = {"wall_s": time.perf_counter() - wall, "cpu_s": time.process_time() - cpu}
        _say(seconds | {k: float(v) for k, v in made.items() if np.ndim(v) == 0})


def _say(report: Mapping[str, Any]) -> None:
    print(json.dumps(report), flush=True)
