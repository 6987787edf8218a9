"""`viscache bench peers`: rays and pictures against other renderers, each in its environment."""

from __future__ import annotations

import statistics
from collections.abc import Callable, Mapping
from fnmatch import fnmatchcase
from functools import partial
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

import viscache as vc
from viscache.metrics import compare
from viscache_lab.bench.errors import log_interval
from viscache_lab.bench.peer_cases import PictureCase, Way, picture_cases
from viscache_lab.bench.peer_environments import default_folder, interpreter
from viscache_lab.bench.peers import PEERS, Peer, PeerError, missing_scene
from viscache_lab.bench.ray_sets import make_ray_set
from viscache_lab.bench.rays import EDGE_TOLERANCE
from viscache_lab.experiment import BENCHES, Trial
from viscache_lab.experiment.amounts import Sample, build_scene, interleave, timed

Array = npt.NDArray[Any]
Render = Callable[[int, int], vc.Frame]

#: Blocks of this many pixels are compared between converged frames.
BLOCK = 8
#: Mean difference of blocks of converged frames, of the mean of the picture.
AGREEMENT = 0.01


class Renderer(Protocol):
    """What a bench asks of a peer; see `peers.Peer`."""

    about: dict[str, Any]

    def give(self, **arrays: Any) -> None: ...
    def run(self, job: dict[str, Any]) -> tuple[Sample, dict[str, Any]]: ...
    def result(self) -> dict[str, Any]: ...


@BENCHES.add("peers", "rays and pictures against other renderers, each in its own environment")
def against_peers(trial: Trial) -> None:
    """Every case against every peer that there is; the others are skipped by name.

    Options: `environments`, the folder of `peer_environments.make_environments` (a peer without
    environment is looked for beside this package), and `only`, a pattern of file names for the
    names of cases.
    """
    folder, only = (trial.options.get(n) for n in ("environments", "only"))
    folder, only = folder or default_folder(), only or "*"
    turns = 3 if trial.quick else 6
    rays_of = {f"rays, {name}": name for name in ("room", "random_triangles")}
    cases = picture_cases(trial.quick)
    titles = [title for title in (*rays_of, *(c.name for c in cases)) if fnmatchcase(title, only)]
    if not titles:
        raise ValueError(f"no case of the bench peers is named like {only!r}")
    for title, name in rays_of.items():
        if title not in titles:
            continue
        scene = build_scene(f"{name}?triangles={5_000 if trial.quick else 200_000}")
        rays = 20_000 if trial.quick else 500_000
        _with_peers(
            trial,
            title,
            scene,
            folder,
            lambda made, found, title=title, scene=scene, rays=rays: compare_rays(  # type: ignore[misc]
                made, title, scene, found, rays, turns
            ),
        )
    for case in cases:
        if case.name not in titles:
            continue
        _with_peers(
            trial,
            case.name,
            case.scene,
            folder,
            lambda made, found, case=case: compare_pictures(  # type: ignore[misc]
                made, case, found, turns
            ),
        )
    trial.notes.append(
        "CPU seconds of all threads, after a warm-up. Converged frames agree, or there is no"
        " figure. Equal samples: their time over ours. Equal error: their time × squared error"
        " over ours, the geometric mean of the turns and its 95 % interval. What they build for a"
        " frame is in their time, but is not done again for more samples. Our frames are exact"
        " where no cache is named; rel_l1 of a cache is against our exact frame. Shared directions"
        " are traced exactly, too."
    )


def _with_peers(
    trial: Trial,
    name: str,
    scene: vc.Scene,
    folder: Path,
    run: Callable[[Trial, dict[str, Renderer]], None],
) -> None:
    """Start all peers that there are with a scene, compare, and end them.

    A peer that fails while sides take turns is left out, and the others are compared anew.
    """
    started: dict[str, Peer] = {}
    try:
        for peer, (package, _) in PEERS.items():
            python = interpreter(package, folder)
            why = f"{package} is not installed" if python is None else missing_scene(scene)
            if why is None:
                try:
                    started[peer] = Peer(peer, scene, python)
                except PeerError as error:
                    why = str(error)
            if why is not None:
                trial.skip(f"{name} vs {peer}", why)
        able: dict[str, Renderer] = dict(started)
        while True:
            made = Trial()
            try:
                run(made, able)
                break
            except PeerError as error:
                del able[error.peer]
                trial.skip(f"{name} vs {error.peer}", str(error))
        trial.extend(made)
    finally:
        for running in started.values():
            running.__exit__(None, None, None)


