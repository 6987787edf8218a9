"""Executors."""

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

#: Number of submitted tasks if an executor does not tell its number of workers.
UNKNOWN_WINDOW = 32
#: Timeout for a dask scheduler.
DASK_TIMEOUT = "20s"


def window(executor: Executor) -> int:
    """Number of tasks to submit at a time: two per worker, so that no worker waits."""
    client = getattr(executor, "_client", None)  # of dask; workers come and go
    if client is not None:
        return 2 * max(1, int(sum(client.ncores().values())))
    workers = int(getattr(executor, "_max_workers", 0) or 0)
    return 2 * workers if workers else UNKNOWN_WINDOW


def process_pool(workers: int) -> AbstractContextManager[Executor | None]:
    """A pool of processes that end with this process; None for one worker."""
    if workers == 1:
        return nullcontext()
    # spawn: a forked process would inherit threads of Embree and viscache in an unknown state
    context = multiprocessing.get_context("spawn")
    return ProcessPoolExecutor(workers, mp_context=context, initializer=end_with_parent)


@contextmanager
def dask_executor(address: str) -> Iterator[Executor]:
    """The workers of a dask scheduler.

    If a worker dies, another worker repeats its task. If three die with one task, it is an error.

    Raises
    ------
    ValueError
        dask.distributed is not installed, or there is no scheduler at the address.
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
        # The store keys tasks, so dask must not key them by their arguments
        yield client.get_executor(pure=False)


def end_with_parent() -> None:
    """End this worker as soon as its parent process ends or is killed."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_leave_after, args=(parent.join,), daemon=True).start()


def _leave_after(wait: Callable[[], None]) -> None:
    wait()
    os._exit(1)
