#!/usr/bin/env python3
"""Prices of the engines for aligned rays: scripts/aligned_costs.py [-o FILE] [--again FILE]
Measures both engines in the scenes of scripts/engine_choice.py, fits the prices of
vlf/engine_choice.cpp to one half of the scenes and tests the choice on the other half."""

from __future__ import annotations

import argparse
import json
import math
import statistics
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from engine_choice import DISTANCES, FITTED, HELD_OUT, eye_points, rays_of
from scipy.optimize import nnls

from viscache import _core
from viscache.scene import Scene
from viscache_lab.experiment.amounts import Sample, interleave, timed
from viscache_lab.experiment.trial import opened

#: Sizes, directions, and how many of the directions are traced.
PICTURES = (
    ((160, 100), 33, 33),
    ((160, 100), 513, 65),
    ((320, 200), 513, 33),
    ((640, 400), 33, 17),
    ((1024, 1024), 33, 5),
)
SPARSE, HOPELESS, HOPELESS_IF_SHORT = 8, 40, 12  # triangles per point, as in vlf/engine_choice.cpp
WORK = ("blocks", "nodes", "pairs", "tests", "exact")  # the batch's prices, after that of a ray

Row = dict[str, Any]
Array = npt.NDArray[np.float64]


def measured(spec: str) -> Iterator[Row]:
    """Nanoseconds per ray of both engines, and the batch's work, for every case of a scene."""
    scene = opened(spec)
    if scene is None:
        return
    batch = scene.aligned_batch()
    for size, n_directions, n_traced in PICTURES:
        points = eye_points(scene, size)
        order = _core.vlf.point_order(points[0])
        n_points, n_rays = len(order), len(order) * n_traced
        frames = _core.vlf.direction_frames(n_directions)
        some = np.linspace(0, len(frames) - 1, n_traced).astype(int)
        traced = np.ascontiguousarray(frames[some])
        for distance in DISTANCES:
            options: dict[str, Any] = {
                "t_max": rays_of(scene, distance),
                "order": order,
                "threads": 1,
            }
            by_axis = scene.triangles // SPARSE <= n_points
            samples, (bits, counts) = both(scene, points, traced, by_axis, options)
            ns = {
                k: 1e9 * statistics.median(s.cpu_s for s in v) / n_rays for k, v in samples.items()
            }
            yield {
                "scene": spec,
                "size": size,
                "n_directions": n_directions,
                "distance": distance,
                "points": n_points,
                "triangles": scene.triangles,
                "triangles_per_point": scene.triangles / n_points,
                "by_axis": by_axis,
                "batch_ns": ns["batch"],
                "embree_ns": ns["embree"],
                "work": {name: count / n_rays for name, count in counts.items()},
                "free": int(np.bitwise_count(bits).sum()) / n_rays,
                "sample": batch.sample(scene._core, *points, frames, **options),
            }


def both(
    scene: Scene,
    points: tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]],
    frames: npt.NDArray[np.float32],
    by_axis: bool,
    options: dict[str, Any],
) -> tuple[dict[str, list[Sample]], Any]:
    """Samples of both engines in turns, and the batch's bits and work."""
    batch, caster = scene.aligned_batch(), scene.caster()
    found: list[Any] = []

    def by_batch() -> Sample:
        time, rows = timed(lambda: batch.rows(scene._core, *points, frames, **options))
        found.append(rows)
        return time

    def by_embree() -> Sample:
        embree = _core.vlf.embree_rows
        return timed(lambda: embree(caster, *points, frames, by_axis=by_axis, **options))[0]

    samples = interleave({"batch": by_batch, "embree": by_embree}, 3, warm_up=False)
    return samples, found[-1]


def batch_terms(row: Row) -> list[float]:
    return [1, *(row["work"][name] for name in WORK)]


def embree_terms(row: Row) -> list[float]:
    w, reach = row["work"], min(1.0, row["distance"]) ** 0.25
    free_length, narrow = row["free"] * reach, w["tests"] - w["wide"]
    if not row["by_axis"]:
        tests = w["tests"]
        return [1, tests, tests * free_length, w["exact"], w["pairs"] * reach]
    return [1, narrow, w["wide"], narrow * free_length, w["wide"] * free_length, w["exact"]]


def is_hopeless(row: Row) -> bool:
    limit = HOPELESS_IF_SHORT if row["distance"] < 0.5 else HOPELESS
    return bool(row["triangles_per_point"] > limit)


def fitted(terms: list[list[float]], ns: list[float]) -> tuple[Array, float]:
    """Prices >= 0 that minimize the relative error, and the relative spread that is left."""
    x, y = np.array(terms), np.array(ns)
    prices, _ = nnls(x / y[:, None], np.ones(len(y)))
    return prices, float(np.exp(np.std(np.log(x @ prices / y))))


def report(rows: list[Row], share: float) -> None:
    """Print the prices, and the choice with them on both halves."""
    train = [r for r in rows if r["scene"] in FITTED]
    prices, spread = fitted([batch_terms(r) for r in train], [r["batch_ns"] for r in train])
    print("batch", prices.round(1), f"spread {spread:.2f}")
    embree: dict[bool, Array] = {}
    for by_axis in (True, False):
        some = [r for r in train if r["by_axis"] == by_axis and not is_hopeless(r)]
        embree[by_axis], spread = fitted(
            [embree_terms(r) for r in some], [r["embree_ns"] for r in some]
        )
        print("embree", "by axis" if by_axis else "by point", embree[by_axis].round(1), spread)
    for name, scenes in (("fitted", FITTED), ("held out", HELD_OUT)):
        some = [r for r in rows if r["scene"] in scenes]
        gains = []
        for r in some:
            batch = prices @ np.array(batch_terms(r))
            chosen = not is_hopeless(r) and batch < share * (
                embree[r["by_axis"]] @ np.array(embree_terms(r))
            )
            gains.append(r["embree_ns"] / r["batch_ns"] if chosen else 1.0)
        best = [max(1.0, r["embree_ns"] / r["batch_ns"]) for r in some]
        mean = math.exp(statistics.fmean(math.log(g) for g in gains))
        at_best = math.exp(statistics.fmean(math.log(g) for g in best))
        print(
            f"{name}: {len(some)} cases, worst {min(gains):.2f}, mean {mean:.2f} of {at_best:.2f}"
        )


def run(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--output", default="out/aligned-costs.jsonl", metavar="FILE")
    parser.add_argument("--again", metavar="FILE", help="fit what was measured before")
    parser.add_argument(
        "--share", type=float, default=0.75, help="the batch must cost less than this"
    )
    chosen = parser.parse_args(arguments)
    if chosen.again is None:
        Path(chosen.output).parent.mkdir(parents=True, exist_ok=True)
        with Path(chosen.output).open("w", encoding="utf-8") as file:
            for spec in (*FITTED, *HELD_OUT):
                for row in measured(spec):
                    file.write(json.dumps(row) + "\n")
                print(spec, file=sys.stderr, flush=True)
    lines = Path(chosen.again or chosen.output).read_text(encoding="utf-8").splitlines()
    report([json.loads(line) for line in lines], chosen.share)
    return 0


if __name__ == "__main__":
    sys.exit(run(sys.argv[1:]))