def compare_rays(
    trial: Trial, title: str, scene: vc.Scene, peers: Mapping[str, Renderer], n: int, turns: int
) -> None:
    """Any and nearest hits of `n` camera rays, and between points, from arrays to arrays."""
    for which in ("camera", "p2p"):
        r = make_ray_set(scene, which, n)
        asked: dict[str, Callable[[], Array]] = {
            "any_hit": lambda r=r: scene.occluded(  # type: ignore[misc]
                r.origins, r.directions, r.t_max
            ),
            "nearest": lambda r=r: (
                scene.intersect(  # type: ignore[misc]
                    r.origins, r.directions
                ).t
            ),
        }
        for job, ask in asked.items():
            reach = r.t_max if job == "any_hit" else np.inf
            runs: dict[str, Callable[[], Sample]] = {"ours": lambda ask=ask: timed(ask)[0]}  # type: ignore[misc]
            able = {k: p for k, p in peers.items() if job in p.about["jobs"]}
            for name, peer in able.items():
                peer.give(origins=r.origins, directions=r.directions, t_max=reach)
                runs[name] = lambda peer=peer, job=job: peer.run(  # type: ignore[misc]
                    {"job": job}
                )[0]
            samples = interleave(runs, turns)
            truth = ask()
            hit = truth if truth.dtype == bool else np.isfinite(truth)
            label = f"{title}, {which}, {job.replace('_', ' ')}"
            trial.check(f"{label}: none hit", float(not hit.any()), 0)
            for name, peer in able.items():
                differs = float(np.mean(_unlike(truth, peer.result(), name)))
                trial.check(f"{label}: share unlike {name}", differs, EDGE_TOLERANCE)
                if differs <= EDGE_TOLERANCE:
                    _figure(trial, f"{label} vs {name}", samples, name, peer, work=len(r))


def _unlike(ours: Array, theirs: Mapping[str, Array], name: str) -> Array:
    """Which rays are answered otherwise; distances may differ by rounding."""
    if "t" not in theirs:
        # embreex answers 0 where a ray is blocked, −1 where it is free
        found = np.asarray(theirs["occluded"])
        return np.asarray(ours != (found == 0 if name == "embreex" else found.astype(bool)))
    return np.asarray(~np.isclose(ours, theirs["t"], rtol=1e-3, atol=1e-4))


def compare_pictures(
    trial: Trial, case: PictureCase, peers: Mapping[str, Renderer], turns: int
) -> None:
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
        unlike = _difference(reference, peer.result()["image"])
        trial.check(f"{case.name}: converged frame unlike {name}'s", unlike, AGREEMENT)
        if not unlike <= AGREEMENT:
            del able[name]
    trial.check(f"{case.name}: black", float(not reference.mean() > 0), 0)
    errors: dict[str, list[float]] = {}
    builds: dict[str, list[float]] = {}
    runs: dict[str, Callable[[], Sample]] = {
        "ours": partial(_ours, case, case.render, reference, errors.setdefault("ours", []))
    }
    for way in case.ways:
        told = errors.setdefault(way.label, [])
        runs[way.label] = (
            partial(_biased, case, way, told)
            if way.biased
            else partial(_ours, case, way.render, reference, told)
        )
    for name, peer in able.items():
        lists = errors.setdefault(name, []), builds.setdefault(name, [])
        runs[name] = partial(_theirs, case, peer, reference, *lists)
    samples = interleave(runs, turns)
    # The first ones are those of the warm-up
    later = {name: found[1:] for name, found in errors.items()}
    built = {name: found[1:] for name, found in builds.items()}
    for name, peer in able.items():
        _figure(
            trial,
            f"{case.name} vs {name}",
            samples,
            name,
            peer,
            spp=case.spp,
            **_without_build(samples, built, "ours", name),
            **_equal_error(samples, later, built, "ours", name),
        )
        for way in case.ways:
            told = later[way.label]
            more = _without_build(samples, built, way.label, name) | (
                {"rel_l1": float(np.mean(told))}
                if way.biased
                else _equal_error(samples, later, built, way.label, name)
            )
            label = f"{case.name}, {way.label} vs {name}"
            _figure(trial, label, samples, name, peer, ours=way.label, spp=case.spp, **more)


