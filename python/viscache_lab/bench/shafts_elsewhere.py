"""`viscache bench shafts-elsewhere`: shafts against packets for points of arrays."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

import viscache as vc
from viscache.correlation.rows import SurfacePoints, surface_points
from viscache.scene.queries import shaft_matrix, visible_matrix
from viscache_lab.experiment import BENCHES, Trial
from viscache_lab.experiment.amounts import turns
from viscache_lab.experiment.trial import opened

Engine = Literal["packets", "shafts", "auto"]
ENGINES: tuple[Engine, ...] = ("packets", "shafts", "auto")
Places = Literal["seen", "space", "surface"]
Bits = npt.NDArray[np.uint64]
#: Bits, and what shafts did.
Answer = tuple[Bits, dict[str, Any]]


@dataclass(frozen=True)
class Case:
    """Points of one scene against targets of it.

    "seen" points are those of a camera's image, "surface" points lie anywhere on surfaces, "space"
    points anywhere in the scene's box.
    """

    scene: str
    call: Literal["visible_matrix", "block"]
    points: Places
    n_points: int
    targets: Places
    n_targets: int

    @property
    def name(self) -> str:
        """In words."""
        scene = self.scene.split("?")[0].split("/")[0]
        ends = f"{self.n_points:,} {self.points} × {self.n_targets} {self.targets}"
        return f"{scene}, {self.call}, {ends}"


ROOM, SPONZA, LIVING = (
    "room?triangles=200000",
    "sponza-dabrovic/scene.xml",
    "living-room/scene.xml",
)
CASES = (
    Case(ROOM, "visible_matrix", "seen", 400_000, "space", 64),
    Case(ROOM, "visible_matrix", "seen", 400_000, "surface", 64),
    Case(ROOM, "visible_matrix", "space", 400_000, "surface", 64),
    Case(ROOM, "visible_matrix", "seen", 30_000, "surface", 512),
    Case(ROOM, "visible_matrix", "seen", 400_000, "space", 8),
    Case(ROOM, "visible_matrix", "space", 64, "space", 100_000),
    Case(SPONZA, "visible_matrix", "seen", 400_000, "surface", 64),
    Case(LIVING, "visible_matrix", "seen", 400_000, "surface", 64),
    Case("apartment", "visible_matrix", "seen", 400_000, "surface", 64),
    Case(ROOM, "block", "seen", 400_000, "space", 128),
    Case(ROOM, "block", "seen", 400_000, "surface", 128),
    Case(ROOM, "block", "seen", 30_000, "surface", 512),
    Case(SPONZA, "block", "seen", 400_000, "surface", 128),
    Case("apartment", "block", "seen", 400_000, "surface", 128),
)
SMALL = "room?triangles=3000"
QUICK = (
    Case(SMALL, "visible_matrix", "seen", 5000, "surface", 70),
    Case(SMALL, "block", "seen", 5000, "surface", 70),
)


@BENCHES.add(
    "shafts-elsewhere", "visible_matrix and oracle.block by shafts against packets of rays"
)
def shafts_elsewhere(trial: Trial) -> None:
    """CPU seconds of `visible_matrix` and `oracle.block`, one thread; bits must be equal."""
    scenes: dict[str, vc.Scene | None] = {}
    for case in QUICK if trial.quick else CASES:
        if case.scene not in scenes:
            scenes = {case.scene: opened(case.scene)}  # one at a time
        scene = scenes[case.scene]
        if scene is None:
            trial.skip(case.name, "VISCACHE_SCENES has no such file")
        else:
            measure(trial, case, scene, 1 if trial.quick else 3)
    trial.notes.append(
        "Whole calls from NumPy to NumPy, one thread, without the tree of the scene. open: share of"
        " queries that rays answer; left: share that shafts were not asked."
    )


def measure(trial: Trial, case: Case, scene: vc.Scene, repeats: int) -> None:
    """Let the engines take turns, and compare their bytes."""
    asked = Asked(scene, case)
    points, targets = asked.ends
    queries = len(points) * len(targets)
    scene.caster()
    scene.shafts().memory_bytes()  # builds the tree
    taken = turns({e: partial(asked.answer, e) for e in ENGINES}, repeats, warm_up=repeats > 1)
    samples, found = taken.samples, taken.answers
    bits = found["packets"][0]
    for engine in ENGINES[1:]:
        other, work = found[engine]
        by_shafts = work.get("shaft_queries", 0)
        traced = work.get("shaft_doubted", 0) + work.get("shaft_long_lists", 0)
        trial.ratio(
            f"{case.name}: {engine} vs packets",
            samples[engine],
            samples["packets"],
            nanoseconds_per_query=1e9 * min(s.cpu_s for s in samples[engine]) / queries,
            packets_nanoseconds=1e9 * min(s.cpu_s for s in samples["packets"]) / queries,
            open=traced / max(1, by_shafts),
            left=1 - by_shafts / queries,
        )
        differ = int(np.unpackbits((bits ^ other).view(np.uint8)).sum())
        trial.check(f"{case.name}: {engine}, bits that differ", differ, 0)


@dataclass(frozen=True)
class Asked:
    """The arrays of a case."""

    scene: vc.Scene
    case: Case

    @cached_property
    def points(self) -> SurfacePoints | None:
        """The points, with normals, where they are on surfaces."""
        return self._on_surfaces(self.case.points, self.case.n_points, 1)

    @cached_property
    def targets(self) -> SurfacePoints | None:
        """The targets, likewise."""
        return self._on_surfaces(self.case.targets, self.case.n_targets, 2)

    @cached_property
    def ends(self) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]:
        """Positions of points and targets."""
        one, other = self.points, self.targets
        return (
            self._in_space(self.case.n_points, 3) if one is None else one.positions,
            self._in_space(self.case.n_targets, 4) if other is None else other.positions,
        )

    def answer(self, engine: Engine) -> Answer:
        """One call."""
        if self.case.call == "block":
            return self._block(engine)
        caster, shafts = self.scene.caster(), self.scene.shafts()
        if engine == "packets":
            return visible_matrix(caster, *self.ends, 1, False), {}
        return shaft_matrix(shafts, caster, *self.ends, 1, False, choose=engine == "auto")

    def _block(self, engine: Engine) -> Answer:
        points, targets = self.points, self.targets
        assert points is not None
        if targets is None:
            ends = vc.FarEnds.points(self.ends[1])
        else:
            ends = vc.FarEnds.surfaces(targets.positions, targets.normals)
        exact = vc.Exact(engine=engine, order="by_light", coherent=True)
        eyes = vc.EyePoints(points.positions, points.normals)
        answer = self.scene.oracle(exact, threads=1).block(eyes, ends)
        return answer.bits, answer.engine

    def _on_surfaces(self, places: Places, count: int, seed: int) -> SurfacePoints | None:
        if places == "space":
            return None
        kind: Literal["camera", "area"] = "camera" if places == "seen" else "area"
        return surface_points(self.scene, max(count, 16), points=kind, seed=seed)

    def _in_space(self, count: int, seed: int) -> npt.NDArray[np.float32]:
        low, high = self.scene.bounds
        return np.random.default_rng(seed).uniform(low, high, (count, 3)).astype(np.float32)
