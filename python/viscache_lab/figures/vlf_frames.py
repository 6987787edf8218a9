"""Figures 4 to 7 of the visibility field's paper: random triangles and the walk in a classroom."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

import viscache as vc
from viscache.settings.rays import Rays
from viscache_lab.cases.beams import Beams
from viscache_lab.experiment import FIGURES, Row, Trial
from viscache_lab.experiment.amounts import build_scene
from viscache_lab.experiment.drawing import Panels, images, lines
from viscache_lab.figures import vlf_printed as printed
from viscache_lab.figures.bands import vlf as bands
from viscache_lab.figures.vlf_tracers import (
    FAST_EMBREE,
    MAX_BYTES,
    QUICK_DIRECTIONS,
    QUICK_TILES,
    Tuned,
    best_bsp,
    best_field,
    camera_rays,
    embree,
    in_turns,
    tracers,
)

#: Numbers of random triangles, and the largest for which a full field is built.
COUNTS = (1_000, 4_000, 9_000, 16_000, 64_000, 250_000, 1_000_000)
QUICK_COUNTS = (1_000, 4_000)
EDGE_FACTOR = 1.0
#: Places on the way into the cube of triangles; the camera looks at the centre.
STATIONS = ((1.6, 1.3, 2.0), (1.1, 0.9, 1.4), (0.6, 0.55, 0.9))
#: Interval of the frames taken from the walk's 420.
STRIDE = 6
#: Of the walk.
METHODS = ("CRT", "VLF-RT", "Embree", FAST_EMBREE)
QUICK_FRAMES, QUICK_SIZE = (0, 210), (64, 64)


def _random(count: int) -> vc.Scene:
    return build_scene(f"random_triangles?triangles={count}&edge_factor={EDGE_FACTOR:g}")


@FIGURES.add("vlf-fig4", "the scenes of random triangles")
def figure4(trial: Trial) -> None:
    """Pictures of the scenes of random triangles."""
    shown = {}
    for column, count in enumerate(printed.RANDOM_SHOWN):
        scene = _random(count)
        view = vc.look_at(STATIONS[column], (0.5, 0.5, 0.5), (0.0, 1.0, 0.0), 40.0)
        size = QUICK_SIZE if trial.quick else printed.RANDOM_SIZE
        frame = vc.render(scene, vc.Whitted(n_vpls=0), size=size, camera=view)
        shown[f"{count} triangles"] = frame
        trial.row(
            f"triangles, {'left' if column == 0 else 'right'}",
            scene.triangles,
            printed=count,
            band=bands.RANDOM_TRIANGLES[count],
            note=f"edge {EDGE_FACTOR:g} n^(-1/3); the paper's size is not told",
        )
    trial.draw("vlf-fig4.png", [images(shown)], (8.0, 4.2))


@FIGURES.add("vlf-fig5", "frame time over the number of triangles")
def figure5(trial: Trial) -> None:
    """Time of primary rays by number of random triangles."""
    size = QUICK_SIZE if trial.quick else printed.RANDOM_SIZE
    counts = QUICK_COUNTS if trial.quick else COUNTS
    table = []
    times: dict[str, list[float]] = {"CRT": [], "VLF-RT": [], "Embree": [], FAST_EMBREE: []}
    steps = []
    for count in counts:
        scene = _random(count)
        beams = _stations(size)
        tuned = tracers(scene, beams, trial.quick, lazy=True)
        runs: dict[str, Callable[[], Any]] = {
            name: partial(beams.trace, t.caster) for name, t in tuned.items()
        }
        found = in_turns(runs, 1 if trial.quick else 3)
        for name, seconds in found.items():
            times[name].append(1e3 * seconds / len(STATIONS))
            table.append(
                {
                    "triangles": count,
                    "method": name,
                    "ms": times[name][-1],
                    "bytes": tuned[name].nbytes,
                    "build_s": tuned[name].build_s,
                }
            )
        trial.rows += _count_rows(count, found, tuned, trial.quick)
        steps.append(steps_of_a_ray(scene, beams, trial.quick))
    trial.rows += _growth_rows(counts, times, steps, trial.quick)
    drawn = {name: (counts, ms) for name, ms in times.items()}
    trial.draw("vlf-fig5.png", lines(drawn, x="triangles", y="CPU ms per frame"))
    trial.csv("vlf-fig5.csv", table)
    trial.notes.append(
        f"{size[0]}x{size[1]} primary rays, one thread, {len(STATIONS)} places of the camera, "
        f"edges of {EDGE_FACTOR:g} n^(-1/3) of the cube: the paper tells neither its triangles' "
        "size nor its path. The field builds only the directions its rays need."
    )


def _stations(size: tuple[int, int]) -> Beams:
    parts = [
        camera_rays(vc.look_at(p, (0.5, 0.5, 0.5), (0.0, 1.0, 0.0), 40.0), size) for p in STATIONS
    ]
    return Beams(
        origins=np.concatenate([p.origins for p in parts]),
        directions=np.concatenate([p.directions for p in parts]),
    )


def _count_rows(
    count: int, found: dict[str, float], tuned: dict[str, Tuned], quick: bool
) -> Iterator[Row]:
    gain, ahead = found["CRT"] / found["VLF-RT"], found["VLF-RT"] / found["Embree"]
    yield Row(
        f"{count} triangles: speed-up of VLF-RT over CRT",
        gain,
        band=None if quick else bands.RANDOM_SPEEDUP,
        note=f"CRT {tuned['CRT'].text}; VLF-RT {tuned['VLF-RT'].text}",
    )
    yield Row(
        f"{count} triangles: speed-up of Embree over VLF-RT",
        ahead,
        band=None if quick else bands.EMBREE_AHEAD,
    )
    yield Row(
        f"{count} triangles: speed-up of Embree without the robust flag over VLF-RT",
        found["VLF-RT"] / found[FAST_EMBREE],
    )


def steps_of_a_ray(scene: vc.Scene, beams: Beams, quick: bool) -> float:
    """Tiles, leaves and triangles that a ray visits in a field of depth 3, mean."""
    n_directions = QUICK_DIRECTIONS if quick else printed.DIRECTIONS
    settings = vc.Vlf(
        n_directions=n_directions,
        n_tiles=QUICK_TILES if quick else printed.TILES,
        bsp_depth=3,
        lazy=True,
        max_bytes=MAX_BYTES,
    )
    field = settings.build(scene)
    axes = vc.vlf.nearest_direction(beams.directions, n_directions).astype(np.uint32)
    steps = field.trace_by(beams.origins, beams.directions, axes)[3]
    return float(sum(steps[name] for name in ("tiles", "leaves", "tests")) / len(beams))


def _growth_rows(
    counts: Sequence[int], times: dict[str, list[float]], steps: Sequence[float], quick: bool
) -> Iterator[Row]:
    more = counts[-1] / counts[0]
    yield Row(
        "VLF-RT: growth of a ray's steps over the growth of the triangles",
        steps[-1] / steps[0] / more,
        band=bands.RANDOM_STEPS,
        note=f"{steps[0]:.1f} to {steps[-1]:.1f} tiles, leaves and triangles, depth 3",
    )
    for name, ms in times.items():
        yield Row(
            f"{name}: growth of the time over the growth of the triangles",
            ms[-1] / ms[0] / more,
            band=bands.RANDOM_GROWTH if name == "VLF-RT" and not quick else None,
            note=f"{ms[0]:.1f} to {ms[-1]:.1f} ms a frame",
        )


@FIGURES.add("vlf-fig6", "frame times of a walk through a classroom")
def figure6(trial: Trial) -> None:
    """A walk through the classroom: CPU time of each frame."""
    frames = QUICK_FRAMES if trial.quick else range(0, printed.CLASSROOM_FRAMES, STRIDE)
    size = QUICK_SIZE if trial.quick else printed.CLASSROOM_SIZE
    # One scene per tracer: a scene keeps only one caster besides Embree's
    rooms = {name: _classroom(trial.quick) for name in METHODS}
    views = [vc.scenes.classroom_camera(k) for k in frames]
    some = camera_rays(views[len(views) // 2], size)
    tuned = {
        "CRT": best_bsp(rooms["CRT"], some, trial.quick),
        "VLF-RT": best_field(rooms["VLF-RT"], some, trial.quick),
        "Embree": embree(rooms["Embree"]),
        FAST_EMBREE: embree(rooms[FAST_EMBREE], robust=False),
    }
    table, more_rays = [], []
    for k, view in zip(frames, views, strict=True):
        rays = camera_rays(view, size)
        primary = in_turns({n: partial(rays.trace, t.caster) for n, t in tuned.items()}, 1)
        lit = {n: _whitted(rooms[n], tuned[n].settings, view, size) for n in rooms}
        whitted = {n: float(frame.timings["cpu_s"]) for n, frame in lit.items()}
        counters = lit["VLF-RT"].counters
        more_rays.append((counters["camera_rays"] + counters["rays"]) / len(rays))
        table += [
            {"frame": k, "method": n, "shading": shading, "ms": 1e3 * seconds[n]}
            for shading, seconds in (("OpenGL-like", primary), ("Whitted", whitted))
            for n in rooms
        ]
    trial.rows += _walk_rows(table, tuned, trial.quick)
    trial.row(
        "rays of a Whitted frame over its primary rays, median",
        _median(np.array(more_rays)),
        band=bands.WHITTED_RAYS,
    )
    trial.draw("vlf-fig6.png", _walk(table))
    trial.csv("vlf-fig6.csv", table)
    trial.notes.append(
        "OpenGL-like: the primary rays alone. Whitted: whole frames through viscache.render with "
        "shadow rays to the four lights, shading included; single-ray tracers get them one by one, "
        "Embree in packets of 16. One thread."
    )


def _classroom(quick: bool) -> vc.Scene:
    triangles = 5000 if quick else printed.CLASSROOM_TRIANGLES
    return build_scene(f"classroom_like?triangles={triangles}")


def _whitted(scene: vc.Scene, rays: Rays, view: vc.Camera, size: tuple[int, int]) -> vc.Frame:
    """A frame; its time excludes building the caster."""
    scene.caster(rays)
    return vc.render(scene, vc.Whitted(n_vpls=0), rays=rays, size=size, camera=view, threads=1)


def _ms(table: list[dict[str, Any]], method: str, shading: str) -> npt.NDArray[np.float64]:
    return np.array([r["ms"] for r in table if (r["method"], r["shading"]) == (method, shading)])


def _walk_rows(table: list[dict[str, Any]], tuned: dict[str, Tuned], quick: bool) -> Iterator[Row]:
    for shading, band in bands.WALK_SPEEDUP.items():
        crt, field, packets, fast = (_ms(table, n, shading) for n in METHODS)
        gain = crt / field
        yield Row(
            f"{shading}: speed-up of VLF-RT over CRT, median",
            _median(gain),
            band=None if quick else band,
            note=f"{gain.min():.2f} to {gain.max():.2f} over {len(gain)} frames",
        )
        yield Row(
            f"{shading}: speed-up of Embree over VLF-RT, median",
            _median(field / packets),
            band=None if quick else bands.EMBREE_AHEAD,
        )
        yield Row(
            f"{shading}: speed-up of Embree without the robust flag over VLF-RT, median",
            _median(field / fast),
        )
    cost = _ms(table, "VLF-RT", "Whitted") / _ms(table, "VLF-RT", "OpenGL-like")
    yield Row(
        "VLF-RT: a Whitted frame over an OpenGL-like one, median",
        _median(cost),
        band=None if quick else bands.WHITTED_COST,
    )
    depths = {"CRT": printed.CLASSROOM_CRT_DEPTH, "VLF-RT": printed.CLASSROOM_FIELD_DEPTH}
    for name, depth in depths.items():
        s: Any = tuned[name].settings
        best = s.max_depth if name == "CRT" else s.bsp_depth
        yield Row(f"{name}: best depth", best, printed=depth, note=tuned[name].text)


def _median(values: npt.NDArray[np.float64]) -> float:
    return float(np.median(values))


def _walk(table: list[dict[str, Any]]) -> Panels:
    drawn = {}
    for shading in bands.WALK_SPEEDUP:
        for method in METHODS:
            at = [r["frame"] for r in table if (r["method"], r["shading"]) == (method, shading)]
            drawn[f"{method}, {shading}"] = (at, _ms(table, method, shading).tolist())
    return lines(drawn, x="frame", y="CPU ms", logarithmic="y")


@FIGURES.add("vlf-fig7", "the classroom")
def figure7(trial: Trial) -> None:
    """The classroom with Whitted and with OpenGL-like shading."""
    scene: vc.Scene = vc.scenes.classroom_like()
    lights = [light for light in scene.lights if light["kind"] == "point"]
    size = QUICK_SIZE if trial.quick else printed.CLASSROOM_SIZE
    view = scene.cameras[1]
    frame = vc.render(scene, vc.Whitted(n_vpls=0), size=size, camera=view)
    pictures: dict[str, npt.NDArray[Any]] = {
        "Whitted": frame.image,
        "OpenGL-like": local_shading(frame, view, lights),
    }
    count, lamps = printed.CLASSROOM_TRIANGLES, printed.CLASSROOM_LIGHTS
    trial.row("triangles", scene.triangles, printed=count, band=bands.CLASSROOM_TRIANGLES)
    trial.row("point lights", len(lights), printed=lamps, band=bands.CLASSROOM_LIGHTS)
    trial.draw("vlf-fig7.png", [images(pictures)], (8.0, 4.2))


def local_shading(
    frame: Any, view: vc.Camera, lights: list[dict[str, Any]]
) -> npt.NDArray[np.float64]:
    """(H, W, 3): local shading by the lights' distances and directions, without shadows."""
    layers = frame.layers
    height, width = layers["depth"].shape[:2]
    along = camera_rays(view, (width, height)).directions.reshape(height, width, 3)
    position = np.asarray(view.origin) + layers["depth"] * along
    shaded = np.zeros((height, width, 3))
    for light in lights:
        to_light = np.asarray(light["position"]) - position
        squared = (to_light**2).sum(axis=-1, keepdims=True)
        cosine = (layers["normal"] * to_light).sum(axis=-1, keepdims=True) / np.sqrt(squared)
        shaded += np.asarray(light["intensity"]) * np.maximum(0, cosine) / squared
    return np.asarray(shaded * layers["albedo"] / np.pi * (layers["coverage"] > 0))
