"""`viscache bench peers`: rays and pictures against other renderers, each in its environment."""

from __future__ import annotations

import itertools
import statistics
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from fnmatch import fnmatchcase
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

import viscache as vc
from viscache.metrics import compare
from viscache_lab.bench.errors import log_interval
from viscache_lab.bench.peer_cases import PictureCase, Way, picture_cases
from viscache_lab.bench.peers import (
    PEERS,
    Peer,
    PeerError,
    blocked,
    default_folder,
    interpreter,
    missing_scene,
    time_of,
)
from viscache_lab.bench.ray_sets import make_ray_set
from viscache_lab.bench.rays import EDGE_TOLERANCE
from viscache_lab.experiment import BENCHES, Trial
from viscache_lab.experiment.amounts import Sample, build_scene, frame_clock, interleave, turns
from viscache_lab.parity.blocks import block_means

Array = npt.NDArray[Any]
Peers = Mapping[str, Peer]

#: Blocks of this many pixels are compared between converged frames.
BLOCK = 8
#: Mean difference of blocks of converged frames, of the mean of the picture.
AGREEMENT = 0.01


@BENCHES.add(
    "peers",
    "rays and pictures against other renderers, each in its own environment",
    note="CPU seconds of all threads, after a warm-up. Converged frames agree, or there is no"
    " figure. Equal samples: their time over ours. Equal error: their time × squared error"
    " over ours, the geometric mean of the turns and its 95 % interval. What they build for a"
    " frame is in their time, but is not done again for more samples. Our frames are exact"
    " where no cache is named; rel_l1 of a cache is against our exact frame. Shared directions"
    " are traced exactly, too.",
)
def against_peers(trial: Trial) -> None:
    """Every case against every peer that there is; the others are skipped by name.

    Options: `environments`, the folder of `peers.make_environments` (a peer without
    environment is looked for beside this package), and `only`, a pattern of file names for the
    names of cases.
    """
    only = trial.options.get("only") or "*"
    triangles, n_rays = (5_000, 20_000) if trial.quick else (200_000, 500_000)
    repeats = trial.repeats(6, 3)
    todo: list[tuple[str, vc.Scene, Callable[[Trial, Peers], None]]] = []
    for name in ("room", "random_triangles"):
        if fnmatchcase(title := f"rays, {name}", only):
            scene = build_scene(f"{name}?triangles={triangles}")
            rays = partial(compare_rays, title=title, scene=scene, n=n_rays, repeats=repeats)
            todo.append((title, scene, rays))
    for case in picture_cases(trial.quick):
        if fnmatchcase(case.name, only):
            pictures = partial(compare_pictures, case=case, repeats=repeats)
            todo.append((case.name, case.scene, pictures))
    if not todo:
        raise ValueError(f"no case of the bench peers is named like {only!r}")
    for title, scene, run in todo:
        folder = trial.options.get("environments") or default_folder()
        _with_peers(trial, title, scene, folder, run)


def _with_peers(
    trial: Trial, name: str, scene: vc.Scene, folder: Path, run: Callable[[Trial, Peers], None]
) -> None:
    """Start all peers that there are with a scene, compare, and end them.

    A peer that fails while sides take turns is left out, and the others are compared anew.
    """
    able: dict[str, Peer] = {}
    with ExitStack() as started:
        for peer, (package, _) in PEERS.items():
            python = interpreter(package, folder)
            why = f"{package} is not installed" if python is None else missing_scene(scene)
            if why is None:
                try:
                    able[peer] = started.enter_context(Peer(peer, scene, python))
                except PeerError as error:
                    why = str(error)
            if why is not None:
                trial.skip(f"{name} vs {peer}", why)
        while True:
            made = Trial()
            try:
                run(made, able)
                break
            except PeerError as error:
                del able[error.peer]
                trial.skip(f"{name} vs {error.peer}", str(error))
        trial.extend(made)


def compare_rays(
    trial: Trial, peers: Peers, title: str, scene: vc.Scene, n: int, repeats: int
) -> None:
    """Any and nearest hits of `n` camera rays, and between points, from arrays to arrays."""
    for which, job in itertools.product(("camera", "p2p"), ("any_hit", "nearest")):
        r = make_ray_set(scene, which, n)
        rays, reach = (r.origins, r.directions), r.t_max if job == "any_hit" else np.inf
        any_hit = partial(scene.occluded, *rays, reach)
        ask = any_hit if job == "any_hit" else partial(scene.intersect, *rays)
        runs: dict[str, Callable[[], Any]] = {"ours": ask}
        able = {k: p for k, p in peers.items() if job in p.about["jobs"]}
        for name, peer in able.items():
            peer.give(origins=r.origins, directions=r.directions, t_max=reach)
            runs[name] = partial(time_of, peer, job)
        samples, answers = turns(runs, repeats)
        truth = answers["ours"] if job == "any_hit" else answers["ours"].t
        hit = truth if job == "any_hit" else np.isfinite(truth)
        label = f"{title}, {which}, {job.replace('_', ' ')}"
        trial.check(f"{label}: none hit", float(not hit.any()), 0)
        for name, peer in able.items():
            theirs = peer.result()
            if job == "any_hit":
                unlike = truth != blocked(theirs["occluded"], name)
            else:  # distances may differ by rounding
                unlike = ~np.isclose(truth, theirs["t"], rtol=1e-3, atol=1e-4)
            differs = float(np.mean(unlike))
            trial.check(f"{label}: share unlike {name}", differs, EDGE_TOLERANCE)
            if differs <= EDGE_TOLERANCE:
                about = {"version": _version(peer), "work": len(r)}
                trial.ratio(f"{label} vs {name}", samples["ours"], samples[name], **about)


