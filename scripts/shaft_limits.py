#!/usr/bin/env python3
"""Limits of shafts against packets: scripts/shaft_limits.py [-o FILE] [--again FILE]
Measures both engines in the scenes of scripts/engine_choice.py, and replays the choice of
shafts/shaft_choice.h for several limits, on the scenes that chose them and on the others."""

from __future__ import annotations

import argparse
import json
import math
import statistics
import sys
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from engine_choice import FITTED, HELD_OUT

import viscache as vc
from viscache.frame import Frame
from viscache.shot.render import render_part
from viscache_lab.experiment.amounts import Sample, interleave
from viscache_lab.experiment.trial import opened

#: Size, samples per pixel, virtual lights, and parts of the frame, of which one is rendered.
PICTURES = (
    ((160, 100), 1, 128, 1),
    ((320, 200), 1, 128, 2),
    ((640, 400), 1, 128, 7),
    ((1024, 1024), 1, 64, 16),
    ((1024, 1024), 1, 16, 16),
    ((256, 256), 16, 64, 16),
)
ENGINES = ("packets", "shafts")
LIGHTS_PER_POINT = (8, 12, 16, 20, 30)
SHARES_TRACED = (0.2, 0.3, 0.33, 0.35, 0.4)
MOSTLY_SHARED = 0.6  # frames with fewer queries to shared lights say little about them

Row = dict[str, Any]


def measured(spec: str) -> Iterator[Row]:
    """Nanoseconds per query of both engines, and the work of shafts, by picture."""
    scene = opened(spec)
    if scene is None:
        return
    scene.caster()
    for size, spp, n_vpls, parts in PICTURES:
        lights = vc.Whitted(n_vpls=n_vpls, n_area=1, n_brdf=0)
        shot = vc.Shot(scene, lights, size=size, spp=spp, threads=1)
        picture = Picture(shot, (min(3, parts - 1), parts))
        picture.render("shafts")  # builds the tree
        turns = interleave({e: partial(picture.render, e) for e in ENGINES}, 3, warm_up=False)
        frames = picture.frames
        queries, work = frames["packets"].counters["queries"], frames["shafts"].parameters["engine"]
        if not queries or "no_shafts" in work:
            continue
        assert frames["packets"].sha256 == frames["shafts"].sha256
        yield {
            "scene": spec,
            "size": size,
            "spp": spp,
            "queries": queries,
            "points": size[0] * size[1] * spp / parts,
            **{f"{e}_ns": 1e9 * min(s.cpu_s for s in turns[e]) / queries for e in ENGINES},
            **work,
        }


@dataclass
class Picture:
    """A part of a picture, and its frames by engine."""

    shot: vc.Shot
    part: tuple[int, int]
    frames: dict[str, Frame] = field(default_factory=dict)

    def render(self, engine: Any) -> Sample:
        """CPU seconds of visibility."""
        exact = vc.Exact(engine=engine, order="by_light", coherent=True)
        frame = render_part(self.shot.with_(visibility=exact), self.part)
        self.frames[engine] = frame
        cpu = frame.timings["visibility_cpu_s"]
        return Sample(wall_s=cpu, cpu_s=cpu)


def lights_per_point(row: Row) -> float:
    return float(row["shaft_queries"] / row["points"])


def share_traced(row: Row) -> float:
    return float(row["shaft_traced_packets"] / max(1, row["shaft_asked_packets"]))


def mean(values: list[float]) -> float:
    return math.exp(statistics.fmean(math.log(v) for v in values))


def report(rows: list[Row]) -> None:
    """Print the speed over packets on both halves, for each pair of limits."""
    rows = [r for r in rows if r["shaft_queries"] > MOSTLY_SHARED * r["queries"]]
    halves = {"fitted": FITTED, "held out": HELD_OUT}
    for name, scenes in halves.items():
        some = [r["packets_ns"] / r["shafts_ns"] for r in rows if r["scene"] in scenes]
        best = mean([max(1.0, gain) for gain in some])
        print(f"{name}: {len(some)} pictures, shafts alone {mean(some):.2f}, best {best:.2f}")
    for lights in LIGHTS_PER_POINT:
        for share in SHARES_TRACED:
            text = []
            for name, scenes in halves.items():
                gains = [
                    r["packets_ns"] / r["shafts_ns"]
                    if lights_per_point(r) >= lights and share_traced(r) <= share
                    else 1.0
                    for r in rows
                    if r["scene"] in scenes
                ]
                text.append(f"{name} worst {min(gains):.2f} mean {mean(gains):.2f}")
            print(f"lights >= {lights}, traced <= {share}: {', '.join(text)}")


def run(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--output", default="out/shaft-limits.jsonl", metavar="FILE")
    parser.add_argument("--again", metavar="FILE", help="replay what was measured before")
    chosen = parser.parse_args(arguments)
    if chosen.again is None:
        Path(chosen.output).parent.mkdir(parents=True, exist_ok=True)
        with Path(chosen.output).open("w", encoding="utf-8") as file:
            for spec in (*FITTED, *HELD_OUT):
                for row in measured(spec):
                    file.write(json.dumps(row) + "\n")
                print(spec, file=sys.stderr, flush=True)
    lines = Path(chosen.again or chosen.output).read_text(encoding="utf-8").splitlines()
    report([json.loads(line) for line in lines])
    return 0


if __name__ == "__main__":
    sys.exit(run(sys.argv[1:]))
