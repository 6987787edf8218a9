"""The list of benches, and running one of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias

from viscache.settings.spelling import nearest
from viscache_lab.bench.against_peers import against_peers
from viscache_lab.bench.aligned import aligned
from viscache_lab.bench.aqvc_apartment import aqvc_apartment
from viscache_lab.bench.aqvc_frame import aqvc_frame
from viscache_lab.bench.aqvc_lookup import aqvc_lookup
from viscache_lab.bench.common import Outcome, machine
from viscache_lab.bench.correlation import correlation
from viscache_lab.bench.frames import frames
from viscache_lab.bench.loading import loading
from viscache_lab.bench.memory import memory
from viscache_lab.bench.meter import meter
from viscache_lab.bench.notebook_slider import notebook_slider
from viscache_lab.bench.oracle import oracle
from viscache_lab.bench.parity import parity
from viscache_lab.bench.picks import picks
from viscache_lab.bench.progressive import progressive
from viscache_lab.bench.rays import rays
from viscache_lab.bench.shafts import shafts
from viscache_lab.bench.shafts_elsewhere import shafts_elsewhere
from viscache_lab.bench.skies import skies
from viscache_lab.bench.sweep import sweep
from viscache_lab.bench.threads import threads
from viscache_lab.bench.tune import tune_scenes
from viscache_lab.bench.vismap_variance import vismap_variance
from viscache_lab.bench.vlf_ao import vlf_ao
from viscache_lab.bench.vlf_build import vlf_build
from viscache_lab.bench.watertight import watertight
from viscache_lab.bench.which_cache import which_cache

__all__ = ["BENCHES", "BenchInfo", "run", "run_all"]

Bench: TypeAlias = Callable[[bool], Outcome]


@dataclass(frozen=True, kw_only=True, slots=True)
class BenchInfo:
    """One bench."""

    description: str
    function: Bench
    """Called with `quick`."""


BENCHES: dict[str, BenchInfo] = {
    "rays": BenchInfo(
        description="any-hit rays from numpy to numpy against a bare Embree loop, Mitsuba, embreex",
        function=rays,
    ),
    "watertight": BenchInfo(
        description="any-hit rays that pass no vertex against Embree's robust packets and the BSP",
        function=watertight,
    ),
    "frames": BenchInfo(
        description="exact frames: ambient occlusion and 500 point lights against Mitsuba",
        function=frames,
    ),
    "aqvc-frame": BenchInfo(
        description="whole frames with the quantized cache against exact frames",
        function=aqvc_frame,
    ),
    "aqvc-apartment": BenchInfo(
        description="24 lamps, 1024 virtual lights and 256 sky samples with the quantized cache",
        function=aqvc_apartment,
    ),
    "aqvc-lookup": BenchInfo(
        description="nanoseconds per query of each form of the quantized cache, beside one ray",
        function=aqvc_lookup,
    ),
    "shafts": BenchInfo(
        description="exact visibility of virtual point lights by shafts against packets of rays",
        function=shafts,
    ),
    "progressive": BenchInfo(
        description="error times time of passes: exact, plain and corrected",
        function=progressive,
    ),
    "which-cache": BenchInfo(
        description="which way wins where: error times time of passes over 14 pictures",
        function=which_cache,
    ),
    "picks": BenchInfo(
        description="error over time: exact, cached, or a few lights picked by each eye point",
        function=picks,
    ),
    "skies": BenchInfo(
        description="error over time under real skies: own samples, or directions in sets",
        function=skies,
    ),
    "meter": BenchInfo(
        description="audits of cached frames: coverage of their intervals, and their cost",
        function=meter,
    ),
    "threads": BenchInfo(
        description="wall-clock time with one thread, two, … and all cores; the bytes are the same",
        function=threads,
    ),
    "shafts-elsewhere": BenchInfo(
        description="visible_matrix and oracle.block by shafts against packets of rays",
        function=shafts_elsewhere,
    ),
    "oracle": BenchInfo(
        description="caches asked with arrays, and oracles written in Python, beside frames",
        function=oracle,
    ),
    "memory": BenchInfo(
        description="peak memory of a 1280x800 frame of a scene of 2.2 million triangles",
        function=memory,
    ),
    "loading": BenchInfo(
        description="time and memory to load scene files and build their trees against Mitsuba",
        function=loading,
    ),
    "correlation": BenchInfo(
        description="pairs of rows per second and core against numpy and the machine's bound",
        function=correlation,
    ),
    "vlf-build": BenchInfo(
        description="building visibility fields; the paper's tracers against Embree ray by ray",
        function=vlf_build,
    ),
    "vlf-ao": BenchInfo(
        description="ambient occlusion along shared axes against the best of Embree's orders",
        function=vlf_ao,
    ),
    "aligned": BenchInfo(
        description="the engine chosen for aligned rays against Embree, in scenes not used to fit",
        function=aligned,
    ),
    "vismap-variance": BenchInfo(
        description="variance with visibility maps against product sampling",
        function=vismap_variance,
    ),
    "sweep": BenchInfo(
        description="500 points of a sweep: time outside frames and metrics, kills, dask",
        function=sweep,
    ),
    "tune": BenchInfo(
        description="errors of whole frames at the settings that vc.tune chose, on nine scenes",
        function=tune_scenes,
    ),
    "notebook-slider": BenchInfo(
        description="the C_E slider of a notebook, from the move to the picture that is shown",
        function=notebook_slider,
    ),
    "parity": BenchInfo(
        description="pictures of a zoo of scene files and of shared scenes against Mitsuba 3",
        function=parity,
    ),
    "peers": BenchInfo(
        description="rays and pictures against other renderers, each in its own environment",
        function=against_peers,
    ),
}


def run(name: str, quick: bool = False, function: Bench | None = None) -> dict[str, Any]:
    """Run one bench: the object that `viscache bench NAME --json` prints.

    `function` takes the place of the bench's own, e.g. with more arguments set.

    Returns
    -------
    dict
        bench, machine, figures, answers_checked, answers (each check with value and limit),
        answers_hold, skipped, notes, quick.

    Raises
    ------
    ValueError
        The name is unknown; the message gives the nearest known one.
    """
    if name not in BENCHES:
        raise ValueError(f"unknown bench {name!r}{nearest(name, BENCHES)}")
    outcome = (function or BENCHES[name].function)(quick)
    return {
        "bench": name,
        "machine": machine(),
        "figures": outcome.figures,
        "answers_checked": bool(outcome.answers),
        "answers_hold": outcome.answers_hold,
        "answers": outcome.answers,
        "skipped": outcome.skipped,
        "notes": outcome.notes,
        "quick": quick,
    }


def run_all(quick: bool = False) -> list[dict[str, Any]]:
    """Run every bench."""
    return [run(name, quick) for name in BENCHES]
