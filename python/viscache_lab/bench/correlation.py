"""`viscache bench correlation`: pairs per second, against NumPy and the machine's bound."""

from __future__ import annotations

import json
import os
import statistics
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from viscache.base import provenance
from viscache.correlation import kernels
from viscache.correlation.directions import DirectionSet
from viscache.correlation.pairs import (
    SCALE,
    PairTable,
    intersections,
    pair_statistics,
    phi,
    tile_list,
)
from viscache_lab.experiment import BENCHES, Trial
from viscache_lab.experiment.amounts import Sample, turns

Words: TypeAlias = npt.NDArray[np.uint64]
MAP_SIZE = 96
D_EDGES = np.append(np.linspace(0, 12, 128), np.inf)
THETA_EDGES_DEG = np.arange(181.0)
#: Goals: millions of pair estimates per second and core with bins, in and out of cache.
GOAL_IN, GOAL_OUT = 85.0, 80.0
#: Of the measured and + popcount + add bound, without bins.
GOAL_BOUND_IN, GOAL_BOUND_OUT = 0.95, 0.87
GOAL_NUMPY = 15.0
#: 512-bit steps of one measurement of the bound.
BOUND_STEPS = 40_000_000
#: One thread: NumPy's product must not use other cores. Only the product is timed.
NUMPY_PROGRAM = """
import json, sys, time
import numpy as np
n, t = int(sys.argv[1]), int(sys.argv[2])
random = np.random.default_rng(0)
a, b = ((random.random((n, t), dtype=np.float32) < 0.4).astype(np.float32) for _ in range(2))
wall, cpu = time.perf_counter(), time.process_time()
product = a @ b.T
wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
print(json.dumps({"wall_s": wall, "cpu_s": cpu, "total": float(product.sum(dtype=np.float64))}))
"""


@dataclass(frozen=True, kw_only=True, slots=True)
class Points:
    """Points on a bumpy ground under spheres, with their rows of bits."""

    bits: Words
    positions: npt.NDArray[np.float32]
    normals: npt.NDArray[np.float32]
    group: npt.NDArray[np.int32]


