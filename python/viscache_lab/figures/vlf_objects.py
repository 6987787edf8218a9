"""Beyond the visibility field's paper: the cost of moving an object (X5)."""

from __future__ import annotations

from functools import partial
from typing import Any, Literal, TypeAlias

import numpy as np

import viscache as vc
from viscache.vlf.dynamic import DynamicField
from viscache_lab.cases.beams import chords
from viscache_lab.cases.moving_object import STOPS, ball, with_object
from viscache_lab.experiment import FIGURES, Row, Trial
from viscache_lab.experiment.drawing import lines as drawn
from viscache_lab.figures.bands import vlf as bands
from viscache_lab.figures.vlf_tracers import MAX_BYTES, cpu_seconds

Mode: TypeAlias = Literal["overlay", "in_place"]

TRIANGLES, QUICK_TRIANGLES = 100_000, 3_000
#: Triangles of the moving object, as shares of the scene's: 100 to 10,000.
SHARES, QUICK_SHARES = (0.001, 0.003, 0.01, 0.03, 0.1), (0.01, 0.1)
FIELD = vc.Vlf(n_tiles=128, bsp_depth=3, head_room=1.25, max_bytes=MAX_BYTES)
QUICK_FIELD = vc.Vlf(n_directions=33, n_tiles=64, bsp_depth=3, head_room=1.25)
CHORDS, QUICK_CHORDS = 50_000, 2_000


@FIGURES.add("vlf-x5", "an object that moves: time of an update against a rebuild")
def x5(trial: Trial) -> None:
    """CPU time of an update against that of rebuilding the field."""
    settings = QUICK_FIELD if trial.quick else FIELD
    scene: vc.Scene = vc.scenes.bumpy_spheres(
        triangles=QUICK_TRIANGLES if trial.quick else TRIANGLES
    )
    rebuild = cpu_seconds(partial(settings.build, scene), 1 if trial.quick else 2)
    trial.rows += [
        Row(
            "CPU seconds of a rebuild",
            rebuild,
            note=f"{scene.triangles} triangles, l {settings.n_directions}, n "
            f"{settings.n_tiles}, depth {settings.bsp_depth}",
        )
    ]
    table: list[dict[str, Any]] = []
    modes: tuple[Mode, ...] = ("overlay", "in_place")
    for mode in modes:
        field = DynamicField(scene, settings, mode=mode)
        for share in QUICK_SHARES if trial.quick else SHARES:
            table.append(_move(field, scene, share, mode, trial.quick))
    for r in table:
        trial.row(
            f"{r['mode']}, {r['triangles']} triangles: a rebuild over an update",
            rebuild / r["seconds"],
            band=bands.UPDATE_PAYS if r["share"] == 0.01 else None,
            note=f"{1e3 * r['seconds']:.1f} CPU ms an update, {r['bytes'] / 1e6:.1f} MB",
        )
    trial.row(
        "rays answered unlike a field built with the object in its place",
        max(r["differ"] for r in table),
        band=bands.UPDATE_DIFFERS,
    )
    lines: dict[str, tuple[list[float], list[float]]] = {}
    for mode in modes:
        points = [(r["triangles"], 1e3 * r["seconds"]) for r in table if r["mode"] == mode]
        lines[mode] = ([float(x) for x, _ in points], [y for _, y in points])
    across = lines["overlay"][0]
    lines["rebuild"] = (across, [1e3 * rebuild] * len(across))
    trial.draw("vlf-x5.png", drawn(lines, x="triangles of the object", y="CPU ms"))
    trial.csv("vlf-x5.csv", table)


def _move(
    field: DynamicField, scene: vc.Scene, share: float, mode: Mode, quick: bool
) -> dict[str, Any]:
    """Insert an object, move it from stop to stop, compare the last stop, and delete it."""
    vertices, triangles = ball(round(share * scene.triangles), (0.0, 0.5, 0.0))
    number = field.insert(vertices, triangles)
    times = []
    for stop in STOPS:
        matrix = np.eye(4)
        matrix[:3, 3] = stop
        times.append(cpu_seconds(partial(field.transform, number, matrix), 1))
    beams = chords(scene, QUICK_CHORDS if quick else CHORDS)
    found = field.intersect(beams.origins, beams.directions).t
    moved = with_object(scene, vertices + np.array(STOPS[-1]), triangles)
    fresh = vc.Vlf(n_directions=33, n_tiles=64, bsp_depth=3).build(moved)
    expected = fresh.intersect(beams.origins, beams.directions)[0]
    nbytes = field.stats["bytes"]
    field.delete(number)
    return {
        "mode": mode,
        "share": share,
        "triangles": len(triangles),
        "seconds": float(np.median(times)),
        "bytes": nbytes,
        "differ": float(np.mean(~np.isclose(found, expected, rtol=1e-5, atol=0))),
    }
