"""Writing files atomically, and values as JSON."""

from __future__ import annotations

import math
import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any


@contextmanager
def whole_file(target: Path) -> Iterator[Path]:
    """A path beside the target to write to. At the end that file replaces the target.

    If the block raises, the target does not change. Every process and thread has its own path; the
    last one to finish wins.
    """
    partial = target.with_name(f".{target.name}.{os.getpid()}.{threading.get_ident()}.part")
    partial.unlink(missing_ok=True)  # left by a process that was killed
    try:
        yield partial
        partial.replace(target)
    finally:
        partial.unlink(missing_ok=True)


def write_whole(target: Path, text: str) -> None:
    """Write UTF-8 text."""
    with whole_file(target) as partial:
        partial.write_text(text, encoding="utf-8")


def finite(value: Any) -> Any:
    """The value for JSON: arrays as lists, non-finite numbers as null, anything else as text."""
    if isinstance(value, dict):
        return {str(k): finite(v) for k, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [finite(v) for v in value]
    if hasattr(value, "tolist"):
        return finite(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value if value is None or isinstance(value, (bool, int, float, str)) else str(value)