def make_points(n: int, groups: int, seed: int = 0) -> Points:
    """n points of a 10 x 10 ground of `groups` (a square) blocks. Each sees all but two spheres."""
    random = np.random.default_rng(seed)
    directions = DirectionSet(map_size=MAP_SIZE).directions
    positions = (random.random((n, 3)) * (10, 10, 0)).astype(np.float32)
    edge = int(np.sqrt(groups))
    block = np.minimum((positions[:, :2] * (edge / 10)).astype(np.int32), edge - 1)
    group = (block[:, 0] * edge + block[:, 1]).astype(np.int32)
    order = np.argsort(group, kind="stable")
    positions, group = positions[order], group[order]
    normals = np.concatenate([random.normal(0, 0.5, (n, 2)), np.ones((n, 1))], axis=1)
    normals = (normals / np.linalg.norm(normals, axis=1, keepdims=True)).astype(np.float32)
    centres = (random.random((60, 3)) * (10, 10, 2) + (0, 0, 1)).astype(np.float32)
    bits = np.empty((n, MAP_SIZE**2 // 64), np.uint64)
    for i in range(0, n, 1024):
        part = slice(i, i + 1024)
        visible = normals[part] @ directions.T > 0
        for axis, cosine in _spheres(positions[part], centres):
            visible &= axis @ directions.T < cosine[:, None]
        bits[part] = np.packbits(visible, axis=1, bitorder="little").view(np.uint64)
    return Points(bits=bits, positions=positions, normals=normals, group=group)


def _spheres(
    positions: npt.NDArray[np.float32], centres: npt.NDArray[np.float32], radius: float = 0.8
) -> list[tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]]:
    """Axes and cosines of the cones of the two spheres nearest to each point."""
    offset = centres[None] - positions[:, None]
    distance = np.linalg.norm(offset, axis=2)
    cones = []
    for k in np.argsort(distance, axis=1)[:, :2].T:
        rows = np.arange(len(positions))
        d = distance[rows, k]
        cosine = np.sqrt(1 - np.minimum(radius / d, 0.999) ** 2)
        cones.append((offset[rows, k] / d[:, None], cosine.astype(np.float32)))
    return cones


@BENCHES.add(
    "correlation",
    "pairs of rows per second and core against numpy and the machine's bound",
    note="Millions of pairs per second of processor time on one thread, 9216 directions. bound:"
    " and + popcount + add of 512 bits in registers, the same run; our carry-save adder needs"
    " five operations for two words where the bound's three do one, so it may exceed it. with"
    " bins: 128 distances x 180 angles, preparation and the table included. numpy: float32"
    " matrix product of two blocks of rows on one thread.",
)
def correlation(trial: Trial) -> None:
    """The bare kernel and the binned statistics, in and out of the CPU cache, on one thread."""
    # In cache: one pair of groups. Out of cache: the sixteen groups of one of the paper's runs
    near = make_points(1024 if trial.quick else 16_384, 1)
    far = make_points(4096 if trial.quick else 195_000, 16, seed=1)
    _check_answers(trial, far)
    _measure(trial, near, far)


def _measure(trial: Trial, near: Points, far: Points) -> None:
    quick = trial.quick
    isa = provenance.isa()[0]
    # Number of pairs, and what is timed
    runs: dict[str, tuple[int, Callable[[], Any]]] = {}
    for label, points in (("in cache", near), ("out of cache", far)):
        # A call includes packing the panels; with this many rows that costs little
        some = points.bits[: 512 if quick else 16_384 if label == "in cache" else 2048]
        tiles = _some_tiles(points, 10**6 if quick else 6 * 10**8)
        for skip in (False, True):
            words = "live words" if skip else "all words"
            kernel = partial(kernels.total_intersections, some, points.bits, 1, isa, skip)
            runs[f"kernel {label} {words}"] = len(some) * len(points.bits), kernel
            bins = partial(_statistics, points, tiles, skip)
            pairs = int(tile_list(points.group)["pairs"][tiles].sum())
            runs[f"bins {label} {words}"] = pairs, bins
    rows = 512 if quick else 4096
    runs["numpy"] = rows**2, partial(_numpy_product, rows)
    if isa == "avx512":
        bound = partial(kernels.and_popcount_add, BOUND_STEPS)
        runs["bound"] = BOUND_STEPS * 512 // MAP_SIZE**2, bound
    samples, _ = turns({name: run for name, (_, run) in runs.items()}, trial.repeats(5, 2))
    rates = {name: [runs[name][0] / s.cpu_s / 1e6 for s in samples[name]] for name in runs}
    _figures(trial, rates)


#: A figure, what it measures, its baseline, and its goal.
FIGURES = (
    ("pairs/s vs numpy", "bins in cache live words", "numpy", GOAL_NUMPY),
    ("pairs/s, all words vs numpy", "bins in cache all words", "numpy", None),
    ("pairs/s vs bound", "kernel in cache all words", "bound", GOAL_BOUND_IN),
    ("pairs/s, out of cache vs bound", "kernel out of cache all words", "bound", GOAL_BOUND_OUT),
    ("pairs/s with bins, in cache vs bound", "bins in cache all words", "bound", None),
    *(
        (
            f"pairs/s, dead words skipped, {what} vs all words",
            f"{what} live words",
            f"{what} all words",
            None,
        )
        for what in ("kernel in cache", "bins in cache", "kernel out of cache", "bins out of cache")
    ),
)


def _figures(trial: Trial, rates: dict[str, list[float]]) -> None:
    figure = partial(trial.figure, unit="Mpairs/s", clock="cpu")
    for label, goal in (("in cache", GOAL_IN), ("out of cache", GOAL_OUT)):
        mine = rates[f"bins {label} all words"]
        what, value = f"pairs/s with bins, {label} vs goal", statistics.median(mine)
        figure(what, value, baseline=goal, ratios=[rate / goal for rate in mine], goal=1.0)
    if "bound" not in rates:
        trial.skip("bound", "needs AVX-512 with VPOPCNTDQ, and VISCACHE_ISA to leave it on")
    for what, ours, theirs, least in FIGURES:
        if theirs in rates:
            ratios = [a / b for a, b in zip(rates[ours], rates[theirs], strict=True)]
            value, base = (statistics.median(rates[k]) for k in (ours, theirs))
            figure(what, value, baseline=base, ratios=ratios, goal=least)


def _statistics(points: Points, tiles: npt.NDArray[np.int64] | None, skip_dead: bool) -> PairTable:
    rows = (points.bits, MAP_SIZE**2, points.positions, points.normals, points.group)
    edges = (D_EDGES, THETA_EDGES_DEG)
    return pair_statistics(*rows, *edges, tiles=tiles, threads=1, skip_dead=skip_dead)


def _some_tiles(points: Points, n_pairs: int) -> npt.NDArray[np.int64]:
    """The first tiles; all tiles if they contain fewer pairs than requested."""
    tiles = tile_list(points.group)["pairs"]
    return np.arange(1 + int(np.searchsorted(np.cumsum(tiles), min(n_pairs, tiles.sum() - 1))))


def _numpy_product(n: int) -> Sample:
    threads = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS", "BLIS_NUM_THREADS")
    done = subprocess.run(
        [sys.executable, "-c", NUMPY_PROGRAM, str(n), str(MAP_SIZE**2)],
        env={**os.environ, **dict.fromkeys(threads, "1")},
        capture_output=True,
        text=True,
        check=True,
    )
    report = json.loads(done.stdout)
    return Sample(wall_s=report["wall_s"], cpu_s=report["cpu_s"])


def _check_answers(trial: Trial, points: Points) -> None:
    """Compare counts, ρ and sums of a subset with brute force in NumPy."""
    rows = np.random.default_rng(0).choice(len(points.bits), 600, replace=False)
    bits = points.bits[rows]
    seen = np.unpackbits(bits.view(np.uint8), axis=1, bitorder="little").astype(np.float64)
    found = intersections(bits, bits)
    trial.check("n11 unlike numpy's", float(abs(found - seen @ seen.T).max()), 0)
    rho = phi(bits, bits, MAP_SIZE**2)
    expected = np.asarray(np.corrcoef(seen))
    trial.check("rho unlike numpy's", float(np.nanmax(abs(rho - expected))), 1e-6)
    total = kernels.total_intersections(points.bits, bits)
    columns = [_columns(points.bits), _columns(bits)]
    trial.check("total of n11 unlike numpy's", float(total != int(columns[0] @ columns[1])), 0)

    subset = Points(
        bits=bits,
        positions=points.positions[rows],
        normals=points.normals[rows],
        group=np.zeros(len(rows), np.int32),
    )
    tables = [_statistics(subset, None, skip) for skip in (False, True)]
    i, j = np.triu_indices(len(rows), 1)
    d = np.linalg.norm(subset.positions[i] - subset.positions[j], axis=1)
    # Rounding may move a pair at an edge to either side: count by distance alone
    counts = np.histogram(d, np.append(D_EDGES[:-1], 1e9))[0]
    missed = abs(tables[0].n.sum(axis=(0, 2)) - counts).sum()
    trial.check("pairs in other bins of distance", float(missed), 4)
    mean = tables[0].sum_q.sum() / SCALE / len(i)
    trial.check("mean rho unlike numpy's", float(abs(mean - expected[i, j].mean())), 1e-6)
    unlike = [(getattr(tables[0], k) != getattr(tables[1], k)).sum() for k in ("n", "sum_q")]
    trial.check("sums that skipping dead words changes", float(sum(unlike)), 0)


def _columns(bits: Words) -> npt.NDArray[np.int64]:
    """How many rows see each direction."""
    total = np.zeros(64 * bits.shape[1], np.int64)
    for i in range(0, len(bits), 4096):
        part = np.ascontiguousarray(bits[i : i + 4096]).view(np.uint8)
        total += np.unpackbits(part, axis=1, bitorder="little").sum(axis=0, dtype=np.int64)
    return total
