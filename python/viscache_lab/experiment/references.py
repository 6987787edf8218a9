"""Converged reference pictures, which the figures of a folder share."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path

from viscache.sweeps.exact_frames import ExactFrames

_FRAMES: ContextVar[ExactFrames] = ContextVar("references")


@contextmanager
def kept_in(folder: Path) -> Iterator[None]:
    """In this context `exact_frames` stores its frames in a folder."""
    token = _FRAMES.set(ExactFrames(folder))
    try:
        yield
    finally:
        _FRAMES.reset(token)


def exact_frames() -> ExactFrames:
    """The frames of the context; do not use them for timings."""
    return _FRAMES.get(ExactFrames(None))
