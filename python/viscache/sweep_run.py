"""Works through a plan: renders what the store lacks, measures what is complete."""

from __future__ import annotations

import importlib
import pickle
import threading
import time
from collections import deque
from collections.abc import Callable
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ThreadPoolExecutor, wait
from typing import TYPE_CHECKING, Any, TypeAlias

from viscache import metrics as _metrics
from viscache import sources
from viscache.store import Store
from viscache.sweep_plan import Plan, Task
from viscache.sweep_table import columns_of, table_rows

if TYPE_CHECKING:
    from viscache.frame import Frame

Progress: TypeAlias = "bool | Callable[[int, int], None]"

#: Tests put a stand-in here; None is `viscache.render`.
render_function: Callable[..., Frame] | None = None


def render_task(task: Task, scene: Any = None) -> Frame:
    """Render one frame; runs in this process or in a worker."""
    render = render_function or importlib.import_module("viscache").render
    opened = scene if scene is not None else _opened(task)
    cpu = time.process_time()
    frame: Frame = render(
        opened, task.integrator, rays=task.rays, visibility=task.visibility, use=task.use,
        size=task.size, spp=task.spp, seed=task.seed, threads=task.threads, camera=task.camera,
        env=task.env,
    )  # fmt: skip
    # A thread of a pool shares the process's clock with its neighbours: no CPU time then.
    if threading.current_thread() is threading.main_thread():
        frame.timings.setdefault("cpu_s", time.process_time() - cpu)
    return frame


_LAST: list[tuple[Any, Any]] = []  # the worker's newest scene


def _opened(task: Task) -> Any:
    """The scene of a task, in a worker: the newest one is kept."""
    scene = task.scene
    if not isinstance(scene, str):
        return scene
    if not _LAST or _LAST[0][0] != scene:
        _LAST[:] = [(scene, sources.open_scene(scene))]
    opened = _LAST[0][1]
    if str(opened.content_hash) != task.scene_hash:
        raise ValueError(f"scene {scene} is not the one the sweep began with (its content differs)")
    return opened


def _check_travels(scene: Any) -> None:
    """ValueError where a scene cannot be sent to the workers of an executor."""
    try:
        pickle.dumps(scene)
    except (TypeError, AttributeError, pickle.PicklingError) as error:
        raise ValueError(
            "scene must be a file or a built-in name when an executor's workers render it,"
            f" got {scene!r}"
        ) from error


class Run:
    """Works through a plan: render what is missing, compare what is complete."""

    def __init__(self, plan: Plan, store: Store, scene: Any, progress: Progress) -> None:
        self.plan, self.store, self.scene = plan, store, scene
        self.order = plan.order()
        self.todo = deque(k for k in self.order if store.get(k) is None)
        self.open = list(plan.points)
        self.progress = progress
        self.bar: Any = None

    def go(self, executor: Executor | None) -> None:
        if self.progress is True:
            from tqdm import tqdm

            done = len(self.order) - len(self.todo)
            self.bar = tqdm(total=len(self.order), initial=done, unit="frame", desc="sweep")
        try:
            self.compare()
            if executor is None:
                self.serial()
            else:
                self.parallel(executor)
        finally:
            if self.bar is not None:
                self.bar.close()
            self.table()

    def serial(self) -> None:
        foreign = 0
        while self.todo:
            key = self.todo.popleft()
            if self.store.get(key) is not None:
                self.finished()
                foreign = 0
            elif self.store.claim(key):
                try:
                    self.keep(key, render_task(self.plan.tasks[key], self.scene))
                finally:
                    self.store.release(key)
                foreign = 0
            else:  # another process renders it
                self.todo.append(key)
                foreign += 1
                if foreign >= len(self.todo):
                    time.sleep(0.2)

    def parallel(self, executor: Executor) -> None:
        scene = self.scene if isinstance(executor, ThreadPoolExecutor) else None
        if scene is None:
            _check_travels(next(iter(self.plan.tasks.values())).scene)
        window = 2 * int(getattr(executor, "_max_workers", 0) or 16)
        flying: dict[Future[Frame], str] = {}
        try:
            while self.todo or flying:
                for _ in range(len(self.todo)):
                    if len(flying) >= window:
                        break
                    key = self.todo.popleft()
                    if self.store.get(key) is not None:
                        self.finished()
                    elif self.store.claim(key):
                        flying[executor.submit(render_task, self.plan.tasks[key], scene)] = key
                    else:
                        self.todo.append(key)
                ready, _ = wait(list(flying), timeout=0.5, return_when=FIRST_COMPLETED)
                failures = []
                for future in ready:  # what is finished is kept before an error is raised
                    key, failure = flying.pop(future), future.exception()
                    if failure is not None:
                        self.store.release(key)
                        failures.append(failure)
                    else:
                        self.keep(key, future.result())
                if failures:
                    raise failures[0]
                if not flying and self.todo:
                    time.sleep(0.2)
        finally:
            for future, key in flying.items():
                future.cancel()
                self.store.release(key)

    def keep(self, key: str, frame: Frame) -> None:
        self.store.put(key, self.plan.specs[key], frame)
        self.finished()

    def finished(self) -> None:
        if self.bar is not None:
            self.bar.update()
        elif callable(self.progress):
            self.progress(len(self.order) - len(self.todo), len(self.order))
        self.compare()

    def compare(self) -> None:
        """Measure every point whose frames are all there, then rewrite the table."""
        complete = []
        for point in self.open:
            keys = [k for k in (point.key, point.paired, point.converged) if k is not None]
            if all(self.store.get(k) is not None for k in keys):
                self.measure(point.key, point.paired)
                if point.converged is not None:
                    self.measure(point.key, point.converged)
                    self.measure(point.paired, point.converged)
                complete.append(point)
        if complete:
            self.open = [p for p in self.open if p not in complete]
            if self.store.directory is None:
                needed = {k for p in self.open for k in (p.key, p.paired, p.converged)}
                for key in self.order:
                    if key not in needed:
                        self.store.forget_pixels(key)
            self.table()

    def measure(self, key: str, reference: str) -> None:
        known = self.store.compared(key, reference)
        missing = [m for m in self.plan.metrics if m not in known]
        if not missing:
            return
        a, b = self.store.frame(key), self.store.frame(reference)
        values = dict(_metrics.compare(a, b, metrics=missing))
        groups = [g for g in a.counters.get("groups", {}) if g in a.layers and g in b.layers]
        for group in groups:
            pair = (a.layers[group], b.layers[group])
            values[f"rel_l1/{group}"] = _metrics.compare(*pair, metrics=["rel_l1"])["rel_l1"]
        self.store.put_comparison(key, reference, values)

    def table(self) -> None:
        rows = table_rows(self.store)
        self.store.write_csv(rows, columns_of(rows, self.plan.names, self.plan.metrics))
