"""Claims in the text of the quantized cache's paper, numbered H1 to H8."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np

import viscache as vc
from viscache.base import tonemap
from viscache.metrics.temporal import mean_temporal_variance, seen
from viscache.settings.by_name import replaced
from viscache_lab.experiment import FIGURES, Row, Trial
from viscache_lab.experiment.drawing import Panel, Series
from viscache_lab.figures import aqvc_printed as printed
from viscache_lab.figures.aqvc_runs import Shot, Trade, error_row, presets
from viscache_lab.figures.aqvc_setups import PRESETS, SETUPS
from viscache_lab.figures.bands import aqvc as bands

Size = tuple[int, int] | None

#: H1: the two largest C_E of Figure 7, and the largest error at which a reduction counts.
H1_C_E, H1_REL_L1 = (24.0, 36.0), 0.03
#: H2, H5 and H7: a typical C_E. H3: one tile for the frame, and slots per key. H4: table bytes per
#: eye sample of a tile; the paper has 4 MB for 32×32 samples.
C_E = 14.0
TILE, QUICK_TILE = (256, 256), (128, 80)
SLOTS_PER_KEY = (0.1, 1.0, 10.0, 40.0)
TABLE_BYTES_PER_SAMPLE = 4096
#: H3: table bytes per thread; the paper has 4 MB.
KEPT_TABLES = (1 << 16, 1 << 18, 1 << 20, 1 << 22, 1 << 24)
#: H6: values around the paper's 8, 8 and 1.2.
PARAMETERS: dict[str, tuple[float, ...]] = {
    "c_n": (2, 8, 32),
    "c_z": (1.0, 4.0, 8.0, 32.0),
    "c_r": (1.1, 1.2, 1.5),
}
PARAMETERS_C_E = 12.0
ROOM, QUICK_ROOM = 200_000, 20_000
SMALL, QUICK_SMALL = (640, 400), (240, 150)
#: H8: C_E, the number of frames of the path, and the quick size.
FLICKER_C_E = 16.0
FRAMES, QUICK_FRAMES = 32, 5
QUICK_FLICKER = (200, 125)
#: The camera moves from the first place to the second and looks at the living room's far corner.
PATH = ((-0.1, 1.65, 0.35), (-0.4, 1.6, 0.15))
TARGET, FOV_DEG = (-4.6, 0.85, -3.2), 56.0


@FIGURES.add(
    "aqvc-claims",
    "numbers in the paper's text: rays, shading, table size, collisions, parameters, flicker",
    sized=True,
)
def claims(trial: Trial) -> None:
    """All claims, in the order of the paper's sections."""
    for part in (rays_left, shading_share, table_size, collisions, simple_scene):
        trial.rows += part(trial.quick, trial.size)
    rows, table = parameters(trial.quick, trial.size)
    trial.rows += rows
    trial.rows += frames_per_second(trial.quick, trial.size)
    trial.rows += flicker_rows(trial.quick, trial.size)
    trial.draw("aqvc-claims.png", [_panels(table)], (9.0, 3.2))
    trial.csv("aqvc-claims.csv", table)


def rays_left(quick: bool, size: Size) -> Iterator[Row]:
    """H1: less than 2 % of the queries become rays."""
    setup = SETUPS["delta"]
    shot = setup.shot(quick, size, spp=4 if quick else setup.antialiased)
    settings = {(c_e, p): setup.cache(p, c_e) for c_e in H1_C_E for p in PRESETS}
    trades = shot.trades(settings, quick)
    for (c_e, preset), trade in trades.items():
        label = f"H1 {preset}, C_E {c_e:g}, AA"
        yield Row(
            f"{label}: share of the queries that become rays",
            1 / trade.ray_reduction,
            printed=1 / (printed.RAY_REDUCTION + 1),
            band=None if quick else bands.H1_RAYS_LEFT,
            note=trade.note,
        )
        yield error_row(label, trade)
    yield Row(
        f"H1: largest RR of these at rel_l1 {H1_REL_L1:g} and less",
        largest_reduction(trades.values()),
        printed=printed.RAY_REDUCTION,
        band=None if quick else bands.H1_REDUCTION,
    )


def largest_reduction(trades: Iterable[Trade]) -> float:
    """The largest RR of those whose error is small enough; 0 if there is none."""
    return max((t.ray_reduction for t in trades if t.rel_l1 <= H1_REL_L1), default=0.0)


def shading_share(quick: bool, size: Size) -> Iterator[Row]:
    """H2: the time outside visibility bounds the speed-up."""
    setup = SETUPS["apartment"]
    shot = setup.shot(quick, size)
    trade = shot.trades({"default": setup.cache("default", C_E)}, quick)["default"]
    exact = trade.exact
    share = 1 - exact.timings["visibility_cpu_s"] / exact.timings["cpu_s"]
    yield Row(
        "H2: share of the apartment's exact frame that is not visibility",
        share,
        printed=printed.CPU_SHADING_SHARE,
        band=None if quick else bands.H2_SHADING_SHARE,
        note="camera paths, lights, contributions and sums",
    )
    yield Row("H2: bound on the speed-up", 1 / share, printed=printed.CPU_BOUND)
    yield Row(
        "H2 default: speed-up times that share",
        trade.speedup * share,
        band=None if quick else bands.H2_WITHIN_BOUND,
        note=trade.note,
    )