def _ours(case: PictureCase, render: Render, reference: Array, errors: list[float]) -> Sample:
    frame = render(case.spp, len(errors))
    errors.append(_squared_error(reference, _grey(frame.image)))
    return Sample(wall_s=frame.timings["total_s"], cpu_s=frame.timings["cpu_s"])


def _biased(case: PictureCase, way: Way, errors: list[float]) -> Sample:
    seed = len(errors)
    frame, exact = way.render(case.spp, seed), case.render(case.spp, seed)
    error = compare(frame, exact, metrics=["rel_l1"])["rel_l1"]
    errors.append(np.nan if error is None else error)
    return Sample(wall_s=frame.timings["total_s"], cpu_s=frame.timings["cpu_s"])


def _theirs(
    case: PictureCase, peer: Renderer, reference: Array, errors: list[float], builds: list[float]
) -> Sample:
    time, report = peer.run({**case.job, "spp": case.spp, "seed": 5_000 + len(errors)})
    errors.append(_squared_error(reference, peer.result()["image"]))
    builds.append(float(report.get("build_cpu_s", 0)))
    return time


def _equal_error(
    samples: Mapping[str, list[Sample]],
    errors: Mapping[str, list[float]],
    builds: Mapping[str, list[float]],
    ours: str,
    theirs: str,
) -> dict[str, Any]:
    """Their time to our error over our time, with its interval; both errors.

    A build of theirs is done once, however many samples follow; the samples are as many times more
    as their squared error is above ours.
    """
    turns = list(
        zip(
            samples[ours],
            errors[ours],
            samples[theirs],
            errors[theirs],
            builds[theirs],
            strict=True,
        )
    )
    mean, low, high = log_interval(
        [(b + (t.cpu_s - b) * f / e) / o.cpu_s for o, e, t, f, b in turns]
    )
    made = {
        "equal_error": mean,
        "equal_error_low": low,
        "equal_error_high": high,
        "relative_rmse": float(np.sqrt(np.mean(errors[ours]))),
        "baseline_relative_rmse": float(np.sqrt(np.mean(errors[theirs]))),
    }
    if any(builds[theirs]):
        made["equal_error_without_build"] = log_interval(
            [(t.cpu_s - b) * f / (o.cpu_s * e) for o, e, t, f, b in turns]
        )[0]
    return made


def _without_build(
    samples: Mapping[str, list[Sample]], builds: Mapping[str, list[float]], ours: str, theirs: str
) -> dict[str, Any]:
    """Their CPU seconds of building, and the ratio without them; nothing if they build nothing."""
    if not any(builds[theirs]):
        return {}
    turns = zip(samples[ours], samples[theirs], builds[theirs], strict=True)
    return {
        "build_s": statistics.median(builds[theirs]),
        "ratio_without_build": statistics.median((t.cpu_s - b) / o.cpu_s for o, t, b in turns),
    }


def _figure(
    trial: Trial,
    label: str,
    samples: Mapping[str, list[Sample]],
    name: str,
    peer: Renderer,
    *,
    ours: str = "ours",
    **more: Any,
) -> None:
    version = str(peer.about.get("version", "unknown"))
    trial.ratio(label, samples[ours], samples[name], version=version, **more)


def _grey(image: Array) -> Array:
    return np.asarray(np.asarray(image, np.float64).reshape(*image.shape[:2], -1).mean(axis=2))


def _squared_error(reference: Array, image: Array) -> float:
    """Mean squared difference, of the squared mean of the reference."""
    return float(np.mean((image - reference) ** 2) / reference.mean() ** 2)


def _difference(reference: Array, image: Array) -> float:
    """Mean absolute difference of the means of blocks, of the mean of the reference."""

    def blocks(a: Array) -> Array:
        rows, columns = (s // BLOCK for s in a.shape)
        cut = a[: rows * BLOCK, : columns * BLOCK]
        return np.asarray(cut.reshape(rows, BLOCK, columns, BLOCK).mean(axis=(1, 3)))

    return float(np.mean(np.abs(blocks(image) - blocks(reference))) / reference.mean())
