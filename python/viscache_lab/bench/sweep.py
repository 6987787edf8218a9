"""Sweeps: the time outside frames and metrics, and the costs of a kill and of dask."""

from __future__ import annotations

import importlib.util
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import viscache as vc
from viscache.base.workers import process_pool
from viscache.sweeps.store import Store
from viscache_lab.experiment import BENCHES, Trial
from viscache_lab.experiment.amounts import Sample, interleave

SCENE = "room?triangles=200000"
QUICK_SCENE = "room?triangles=3000"
#: Share of the wall time outside frames and metrics.
OUTSIDE_AT_MOST = 0.05
SECONDS_AT_MOST = 900.0
DASK_AT_MOST = 1.10

#: A sweep that logs each frame it starts. Arguments: directory, log, scene, points, pixels, VPLs.
LOGGED = """
import os, sys
import viscache as vc
from viscache.sweeps import work

directory, path, scene, points, edge, vpls = sys.argv[1], sys.argv[2], sys.argv[3], *map(
    int, sys.argv[4:])
log = os.open(path, os.O_WRONLY | os.O_APPEND | os.O_CREAT)

def render(**shot):
    os.write(log, b"begin\\n")
    return vc.render(**shot)

work.render_function = render
vc.sweep(scene, vc.Whitted(n_vpls=vpls), over={"c_e": {"log": [2, 32], "n": points}},
         size=(edge, edge), metrics=["rel_l1"], directory=directory)
"""


@BENCHES.add("sweep", "500 points of a sweep: time outside frames and metrics, kills, dask")
def sweep(trial: Trial) -> None:
    """500 points at 256² of the room; a killed and resumed sweep; dask against processes."""
    with tempfile.TemporaryDirectory() as folder:
        _large(trial.quick, Path(folder) / "large", trial)
        _killed(trial.quick, Path(folder) / "killed", trial)
        _distributed(trial.quick, trial)


def _large(quick: bool, folder: Path, trial: Trial) -> None:
    """Many points in this process, on all cores; frames are stored."""
    n, edge, vpls = (12, 64, 32) if quick else (125, 256, 256)
    over = {"c_e": {"log": [2, 32], "n": n}, "c_z": [1, 2, 4, 8]}
    began, cpu = time.perf_counter(), time.process_time()
    ds = vc.sweep(
        QUICK_SCENE if quick else SCENE,
        vc.Whitted(n_vpls=vpls),
        over=over,
        size=(edge, edge),
        directory=folder,
    )
    wall, cpu = time.perf_counter() - began, time.process_time() - cpu
    spent = json.loads(ds.attrs["seconds"])
    outside = 1 - (spent["frames"] + spent["metrics"]) / wall
    points = int(ds.rel_l1.notnull().sum())
    trial.check("points that are missing", 4 * n - points, 0)
    falls = float(ds.rel_l1[0].mean() >= ds.rel_l1[-1].mean())
    trial.check("errors that do not grow from the finest to the coarsest C_E", falls, 0)
    limit = None if quick else SECONDS_AT_MOST
    trial.at_most(f"{points} points at {edge}²", wall, "s", limit, cpu_s=cpu)
    trial.at_most(
        f"{points} points: share of the wall time outside frames and metrics",
        outside,
        "1",
        None if quick else OUTSIDE_AT_MOST,
        **spent,
    )


def _killed(quick: bool, folder: Path, trial: Trial) -> None:
    """Kill a sweep repeatedly (kill -9); count the frames rendered twice per kill."""
    points, edge, vpls, kills = (16, 64, 32, 2) if quick else (60, 128, 128, 5)
    log = folder.with_suffix(".log")
    words = [str(folder), str(log), QUICK_SCENE, str(points), str(edge), str(vpls)]
    for _ in range(kills):
        process = _start(words)
        before = _begun(log)
        while _begun(log) < before + points // (kills + 2) and process.poll() is None:
            time.sleep(0.002)
        process.send_signal(signal.SIGKILL)
        process.wait()
    trial.check("exit status of the last run", abs(_start(words).wait()), 0)
    frames = points + 1
    with Store(folder) as store:
        trial.check("frames that are missing", frames - len(store.finished()), 0)
    repeated = _begun(log) - frames
    trial.check("frames rendered twice, at most one per kill", repeated, kills)
    what = f"{frames} frames and {kills} kills: frames rendered"
    trial.at_most(what, frames + repeated, "frames", frames + kills)


def _start(words: list[str]) -> subprocess.Popen[bytes]:
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(p for p in sys.path if p)}
    return subprocess.Popen([sys.executable, "-c", LOGGED, *words], env=environment)


def _begun(log: Path) -> int:
    return log.read_bytes().count(b"begin") if log.exists() else 0


def _distributed(quick: bool, trial: Trial) -> None:
    """The same points with two dask workers and with a pool of two processes, in turns."""
    if importlib.util.find_spec("distributed") is None:
        trial.skip("dask beside processes", "dask.distributed is not installed")
        return
    points, edge, vpls, turns = (4, 64, 32, 2) if quick else (50, 256, 256, 4)
    scene = QUICK_SCENE if quick else SCENE

    def points_of(executor: Executor, n: int) -> Sample:
        over = {"c_e": {"log": [2, 32], "n": n}}
        folder = tempfile.mkdtemp()
        began = time.perf_counter()
        ds = vc.sweep(
            scene,
            vc.Whitted(n_vpls=vpls),
            over=over,
            size=(edge, edge),
            threads=1,
            metrics=["rel_l1"],
            executor=executor,
            directory=folder,
        )
        wall = time.perf_counter() - began
        shutil.rmtree(folder)
        errors.append(ds.rel_l1.values.tobytes() if n == points else b"")
        return Sample(wall_s=wall, cpu_s=float(ds.cpu_s.sum()))

    errors: list[bytes] = []
    with process_pool(2) as pool, _dask_workers(2) as dask:
        assert pool is not None
        for executor in (pool, dask):  # both workers of each executor load the scene
            points_of(executor, 8)
        runs: dict[str, Callable[[], Sample]] = {
            "pool": lambda: points_of(pool, points),
            "dask": lambda: points_of(dask, points),
        }
        samples = interleave(runs, turns, warm_up=False)
    trial.check("tables that differ", len({e for e in errors if e}) - 1, 0)
    ratios = [p.wall_s / d.wall_s for d, p in zip(samples["dask"], samples["pool"], strict=True)]
    total = {name: sum(s.wall_s for s in taken) for name, taken in samples.items()}
    trial.figure(
        f"{turns * points} points, two dask workers vs a pool of two processes",
        total["dask"],
        "s",
        baseline=total["pool"],
        ratios=ratios,
        goal=None if quick else 1 / DASK_AT_MOST,
    )


@contextmanager
def _dask_workers(n: int) -> Iterator[Any]:
    """A scheduler and n worker processes on this machine."""
    distributed = importlib.import_module("distributed")
    cluster = distributed.LocalCluster(
        n_workers=n, threads_per_worker=1, processes=True, dashboard_address=None, host="127.0.0.1"
    )
    with cluster, distributed.Client(cluster, set_as_default=False) as client:
        yield client.get_executor(pure=False)