def table_size(quick: bool, size: Size) -> Iterator[Row]:
    """H3: a larger table gains little once it holds all keys."""
    shot = replace(SETUPS["delta"].shot(quick, size), size=QUICK_TILE if quick else TILE)
    lossless = shot.frame(vc.Aqvc(preset="paper", c_e=8, paper=vc.PaperForm(storage="exact")))
    keys = lossless.counters["rays"]
    tables = {load: max(64, int(4 * load * keys)) for load in SLOTS_PER_KEY}
    frames = shot.in_turns(
        {load: vc.Aqvc(preset="paper", c_e=8, table_bytes=size) for load, size in tables.items()},
        quick,
    )
    rays = {load: frame.counters["rays"] for load, frame in frames.items()}
    largest = SLOTS_PER_KEY[-1]
    small, enough = SLOTS_PER_KEY[0], SLOTS_PER_KEY[-2]
    time = frames[enough].timings["cpu_s"] / frames[largest].timings["cpu_s"]
    yield Row(
        f"H3: rays with {enough:g} slots per key over those with {largest:g}",
        rays[enough] / rays[largest],
        printed=printed.LARGER_TABLE,
        band=bands.H3_LARGE_TABLES,
        note=f"printed: frame time, 256 MB over 1 GB; ours {time:.2f}; {keys} keys",
    )
    yield Row(
        f"H3: rays with {small:g} slots per key over those with {largest:g}",
        rays[small] / rays[largest],
        band=bands.H3_SMALL_TABLE,
    )
    yield from kept_tables(shot, quick)


def kept_tables(shot: Shot, quick: bool) -> list[Row]:
    """H3 on the CPU: tiles of 32², and tables per thread of the paper's 4 MB and other sizes."""
    tiles = vc.PaperForm(storage="paper_tiles")
    frames = shot.in_turns(
        {s: vc.Aqvc(preset="paper", c_e=8, table_bytes=s, paper=tiles) for s in KEPT_TABLES}, quick
    )
    largest = frames[KEPT_TABLES[-1]]
    return [
        Row(
            f"H3: rays with {size >> 10} KiB a thread and tiles of 32² over those with "
            f"{KEPT_TABLES[-1] >> 10} KiB",
            frame.counters["rays"] / largest.counters["rays"],
            note=f"time {frame.timings['cpu_s'] / largest.timings['cpu_s']:.2f}, "
            f"{frame.provenance['threads']} threads",
        )
        for size, frame in frames.items()
        if frame is not largest
    ]


def collisions(quick: bool, size: Size) -> Iterator[Row]:
    """H4: rays that a lossless table would not have traced."""
    for name in ("delta", "apartment"):
        setup = SETUPS[name]
        shot = setup.shot(quick, size)
        if name == "apartment" and not quick:
            shot = replace(shot, integrator=vc.Whitted(n_vpls=256, n_environment=32, n_brdf=32))
        lossless = shot.frame(setup.cache("paper", C_E, paper=vc.PaperForm(storage="exact")))
        edge = lossless.parameters["tile_edge_px"]
        size_of_table = TABLE_BYTES_PER_SAMPLE * edge**2
        lossy = shot.frame(setup.cache("paper", C_E, table_bytes=size_of_table))
        yield Row(
            f"H4 {name}: share of the rays that collisions caused",
            share_of_collisions(lossy, lossless),
            printed="well below a few percent",
            band=bands.H4_COLLISIONS,
            note=f"{size_of_table >> 20} MiB for a tile of {edge}² pixels, as the "
            "paper's 4 MB for 32²; "
            f"{lossy.counters['evictions']} evictions",
        )


def share_of_collisions(lossy: vc.Frame, lossless: vc.Frame) -> float:
    """Share of the rays that a lossless table would not have traced."""
    rays, needed = (float(frame.counters["rays"]) for frame in (lossy, lossless))
    return (rays - needed) / rays


def simple_scene(quick: bool, size: Size) -> Iterator[Row]:
    """H5: no speed-up in the Cornell box."""
    pixels = size or ((160, 160) if quick else (512, 512))
    integrator = vc.Whitted(n_vpls=32, n_area=8) if quick else vc.Whitted(n_vpls=256, n_area=64)
    shot = Shot(scene=vc.scenes.cornell_box(), size=pixels, integrator=integrator)
    trades = shot.trades(presets(C_E), quick)
    paper, default = trades["paper"], trades["default"]
    yield Row(
        "H5 paper: speed-up in the Cornell box",
        paper.speedup,
        printed="none",
        band=bands.H5_NO_SPEEDUP,
        note=paper.note,
    )
    yield Row("H5 paper: RR there", paper.ray_reduction, band=bands.H5_REDUCTION)
    yield Row("H5 default: speed-up there", default.speedup, printed="none", note=default.note)


