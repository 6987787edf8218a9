"""Runs a plan: renders the frames that the store lacks, and compares complete points."""

from __future__ import annotations

import socket
import time
from collections import Counter, OrderedDict, defaultdict, deque
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ThreadPoolExecutor, wait
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from viscache import metrics as _metrics
from viscache.base import workers
from viscache.base.formats import FormatError
from viscache.base.progress import Progress
from viscache.sweeps.flip_maps import flip_map_of
from viscache.sweeps.leases import LostLeaseError
from viscache.sweeps.plan import Plan, Point
from viscache.sweeps.store import Store
from viscache.sweeps.table import TableFile
from viscache.sweeps.work import render_task

if TYPE_CHECKING:
    from viscache.frame import Frame


#: Number of frames kept in memory, because a few references serve many points.
RECENT = 6
#: Seconds between checks for results of other processes.
POLL_S = 0.05


class Run:
    """Runs a plan; `references` is a store of finished ones that several sweeps share.

    `apart` renders one frame at a time on this machine, for any executor and any number of
    processes that use the store, so that frames do not disturb each other's timings.
    """

    def __init__(
        self,
        plan: Plan,
        store: Store,
        scene: Any,
        progress: Progress,
        *,
        apart: bool,
        references: Store | None = None,
    ) -> None:
        self.plan, self.store, self.scene = plan, store, scene
        self.progress, self.apart, self.references = progress, apart, references
        self.leases = store.leases
        self.order = plan.order()
        self.total = len(self.order)
        self.is_reference = {k for p in plan.points for k in (p.paired, p.converged) if k}
        self._adopt()
        #: Pairs whose FLIP maps a report shows.
        self.shown = {(p.key, p.paired) for p in plan.points if p.repeat == 0}
        self.done = store.finished() & set(self.order)
        self.todo = deque(k for k in self.order if k not in self.done)
        self.lacks = [sum(k not in self.done for k in _keys(p)) for p in plan.points]
        self.waiting: dict[str, list[int]] = defaultdict(list)
        for number, point in enumerate(plan.points):
            for key in _keys(point):
                self.waiting[key].append(number)
        self.uses = Counter(k for p in plan.points for k in _keys(p))
        self.recent: OrderedDict[str, Frame] = OrderedDict()
        self.table = TableFile(store, plan.names, plan.metrics)
        self.bar: Any = None
        #: A line for each damaged picture of the store that was rendered again.
        self.mended: list[str] = []
        #: Frames among these whose pixels are not those of the damaged one's record.
        self.void: set[str] = set()
        self.writer = ThreadPoolExecutor(1, thread_name_prefix="sweep-writer")
        #: Comparisons of frames whose files are not complete; they are stored later.
        self.ahead: dict[tuple[str, str], dict[str, float | None]] = {}
        #: Wall seconds of this process, and those of frames, wherever they were rendered.
        self.seconds = {"frames": 0.0, "metrics": 0.0, "store": 0.0, "total": 0.0}

    def go(self, executor: Executor | None) -> None:
        if self.progress is True:
            from tqdm import tqdm

            self.bar = tqdm(total=self.total, initial=len(self.done), unit="frame", desc="sweep")
        began = time.perf_counter()
        try:
            for number, lacks in enumerate(self.lacks):
                if lacks == 0:
                    self._complete(number)
            self.table.rewrite()
            if executor is None:
                self.serial()
            else:
                self.parallel(executor)
            self._compare_again()
        finally:
            self.writer.shutdown()
            if self.bar is not None:
                self.bar.close()
            self.table.rewrite()
            self.seconds["total"] = time.perf_counter() - began

    def serial(self) -> None:
        foreign = 0
        while self.todo:
            key = self.todo.popleft()
            if not self.leases.claim(key):  # another process renders it
                self.todo.append(key)
                foreign += 1
                if foreign >= len(self.todo):
                    self.leases.wait(4 * POLL_S)
                continue
            foreign = 0
            try:
                if self._finished_elsewhere(key):
                    continue
                with self._alone() as was_alone:
                    began = time.perf_counter()
                    frame = render_task(self.plan.tasks[key], self.scene)
                    self.seconds["frames"] += time.perf_counter() - began
                    alone = was_alone()
                self.keep(key, frame, alone=alone)
            finally:
                self.leases.release(key)

    def _finished_elsewhere(self, key: str) -> bool:
        """Take over a claimed frame that another process finished before the claim.

        The look-up follows the claim: a frame that is absent while it is claimed is rendered once.
        """
        if self.store.get(key) is None:
            return False
        self.leases.release(key)
        self.finished(key)
        return True

    def parallel(self, executor: Executor) -> None:
        scene = self.scene if isinstance(executor, ThreadPoolExecutor) else None
        flying: dict[Future[Frame], str] = {}
        try:
            while self.todo or flying:
                limit = 1 if self.apart else workers.window(executor)
                for _ in range(len(self.todo)):
                    if len(flying) >= limit:
                        break
                    key = self.todo.popleft()
                    if not self.leases.claim(key):
                        self.todo.append(key)
                    elif not self._finished_elsewhere(key):
                        flying[executor.submit(render_task, self.plan.tasks[key], scene)] = key
                self._gather(flying)
                if not flying and self.todo:
                    self.leases.wait(4 * POLL_S)
        finally:
            for future, key in flying.items():
                future.cancel()
                self.leases.release(key)

    def _gather(self, flying: dict[Future[Frame], str]) -> None:
        """Keep finished frames, then raise the first error."""
        ready, _ = wait(list(flying), timeout=0.5, return_when=FIRST_COMPLETED)
        failures = []
        for future in ready:
            key, failure = flying.pop(future), future.exception()
            if failure is not None:
                self.leases.release(key)
                failures.append(failure)
            else:
                frame = future.result()
                self.seconds["frames"] += frame.timings.get("total_s", 0.0)
                self.keep(key, frame, alone=self.apart)
        if failures:
            raise failures[0]

    @contextmanager
    def _alone(self) -> Iterator[Callable[[], bool]]:
        """While no other process at this store renders on this machine, where that is wanted.

        Gives a function that says at the end whether it was so.
        """
        if not self.apart or self.store.directory is None:
            yield lambda: self.apart
            return
        turn = f"turn of {socket.gethostname()}"
        while not self.leases.claim(turn):
            self.leases.wait(POLL_S)
        try:
            yield lambda: self.leases.holds(turn)
        finally:
            self.leases.release(turn)

    def keep(self, key: str, frame: Frame, *, alone: bool) -> None:
        """Store a frame and compare the points that wait for it, while its file is written.

        If this process stood so long that another one took the frame over, it waits for that one.
        """
        frame.provenance["alone"] = alone
        self._remember(key, frame)
        writing = self.writer.submit(self.store.put, key, self.plan.tasks[key].parts, frame)
        try:
            self._measure_ahead(key)
        finally:
            began = time.perf_counter()
            lost = isinstance(writing.exception(), LostLeaseError)
            if not lost:
                writing.result()
            if not lost and self.references is not None and key in self.is_reference:
                self.references.adopt(key, self.store)
            self.seconds["store"] += time.perf_counter() - began
        if lost:
            self.recent.pop(key, None)
            self.ahead = {pair: v for pair, v in self.ahead.items() if key not in pair}
            self.todo.append(key)
        else:
            self.finished(key)

    def _measure_ahead(self, key: str) -> None:
        """Compare points that this frame completes. The results are stored after its file."""
        for number in self.waiting[key]:
            if self.lacks[number] == 1:
                for pair in _pairs(self.plan.points[number]):
                    if key in pair and pair not in self.ahead:
                        self.ahead[pair] = self._values(*pair, self.plan.metrics)

    def finished(self, key: str) -> None:
        """Measure the points that wait for this frame alone."""
        self.done.add(key)
        if self.bar is not None:
            self.bar.update()
        elif callable(self.progress):
            self.progress(len(self.done), self.total)
        for number in self.waiting[key]:
            self.lacks[number] -= 1
            if self.lacks[number] == 0:
                self._complete(number)
                self.table.append(self.plan.points[number])

    def _complete(self, number: int) -> None:
        point = self.plan.points[number]
        for key, reference in _pairs(point):
            self.measure(key, reference)
        for key in _keys(point):
            self.uses[key] -= 1
            if self.uses[key] == 0:
                self.recent.pop(key, None)
                if self.store.directory is None:
                    self.store.forget_pixels(key)

    def measure(self, key: str, reference: str) -> None:
        """Store the comparison of two frames."""
        values = self.ahead.pop((key, reference), None)
        if values is None:
            known = self.store.compared(key, reference)
            missing = [m for m in self.plan.metrics if m not in known]
            if not missing:
                return
            values = self._values(key, reference, missing)
        began = time.perf_counter()
        self.store.put_comparison(key, reference, values)
        self.seconds["store"] += time.perf_counter() - began

    def _values(self, key: str, reference: str, metrics: list[str]) -> dict[str, float | None]:
        """These metrics of a frame against a reference, and each light group's error."""
        began = time.perf_counter()
        a, b = self._frame(key), self._frame(reference)
        read = time.perf_counter()
        values: dict[str, float | None] = {}
        groups = [g for g in a.counters.get("groups", {}) if g in a.layers and g in b.layers]
        for group in groups:
            pair = (a.layers[group], b.layers[group])
            values[f"rel_l1/{group}"] = _metrics.compare(*pair, metrics=["rel_l1"])["rel_l1"]
        values |= _metrics.compare(a, b, metrics=[m for m in metrics if m != "flip"])
        # FLIP last: it holds the interpreter, and the picture's writer must have begun by then
        if "flip" in metrics:
            shown = (key, reference) in self.shown
            found = flip_map_of(a, b, self.store.directory if shown else None)
            values["flip"] = None if found is None else found.mean
        self.seconds["metrics"] += time.perf_counter() - read
        self.seconds["store"] += read - began
        return values

    def _frame(self, key: str) -> Frame:
        if key not in self.recent:
            try:
                frame = self.store.frame(key)
            except FormatError as error:
                frame = self._made_anew(key, str(error))
            self._remember(key, frame)
        self.recent.move_to_end(key)
        return self.recent[key]

    def _made_anew(self, key: str, reason: str) -> Frame:
        """Render a frame whose picture in the store is damaged, and replace the picture."""
        record = self.store.get(key)
        frame = render_task(self.plan.tasks[key], self.scene)
        frame.provenance["alone"] = False
        self.mended.append(f"{reason.partition('; delete')[0]}: rendered again")
        if record is not None and not record.changed(frame):
            self.store.replace_picture(key, frame)
        else:  # comparisons with the old picture are void
            self.store.put(key, self.plan.tasks[key].parts, frame)
            self.void.add(key)
        return frame

    def _compare_again(self) -> None:
        """Compare complete points with frames that are not what they were."""
        while self.void:
            key = self.void.pop()
            for number in self.waiting[key]:
                if self.lacks[number] == 0:
                    for pair in _pairs(self.plan.points[number]):
                        self.measure(*pair)

    def _remember(self, key: str, frame: Frame) -> None:
        self.recent[key] = frame
        while len(self.recent) > RECENT:
            self.recent.popitem(last=False)

    def _adopt(self) -> None:
        if self.references is not None:
            for key in self.is_reference:
                self.store.adopt(key, self.references)


def _pairs(point: Point) -> list[tuple[str, str]]:
    """What a point compares: (frame, reference)."""
    if point.converged is None:
        return [(point.key, point.paired)]
    return [
        (point.key, point.paired),
        (point.key, point.converged),
        (point.paired, point.converged),
    ]


def _keys(point: Point) -> list[str]:
    return [k for k in dict.fromkeys((point.key, point.paired, point.converged)) if k is not None]
