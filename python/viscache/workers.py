"""Executors for tasks, and what a worker keeps from one task to the next."""

from __future__ import annotations

import importlib
import multiprocessing
import os
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import AbstractContextManager, contextmanager, nullcontext
from typing import Any

__all__ = ["dask_executor", "process_pool", "window"]

#: Tasks under way where an executor does not say how many workers it has.
UNKNOWN_WINDOW = 32
#: How long a dask scheduler may take to answer.
DASK_TIMEOUT = "20s"


def window(executor: Executor) -> int:
    """How many tasks to keep under way: two per worker, so that none waits for its next one."""
    client = getattr(executor, "_client", None)  # of dask; workers come and go
    if client is not None:
        return 2 * max(1, int(sum(client.ncores().values())))
    workers = int(getattr(executor, "_max_workers", 0) or 0)
    return 2 * workers if workers else UNKNOWN_WINDOW


def process_pool(workers: int) -> AbstractContextManager[Executor | None]:
    """A pool of processes that end with this one; None for one worker, this process itself."""
    if workers == 1:
        return nullcontext()
    # spawn: a forked child would inherit Embree's and our threads in an unknown state
    context = multiprocessing.get_context("spawn")
    return ProcessPoolExecutor(workers, mp_context=context, initializer=end_with_parent)


@contextmanager
def dask_executor(address: str) -> Iterator[Executor]:
    """The workers of a dask scheduler.

    A task whose worker dies is done again by another one; three deaths over one task are an error.

    Raises
    ------
    ValueError
        dask.distributed is absent, or nothing answers at the address.
    """
    try:
        distributed: Any = importlib.import_module("dask.distributed")
    except ImportError as error:
        raise ValueError(
            "--dask needs dask.distributed: pip install 'viscache[distributed]'"
        ) from error
    try:
        client = distributed.Client(address, timeout=DASK_TIMEOUT, set_as_default=False)
    except (OSError, ValueError) as error:
        raise ValueError(f"no dask scheduler answers at {address}: {error}") from error
    with client:
        # Tasks are keyed by our store, not by a hash of their arguments
        yield client.get_executor(pure=False)


def end_with_parent() -> None:
    """In a worker: end at once when the process that made it has ended, killed or not."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_leave_after, args=(parent.join,), daemon=True).start()


def _leave_after(wait: Callable[[], None]) -> None:
    wait()
    os._exit(1)


class Newest:
    """The newest thing made, so that a worker makes it once and not once per task."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._kept: tuple[Any, Any] | None = None

    def get(self, key: Any, make: Callable[[], Any]) -> Any:
        """What was made for this key last, else what `make` makes now."""
        with self._lock:
            if self._kept is None or self._kept[0] != key:
                self._kept = None  # before the next one takes memory
                self._kept = (key, make())
            return self._kept[1]