def parameters(quick: bool, size: Size) -> tuple[list[Row], list[dict[str, Any]]]:
    """H6: C_N = C_Z = 8 and C_R = 1.2 are best."""
    shot = Shot(
        scene=vc.scenes.room(triangles=QUICK_ROOM if quick else ROOM),
        integrator=vc.Direct(),
        size=size or (QUICK_SMALL if quick else SMALL),
    )
    base = vc.Aqvc(preset="paper", c_e=PARAMETERS_C_E, refinement="off")
    settings = {
        (name, value): replaced(base, {name: value}, "visibility")
        for name, values in PARAMETERS.items()
        for value in values
    }
    table: list[dict[str, Any]] = [
        {"parameter": name, "value": value, **trade.record()}
        for (name, value), trade in shot.trades(settings, quick).items()
    ]
    rows = []
    for name, values in PARAMETERS.items():
        found = {r["value"]: r for r in table if r["parameter"] == name}
        first, last = found[values[0]], found[values[-1]]
        rows.append(
            Row(
                f"H6: RR at {name} = {values[-1]:g} over that at {values[0]:g}",
                last["ray_reduction"] / first["ray_reduction"],
                band=bands.H6_REDUCTION[name],
                note="rel_l1 " + ", ".join(f"{v:g}: {found[v]['rel_l1']:.4f}" for v in values),
            )
        )
    errors = [r["rel_l1"] for r in table if r["parameter"] != "c_n"]
    rows.append(
        Row(
            "H6: largest rel_l1 over the smallest, all C_Z and C_R",
            max(errors) / min(errors),
            band=bands.H6_ERROR,
        )
    )
    return rows, table


def frames_per_second(quick: bool, size: Size) -> Iterator[Row]:
    """H7: interactive frame rates with fewer samples; reported without a band."""
    for name in ("apartment", "courtyard", "delta", "conference"):
        setup = SETUPS[name]
        shot = setup.shot(quick, size)
        shot = replace(shot, integrator=setup.integrator(True))
        frame = shot.in_turns({"default": setup.cache("default", C_E)}, quick)["default"]
        key = "san miguel" if name == "courtyard" else name
        yield Row(
            f"H7 {name}: frames per second with an eighth of the samples",
            1 / frame.timings["total_s"],
            printed=printed.FRAMES_PER_SECOND[key],
            note=f"{shot.size[0]}x{shot.size[1]} on {frame.provenance['threads']} "
            "threads; the paper's on a GPU, samples not told",
        )


def flicker_rows(quick: bool, size: tuple[int, int] | None) -> Iterator[Row]:
    """H8: refinement reduces flicker."""
    scene = SETUPS["delta"].scene(quick)
    pixels = size or (QUICK_FLICKER if quick else SMALL)
    shots = [
        Shot(scene=scene, integrator=vc.Direct(), size=pixels, camera=camera)
        for camera in cameras(QUICK_FRAMES if quick else FRAMES)
    ]
    frames = [shot.frame() for shot in shots]
    exposure = tonemap.auto_exposure(frames[0].image, 95.0)
    exact = [seen(frame, exposure) for frame in frames]
    for preset in ("default", "paper"):
        found = {}
        for refinement in ("off", "on"):
            cache = presets(FLICKER_C_E, refinement=refinement)[preset]
            off = [seen(s.frame(cache), exposure) - e for s, e in zip(shots, exact, strict=True)]
            found[refinement] = mean_temporal_variance(off)
        yield Row(
            f"H8 {preset}: temporal variance of the error, refinement over none",
            found["on"] / found["off"],
            band=bands.H8_FLICKER,
            note=f"deviation {np.sqrt(found['off']):.3f} to "
            f"{np.sqrt(found['on']):.3f} of white, {len(shots)} frames, "
            f"FLICKER_C_E {FLICKER_C_E:g}",
        )


def cameras(frames: int) -> list[vc.Camera]:
    """Views along the path."""
    start, end = (np.array(place) for place in PATH)
    return [
        vc.look_at((start + t * (end - start)).tolist(), TARGET, (0.0, 1.0, 0.0), FOV_DEG)
        for t in np.linspace(0, 1, frames)
    ]


def _panels(table: list[dict[str, Any]]) -> list[Panel]:
    """RR over each parameter, and rel_l1 on axes of its own at the right."""

    def panel(name: str) -> Panel:
        found = [r for r in table if r["parameter"] == name]
        x, rr, errors = ([r[k] for r in found] for k in ("value", "ray_reduction", "rel_l1"))

        def more(axes: Any) -> None:
            other = axes.twinx()
            other.plot(x, errors, "s--", color="C1", label="rel_l1")
            for one, label in ((axes, "RR"), (other, "rel_l1")):
                one.set(ylabel=label, ylim=(0, None))

        return Panel(series=[Series("RR", x, rr)], x=name, y="RR", legend=False, more=more)

    return [panel(name) for name in PARAMETERS]
