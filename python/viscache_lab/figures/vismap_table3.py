"""Table 3 of the visibility-map paper: variance and overhead by number of samples."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

import viscache as vc
from viscache.metrics.variance import VarianceRatio, variance_ratio
from viscache_lab.cases.map_renders import Picture, images, paper_maps, variance_left
from viscache_lab.cases.simulation import PixelEstimates, Way, simulate
from viscache_lab.experiment import FIGURES, Row, Trial
from viscache_lab.figures import vismap_printed as printed
from viscache_lab.figures.bands import vismap as bands
from viscache_lab.figures.vismap_living_room import living_rooms, variance_rows
from viscache_lab.figures.vismap_records import VIEWS

#: Rendered pictures of each kind, their size, and the number of simulated pixels.
RENDERS, SIZE, PIXELS, REPLICATES = 8, (160, 120), 256, 32
QUICK_RENDERS, QUICK_SIZE, QUICK_PIXELS, QUICK_REPLICATES = 3, (40, 30), 16, 8
QUICK_SAMPLES = (10, 30)

PRODUCT, ONE = Way(), Way(alpha=1.0)
STEADY = Way(alpha="previous_pass", passes=6)
GUIDED = Way(alpha="previous_pass", passes=6, eta=0.25)
LOO = Way(alpha="loo", points="iid")
ONE_SHOT = Way(alpha="previous_pass", one_shot=True, first="pilot")
ONE_SHOT_PAPER = Way(alpha="previous_pass", one_shot=True)
EVERY = (PRODUCT, ONE, STEADY, GUIDED, ONE_SHOT, ONE_SHOT_PAPER)
NAMES = {
    ONE: "alpha one",
    STEADY: "alpha of earlier passes",
    GUIDED: "guided",
    LOO: "leave-one-out",
    ONE_SHOT: "one shot, first alpha of a pilot",
    ONE_SHOT_PAPER: "one shot, first alpha one",
}


@dataclass(frozen=True, kw_only=True, slots=True)
class Times:
    """CPU seconds of pictures, by number of samples."""

    samples: tuple[int, ...]
    product: tuple[float, ...]
    maps: tuple[float, ...]

    @property
    def overhead(self) -> tuple[float, ...]:
        """Seconds with the cache less those of product sampling."""
        return tuple(b - a for a, b in zip(self.product, self.maps, strict=True))

    def split(self) -> tuple[float, float]:
        """Seconds of product sampling for a picture without samples, and per sample."""
        slope, fixed = np.polyfit(self.samples, self.product, 1)
        return float(fixed), float(slope)


@FIGURES.add("vismap-tab3", "variance ratios and overhead over the number of samples")
def table3(trial: Trial) -> None:
    """Rendered pictures as in the paper, and simulated pixels for what it does not print."""
    samples = QUICK_SAMPLES if trial.quick else printed.SAMPLES
    for name, view in VIEWS.items():
        picture = Picture(
            scene=view.open(trial.quick),
            camera=view.camera,
            size=QUICK_SIZE if trial.quick else SIZE,
        )
        settings = vc.MapSettings(m=view.m)
        trial.rows += _rendered_rows(name, picture, settings, samples, trial.quick)
        found = simulate(
            picture.build_cache(settings),
            _ways(),
            samples,
            camera=view.camera,
            size=picture.size,
            n_pixels=QUICK_PIXELS if trial.quick else PIXELS,
            replicates=QUICK_REPLICATES if trial.quick else REPLICATES,
        )
        rows = _simulated_rows(name, found, samples)
        trial.rows += [replace(row, band=None) for row in rows] if trial.quick else rows
    for label, scene in living_rooms(trial):
        trial.rows += variance_rows(label, scene, trial.quick)
    trial.notes.append(
        "rendered: variance over independent pictures, the cache built once before. Simulated: "
        "random pixels in the world of the environment's texels, steady state unless it says "
        "'one shot': then these samples are all there are, in passes of 10, 20, 40, …"
    )


def _ways() -> list[Way]:
    both: tuple[Literal["iid", "rqmc"], ...] = ("iid", "rqmc")
    return [LOO, *(replace(way, points=p) for way in EVERY for p in both)]


# Rendered


def _rendered_rows(
    name: str, picture: Picture, settings: vc.MapSettings, samples: tuple[int, ...], quick: bool
) -> Iterator[Row]:
    cache = picture.build_cache(settings)
    left = {n: _rendered(picture, cache, n, QUICK_RENDERS if quick else RENDERS) for n in samples}
    said = {c.samples: c for c in printed.COSTS.get(name, ())}
    variate = bands.QUICK_GARAGE_CONTROL_VARIATE if quick else bands.GARAGE_CONTROL_VARIATE
    judged = {("garage", 10): variate, ("garden1", 300): bands.GARDEN_ONE}
    for n, found in left.items():
        yield Row(
            f"{name}, rendered, rqmc, alpha one, {n} samples: variance left",
            found.ratio,
            printed=said[n].variance_ratio if n in said else None,
            band=judged.get((name, n)),
            note=f"{found.low:.3f} to {found.high:.3f}, trimmed {found.trimmed:.3f}; "
            f"z of the means {found.energy_z:.1f}",
        )
    yield from _time_rows(name, _times(picture, settings, samples), quick)


def _rendered(
    picture: Picture, cache: vc.VisibilityMapCache, n: int, renders: int
) -> VarianceRatio:
    maps = paper_maps(cache)
    return variance_ratio(
        images(lambda seed: picture.maps(n, maps, seed), range(renders)),
        images(lambda seed: picture.product(n, seed), range(100, 100 + renders)),
    )


def _times(picture: Picture, settings: vc.MapSettings, samples: tuple[int, ...]) -> Times:
    """The faster of two runs of each picture; with maps, each run makes the cache's records."""

    def seconds(frames: list[Any]) -> float:
        return float(min(frame.timings["cpu_s"] for frame in frames))

    maps = replace(paper_maps(None), m=settings.m)
    return Times(
        samples=tuple(samples),
        product=tuple(seconds([picture.product(n) for _ in range(2)]) for n in samples),
        maps=tuple(seconds([picture.maps(n, maps) for _ in range(2)]) for n in samples),
    )


