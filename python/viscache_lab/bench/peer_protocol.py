"""The frame of the peers' processes: jobs and reports are lines of JSON, scenes are arrays."""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

Fields: TypeAlias = Mapping[str, Any]
#: A job gets the given arrays and its fields, and returns new arrays.
Job: TypeAlias = Callable[[Fields, Fields], dict[str, Any]]


def serve(about: Fields, jobs: Mapping[str, Job]) -> None:
    """Answer jobs until standard input ends; numbers are reported. Only the job itself is timed,
    and its own `wall_s` and `cpu_s` take the place of what it took in all.
    """
    folder = Path(sys.argv[1])
    given: dict[str, Any] = {}
    made: dict[str, Any] = {}
    _say({"threads": cores(), **about, "jobs": list(jobs)})
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


def _say(report: Fields) -> None:
    print(json.dumps(report), flush=True)


def cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0))


def quiet(*outputs: int) -> None:
    """Keep outputs (1, 2) for our lines; what the program prints there goes nowhere."""
    for number, name in zip(outputs, ("stdout", "stderr"), strict=False):
        setattr(sys, name, os.fdopen(os.dup(number), "w"))
        os.dup2(os.open(os.devnull, os.O_WRONLY), number)


class Pictures:
    """Frames of the triangles of a folder's `scene.npz`; other arrays give another scene."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        with np.load(folder / "scene.npz") as file:
            self.vertices, self.triangles = file["vertices"], file["triangles"]
        self._given: Any = None
        self._scene: Any = None

    def scene(self, given: Fields, fields: Fields) -> Any:
        """What `build` made of these arrays."""
        if given is not self._given:
            self._given, self._scene = given, self.build(given, fields)
        return self._scene

    def build(self, given: Fields, fields: Fields) -> Any:
        """The program's own scene; `camera` (4, 3) is origin, forward, right, up."""
        raise NotImplementedError


def z_up(rows: Any) -> Any:
    """(x, y, z) with y up as (x, -z, y) with z up."""
    return np.stack([rows[:, 0], -rows[:, 2], rows[:, 1]], axis=1)


def from_below(pixels: Any, side: int) -> Any:
    """The grey picture (side, side) of pixels whose rows go from the bottom up."""
    rows = pixels.reshape(side, side, -1)[::-1, :, :3]
    return rows.astype(np.float64).mean(axis=2)
