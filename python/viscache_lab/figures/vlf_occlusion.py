"""Table 1 and Figure 8 of the visibility field's paper: ambient occlusion of five scenes."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

import viscache as vc
from viscache_lab.cases.beams import Beams
from viscache_lab.experiment import FIGURES, Row, Trial
from viscache_lab.experiment.drawing import images
from viscache_lab.figures import vlf_printed as printed
from viscache_lab.figures.bands import vlf as bands
from viscache_lab.figures.vlf_tracers import (
    FAST_EMBREE,
    QUICK_DIRECTIONS,
    Floats,
    Tuned,
    first_hits,
    free_bits,
    in_turns,
    starts,
    tracers,
)

SIZE, QUICK_SIZE = (256, 256), (48, 48)
#: Number of points for the single-ray tracers; the batch gets all points.
POINTS, QUICK_POINTS = 4096, 128


@dataclass(frozen=True, kw_only=True, slots=True)
class Place:
    """A scene, the points that its first camera sees, and rays along all axes."""

    name: str
    scene: vc.Scene
    positions: Floats
    normals: Floats
    seen: npt.NDArray[np.bool_]
    n_directions: int

    @property
    def points(self) -> tuple[vc.Scene, Floats, Floats, int]:
        """What aligned rays start from."""
        return self.scene, self.positions, self.normals, self.n_directions

    def beams(self, n_points: int) -> tuple[Beams, Beams]:
        """The rays of some points, ordered by point and ordered by direction."""
        pick = np.unique(np.linspace(0, len(self.positions) - 1, n_points).astype(np.int64))
        p, n = self.positions[pick], self.normals[pick]
        o = starts(self.scene, p, n)
        axes = vc.vlf.directions(self.n_directions)
        sign = np.where(n @ axes.T >= 0, 1, -1).astype(np.float32)
        d = sign[:, :, None] * axes
        o = np.broadcast_to(o[:, None], d.shape)
        orders = []
        for turned in ((o, d), (o.transpose(1, 0, 2), d.transpose(1, 0, 2))):
            origins, along = (np.ascontiguousarray(v).reshape(-1, 3) for v in turned)
            orders.append(Beams(origins=origins, directions=along, job="any"))
        return orders[0], orders[1]


def place(name: str, quick: bool) -> Place:
    """A stand-in for a scene of Table 1, with the paper's number of triangles."""
    triangles = printed.OCCLUSION[name].triangles
    make: Any = vc.scenes.church if name == "church" else vc.scenes.bumpy_spheres
    scene: vc.Scene = make(triangles=triangles)
    found = first_hits(scene, scene.cameras[0], QUICK_SIZE if quick else SIZE)
    return Place(
        name=name,
        scene=scene,
        positions=found[0],
        normals=found[1],
        seen=found[2],
        n_directions=QUICK_DIRECTIONS if quick else printed.DIRECTIONS,
    )


@FIGURES.add("vlf-tab1", "ambient occlusion: seconds and speed-up of five scenes")
def table1(trial: Trial) -> None:
    """Seconds and speed-ups of ambient occlusion."""
    table = []
    names = ("cow", "tugboat") if trial.quick else tuple(printed.OCCLUSION)
    gains = {}
    for name in names:
        rows, more, gains[name] = _measure(place(name, trial.quick), trial.quick)
        trial.rows += rows
        table += more
    trial.rows.append(_decline_row(gains, trial.quick))
    trial.csv("vlf-tab1.csv", table)
    trial.notes.append(
        "Stand-ins with the paper's numbers of triangles: bumpy spheres, and a church of ours. CPU "
        "seconds of one thread, scaled to 65,536 points of 513 rays each. Both structures with the "
        "parameters that were fastest for these rays. Point by point, a point touches every "
        "subfield once, and all of them are larger than the caches."
    )


def _decline_row(gains: dict[str, float], quick: bool) -> Row:
    """How the speed-up falls with the triangles."""
    return Row(
        "speed-up at 34K over that at 5.8K triangles",
        gains["tugboat"] / gains["cow"],
        printed=1.45 / 2.51,
        band=None if quick else bands.OCCLUSION_DECLINE,
    )


def _measure(spot: Place, quick: bool) -> tuple[list[Row], list[dict[str, Any]], float]:
    by_point, by_direction = spot.beams(QUICK_POINTS if quick else POINTS)
    tuned = tracers(spot.scene, by_point, quick)
    answers: dict[str, npt.NDArray[Any]] = {}
    runs: dict[str, Callable[[], Any]] = {
        f"{name}, {order}": partial(_blocked, beams, t)
        for order, beams in (("by point", by_point), ("by direction", by_direction))
        for name, t in tuned.items()
    }
    found = in_turns(runs, 1 if quick else 2, answers)
    whole = printed.OCCLUSION_PIXELS * printed.OCCLUSION_RAYS / len(by_point)
    seconds = {name: s * whole for name, s in found.items()}
    seconds |= _rows_of_bits(spot, quick)
    rows, gain = _scene_rows(spot.name, seconds, tuned, quick)
    differ = max(
        float((answers[name] != answers[f"Embree, {name.partition(', ')[2]}"]).mean())
        for name in answers
        if not name.startswith(FAST_EMBREE)
    )
    rows.append(
        Row(
            f"{spot.name}: largest share of rays answered unlike Embree's",
            differ,
            band=bands.QUICK_OCCLUSION_DIFFERS if quick else None,
            note=f"{len(by_point)} rays, Wald's triangle test",
        )
    )
    rays = printed.OCCLUSION_PIXELS * printed.OCCLUSION_RAYS
    table: list[dict[str, Any]] = []
    for name, s in seconds.items():
        built = tuned.get(name.partition(",")[0])
        table.append(
            {
                "scene": spot.name,
                "triangles": spot.scene.triangles,
                "method": name,
                "seconds": s,
                "Mray/s": rays / s / 1e6,
                "bytes": built.nbytes if built else "",
                "build_s": built.build_s if built else "",
            }
        )
    return rows, table, gain