def _time_rows(name: str, times: Times, quick: bool) -> Iterator[Row]:
    said = {c.samples: c for c in printed.COSTS.get(name, ())}
    for n, product, overhead in zip(times.samples, times.product, times.overhead, strict=True):
        yield Row(
            f"{name}, {n} samples: CPU seconds of product sampling",
            product,
            printed=said[n].product_s if n in said else None,
        )
        yield Row(
            f"{name}, {n} samples: CPU seconds of overhead",
            overhead,
            printed=said[n].overhead_s if n in said else None,
            note=f"{100 * overhead / product:.1f} %",
        )
    fixed, slope = times.split()
    steady = max(times.overhead) / max(min(times.overhead), 1e-9)
    yield Row(
        f"{name}: CPU seconds of product sampling without samples",
        fixed,
        printed=79.7 if name == "garage" else None,
    )
    yield Row(
        f"{name}: CPU seconds per sample of all pixels",
        slope,
        printed=2.33 if name == "garage" else None,
    )
    yield Row(
        f"{name}: largest over smallest overhead",
        steady,
        band=None if quick else bands.OVERHEAD_IS_CONSTANT,
    )


# Simulated


def _simulated_rows(name: str, found: PixelEstimates, samples: tuple[int, ...]) -> Iterator[Row]:
    ratios = {}
    for way in _ways():
        base = Way(points=way.points)
        if way == base:
            continue
        for n in samples:
            left = variance_left(found, way, base, n)
            ratios[way, n] = left.ratio
            label = NAMES[way if way == LOO else replace(way, points="rqmc")]
            yield Row(
                f"{name}, {way.points}, {label}, {n} samples: variance left",
                left.ratio,
                band=_band(name, way, n),
                note=f"{left.low:.3f} to {left.high:.3f}",
            )
    flat = [ratios[replace(ONE, points="iid"), n] for n in samples]
    yield Row(
        f"{name}, iid, alpha one: largest over smallest ratio",
        max(flat) / min(flat),
        band=bands.IID_IS_FLAT,
    )
    rising = ratios[ONE, samples[-1]] / ratios[ONE, samples[0]]
    printed_rise = None
    if name in printed.COSTS and samples == printed.SAMPLES:
        first, *_, last = printed.COSTS[name]
        printed_rise = last.variance_ratio / first.variance_ratio
    yield Row(
        f"{name}, rqmc, alpha one: ratio at {samples[-1]} over {samples[0]}",
        rising,
        printed=printed_rise,
        band=bands.RQMC_RISES if name in ("garage", "dynamics") else None,
    )


def _band(name: str, way: Way, n: int) -> Any:
    if name == "garage" and way == GUIDED:
        return bands.GARAGE_GUIDED.get(n)
    steady = way in (STEADY, replace(STEADY, points="iid")) or (way == LOO and n >= 30)
    return bands.GARDEN_PREVIOUS_PASS if name.startswith("garden") and steady else None