@dataclass(frozen=True, kw_only=True, slots=True)
class Made(Sample):
    """A frame of one turn: its durations and its error."""

    error: float  # squared, of the squared mean of the reference; of a biased way, rel_l1
    build_s: float = 0.0  # CPU seconds of what is built once, however many samples follow


def compare_pictures(trial: Trial, peers: Peers, case: PictureCase, repeats: int) -> None:
    """One case: converged frames agree; then time at equal samples and time to equal error."""
    able = {k: p for k, p in peers.items() if case.job["job"] in p.about["jobs"]}
    for name in sorted(able.keys() & case.without.keys()):
        trial.skip(f"{case.name} vs {name}", case.without[name])
        del able[name]
    if not able:
        return
    reference = _grey(case.render(case.reference_spp, 10_000).image)
    for name, peer in list(able.items()):
        try:
            peer.give(**case.arrays)
            spp = case.peer_reference_spp or case.reference_spp
            peer.run({**case.job, "spp": spp, "seed": 10_001})
        except PeerError as error:  # e.g. Mitsuba with an LLVM that does not suit it
            trial.skip(f"{case.name} vs {name}", str(error))
            del able[name]
            continue
        both = (block_means(a[..., None], BLOCK) for a in (reference, peer.result()["image"]))
        unlike = float(np.mean(np.abs(np.subtract(*both))) / reference.mean())
        trial.check(f"{case.name}: converged frame unlike {name}'s", unlike, AGREEMENT)
        if not unlike <= AGREEMENT:
            del able[name]
    trial.check(f"{case.name}: black", float(not reference.mean() > 0), 0)
    ways = (Way(label="ours", render=case.render), *case.ways)
    runs: dict[str, Callable[[], Made]] = {
        way.label: partial(_ours, case, way, reference, itertools.count()) for way in ways
    }
    for name, peer in able.items():
        runs[name] = partial(_theirs, case, peer, reference, itertools.count(5_000))
    made = interleave(runs, repeats)
    for name, peer in able.items():
        for way in ways:
            label = case.name if way is ways[0] else f"{case.name}, {way.label}"
            mine, other = made[way.label], made[name]
            more = _without_build(mine, other)
            if way.biased:
                more["rel_l1"] = float(np.mean([m.error for m in mine]))
            else:
                more |= _equal_error(mine, other)
            more |= {"version": _version(peer), "spp": case.spp}
            trial.ratio(f"{label} vs {name}", mine, other, **more)


def _ours(case: PictureCase, way: Way, reference: Array, seeds: Iterator[int]) -> Made:
    seed = next(seeds)
    frame = way.render(case.spp, seed)
    if way.biased:
        told = compare(frame, case.render(case.spp, seed), metrics=["rel_l1"])["rel_l1"]
        error = np.nan if told is None else told
    else:
        error = _squared_error(reference, _grey(frame.image))
    took = frame_clock(frame)
    return Made(wall_s=took.wall_s, cpu_s=took.cpu_s, error=error)


def _theirs(case: PictureCase, peer: Peer, reference: Array, seeds: Iterator[int]) -> Made:
    time, report = peer.run({**case.job, "spp": case.spp, "seed": next(seeds)})
    error = _squared_error(reference, peer.result()["image"])
    build_s = float(report.get("build_cpu_s", 0))
    return Made(wall_s=time.wall_s, cpu_s=time.cpu_s, error=error, build_s=build_s)


def _equal_error(ours: Sequence[Made], theirs: Sequence[Made]) -> dict[str, Any]:
    """Their time to our error over our time, with its interval; both errors.

    A build of theirs is done once, however many samples follow; the samples are as many times more
    as their squared error is above ours.
    """
    pairs = list(zip(ours, theirs, strict=True))
    without = [(t.cpu_s - t.build_s) * t.error / (o.cpu_s * o.error) for o, t in pairs]
    whole = [w + t.build_s / o.cpu_s for w, (o, t) in zip(without, pairs, strict=True)]
    mean, low, high = log_interval(whole)
    made = {
        **{"equal_error": mean, "equal_error_low": low, "equal_error_high": high},
        "relative_rmse": float(np.sqrt(np.mean([o.error for o in ours]))),
        "baseline_relative_rmse": float(np.sqrt(np.mean([t.error for t in theirs]))),
    }
    if any(t.build_s for t in theirs):
        made["equal_error_without_build"] = log_interval(without)[0]
    return made


def _without_build(ours: Sequence[Made], theirs: Sequence[Made]) -> dict[str, Any]:
    """Their CPU seconds of building, and the ratio without them; nothing if they build nothing."""
    if not any(t.build_s for t in theirs):
        return {}
    rest = [(t.cpu_s - t.build_s) / o.cpu_s for o, t in zip(ours, theirs, strict=True)]
    build_s = statistics.median(t.build_s for t in theirs)
    return {"build_s": build_s, "ratio_without_build": statistics.median(rest)}


def _version(peer: Peer) -> str:
    return str(peer.about.get("version", "unknown"))


def _grey(image: Array) -> Array:
    return np.asarray(np.asarray(image, np.float64).reshape(*image.shape[:2], -1).mean(axis=2))


def _squared_error(reference: Array, image: Array) -> float:
    """Mean squared difference, of the squared mean of the reference."""
    return float(np.mean((image - reference) ** 2) / reference.mean() ** 2)
