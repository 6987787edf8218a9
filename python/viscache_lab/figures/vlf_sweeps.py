"""Beyond the visibility field's paper: sweeps of its parameters (X1)."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

import viscache as vc
from viscache.settings.by_name import replaced
from viscache_lab.cases.beams import Beams, chords
from viscache_lab.experiment import FIGURES, Row, Trial
from viscache_lab.experiment.drawing import Panel, Panels, Series
from viscache_lab.figures.bands import vlf as bands
from viscache_lab.figures.vlf_tracers import MAX_BYTES, cpu_seconds, embree

#: One parameter at a time, around the paper's settings.
BASE, QUICK_BASE = (
    vc.Vlf(n_tiles=128, bsp_depth=3, max_bytes=MAX_BYTES),
    vc.Vlf(n_directions=129, n_tiles=64, bsp_depth=3),
)
SWEPT: dict[str, tuple[int, ...]] = {
    "n_directions": (33, 129, 513, 2049),
    "n_tiles": (32, 64, 128, 256),
    "bsp_depth": (0, 1, 2, 3, 4, 5, 6),
}
QUICK_SWEPT = {"n_directions": (33, 129), "n_tiles": (32, 64), "bsp_depth": (0, 5)}
TRIANGLES, QUICK_TRIANGLES = 10_000, 2_000
CHORDS, QUICK_CHORDS = 100_000, 3_000


@FIGURES.add("vlf-x1", "speed, tests and memory over directions, tiles and depth")
def x1(trial: Trial) -> None:
    """Tiles and tests per ray, speed, bytes and build time over l, n and depth."""
    base = QUICK_BASE if trial.quick else BASE
    swept: Mapping[str, tuple[int, ...]] = QUICK_SWEPT if trial.quick else SWEPT
    triangles = QUICK_TRIANGLES if trial.quick else TRIANGLES
    scene: vc.Scene = vc.scenes.random_triangles(triangles=triangles, edge_factor=1.0)
    beams = chords(scene, QUICK_CHORDS if trial.quick else CHORDS)
    table = []
    for name, values in swept.items():
        for value in values:
            settings = replaced(base, {name: value}, "rays")
            table.append({"swept": name, **_measure(scene, beams, settings)})
    rival = embree(scene)
    seconds = cpu_seconds(lambda: beams.trace(rival.caster))
    single = cpu_seconds(
        lambda: rival.caster.bare_intersect(beams.origins, beams.directions, threads=1)
    )
    trial.rows += _sweep_rows(table, trial.quick)
    trial.row(
        "Mray/s, Embree in packets",
        len(beams) / seconds / 1e6,
        note=f"{rival.build_s:.3f} CPU s to build",
    )
    trial.row("Mray/s, Embree ray by ray", len(beams) / single / 1e6)
    trial.draw("vlf-x1.png", _panels(table), (9.0, 6.0))
    trial.csv("vlf-x1.csv", table)
    trial.notes.append(
        f"{scene.triangles} random triangles, nearest hits of {len(beams)} chords, one thread; "
        f"one parameter at a time around l {base.n_directions}, n {base.n_tiles}, depth "
        f"{base.bsp_depth}"
    )


def _measure(scene: vc.Scene, beams: Beams, settings: vc.Vlf) -> dict[str, Any]:
    start = time.process_time()
    field = settings.build(scene)
    build_s = time.process_time() - start
    axes = vc.vlf.nearest_direction(beams.directions, field.settings.n_directions).astype(np.uint32)
    steps = field.trace_by(beams.origins, beams.directions, axes)[3]
    seconds = cpu_seconds(lambda: beams.trace(field))
    n = len(beams)
    return {
        **{name: getattr(settings, name) for name in SWEPT},
        **{name: steps[name] / n for name in ("tiles", "leaves", "tests")},
        "mrays_s": n / seconds / 1e6,
        "bytes": field.stats["bytes"],
        "build_s": build_s,
    }


def _sweep_rows(table: list[dict[str, Any]], quick: bool) -> Iterator[Row]:
    def at(name: str, value: int) -> dict[str, Any]:
        return next(r for r in table if r["swept"] == name and r[name] == value)

    few, many = (33, 129) if quick else (513, 2049)
    coarse, fine = at("n_directions", few), at("n_directions", many)
    flat, deep = at("bsp_depth", 0), at("bsp_depth", 5)

    yield Row(
        "tests per ray, depth 0 over depth 5",
        flat["tests"] / deep["tests"],
        band=bands.QUICK_DEPTH_SAVES_TESTS if quick else bands.DEPTH_SAVES_TESTS,
        note=f"{flat['tests']:.1f} and {deep['tests']:.1f} tests, "
        f"{flat['mrays_s']:.2f} and {deep['mrays_s']:.2f} Mray/s",
    )
    yield Row(
        f"tiles per ray, {few} directions over {many}",
        coarse["tiles"] / fine["tiles"],
        band=bands.DIRECTIONS_SAVE_TILES,
        note=f"{coarse['tiles']:.2f} and {fine['tiles']:.2f} tiles",
    )
    yield Row(
        f"rays per second, {many} directions over {few}",
        fine["mrays_s"] / coarse["mrays_s"],
        band=None if quick else bands.FINER_IS_FASTER,
        note="fewer tiles, but more memory than caches hold",
    )
    for r in table:
        what = ", ".join(f"{n} {r[n]}" for n in SWEPT)
        note = f"{r['tiles']:.2f} tiles, {r['tests']:.2f} tests a ray, {r['bytes'] / 1e6:.1f} MB"
        yield Row(
            f"Mray/s, {what}", r["mrays_s"], note=f"{note}, {r['build_s']:.2f} CPU s to build"
        )


def _panels(table: list[dict[str, Any]]) -> Panels:
    def panel(name: str, measure: str, label: str) -> Panel:
        def more(axes: Any) -> None:
            axes.set_ylim(bottom=0)
            if name != "bsp_depth":
                axes.set_xscale("log", base=2)

        points = [(r[name], r[measure]) for r in table if r["swept"] == name]
        line = Series.through("", points)
        return Panel(series=[line], x=name, y=label, more=more)

    measures = {"mrays_s": "Mray/s", "tests": "tests per ray"}
    return [[panel(name, *measure) for name in SWEPT] for measure in measures.items()]
