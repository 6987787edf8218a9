"""Progress of long calls: a bar in terminal and notebook, or a callable."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import count
from typing import TypeAlias

#: The argument `progress`: True shows a bar, a callable gets (done, total).
Progress: TypeAlias = bool | Callable[[int, int], None]


@contextmanager
def progress_bar(
    progress: Progress, unit: str = "tile"
) -> Iterator[Callable[[int, int], None] | None]:
    """A function of (done, total) for the core, or None."""
    if callable(progress):
        yield progress
        return
    if not progress:
        yield None
        return
    from tqdm.auto import tqdm

    with tqdm(unit=unit, leave=False) as bar:

        def report(done: int, total: int) -> None:
            if bar.total != total:
                bar.reset(total)
            bar.update(done - bar.n)

        yield report


@contextmanager
def step_bar(progress: Progress, total: int, unit: str) -> Iterator[Callable[[], None]]:
    """A function to call after each of so many steps."""
    done = count(1)
    with progress_bar(progress, unit) as report:
        yield lambda: None if report is None else report(next(done), total)