def _blocked(beams: Beams, tuned: Tuned) -> npt.NDArray[Any]:
    """Which rays are; Embree traces rays that lie side by side in packets."""
    if isinstance(tuned.settings, vc.Embree):
        return np.asarray(
            tuned.caster.bare_occluded(beams.origins, beams.directions, math.inf, 16, threads=1)
        )
    return beams.trace(tuned.caster)


def _rows_of_bits(spot: Place, quick: bool) -> dict[str, float]:
    """The aligned batch and Embree's rows, all points at once."""
    engines: dict[str, Any] = {"aligned batch": "batch", "Embree's rows": "embree"}
    runs = {
        name: partial(vc.vlf.trace_aligned, *spot.points, engine=engine, threads=1)
        for name, engine in engines.items()
    }
    spot.scene.aligned_batch()
    whole = printed.OCCLUSION_PIXELS * printed.OCCLUSION_RAYS
    traced = len(spot.positions) * spot.n_directions
    return {n: s * whole / traced for n, s in in_turns(runs, 1 if quick else 2).items()}


def _scene_rows(
    name: str, seconds: dict[str, float], tuned: dict[str, Tuned], quick: bool
) -> tuple[list[Row], float]:
    """The rows, and the speed-up over CRT."""
    said = printed.OCCLUSION[name]
    field, packets = (
        seconds["VLF-RT, by point"],
        min(s for n, s in seconds.items() if n.startswith("Embree")),
    )
    plain, fast = (
        min(s for n, s in seconds.items() if n.startswith(f"{kind}, by "))
        for kind in ("Embree", FAST_EMBREE)
    )
    gain = seconds["CRT, by point"] / field

    def band(value: Any) -> Any:
        return None if quick else value

    rows = [
        Row(
            f"{name}: seconds, CRT",
            seconds["CRT, by point"],
            printed=said.crt_s,
            note=f"{tuned['CRT'].text}; printed with depth {said.crt_depth}",
        ),
        Row(
            f"{name}: seconds, VLF-RT",
            field,
            printed=said.field_s,
            note=f"{tuned['VLF-RT'].text}; printed with depth {said.field_depth}",
        ),
        Row(
            f"{name}: speed-up of VLF-RT over CRT",
            gain,
            printed=said.speedup,
            band=band(bands.OCCLUSION_SPEEDUP),
        ),
        Row(
            f"{name}: VLF-RT by direction over by point",
            field / seconds["VLF-RT, by direction"],
            band=band(bands.DIRECTION_ORDER),
        ),
        Row(
            f"{name}: seconds, Embree, the better order",
            packets,
            note=f"by point {seconds['Embree, by point']:.2f}, by direction "
            f"{seconds['Embree, by direction']:.2f}, as rows {seconds[EMBREE_ROWS]:.2f}",
        ),
        Row(f"{name}: speed-up of Embree over VLF-RT", field / packets, band=bands.EMBREE_AHEAD),
        Row(
            f"{name}: speed-up of Embree without the robust flag over VLF-RT",
            field / fast,
            note=f"no rows; robust takes {plain / fast:.2f} times as long in the same orders",
        ),
        Row(
            f"{name}: speed-up of the aligned batch over VLF-RT",
            field / seconds["aligned batch"],
            band=bands.QUICK_BATCH_OVER_FIELD if quick else bands.BATCH_OVER_FIELD,
        ),
        Row(
            f"{name}: speed-up of the aligned batch over Embree",
            packets / seconds["aligned batch"],
            band=band(bands.BATCH_OVER_EMBREE),
        ),
    ]
    return rows, gain


EMBREE_ROWS = "Embree's rows"


@FIGURES.add("vlf-fig8", "images with ambient occlusion")
def figure8(trial: Trial) -> None:
    """Pictures with ambient occlusion, by the aligned batch, held against Embree's bits."""
    names = ("cow", "church") if trial.quick else tuple(printed.OCCLUSION)
    shown, free = {}, {}
    for name in names:
        spot = place(name, trial.quick)
        bits = {engine: free_bits(*spot.points, engine) for engine in ("batch", "embree")}
        weights = vc.vlf.direction_weights(spot.n_directions).astype(float)
        image = np.zeros((*spot.seen.shape, 1))
        image[spot.seen, 0] = bits["batch"] @ weights / weights.sum()
        shown[f"{name}: {spot.scene.triangles} triangles"] = image
        free[name] = float(image[spot.seen].mean())
        trial.row(
            f"{name}: share of rays unlike Embree's",
            float((bits["batch"] != bits["embree"]).mean()),
            band=bands.QUICK_OCCLUSION_DIFFERS if trial.quick else bands.OCCLUSION_DIFFERS,
            note=f"{bits['batch'].size} rays",
        )
        trial.row(f"{name}: mean of the directions that are free", free[name])
    trial.row(
        "mean of the free directions, church over cow",
        free["church"] / free["cow"],
        band=bands.CLOSED_IS_DARKER,
    )
    trial.draw("vlf-fig8.png", [images(shown, 1.0)], (3.2 * len(names), 3.4))
