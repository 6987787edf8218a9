"""What is written to files: whole or not at all, and as values that JSON has."""

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
    """A path beside the target to write to; at the end that file takes the target's place.

    Where the block raises, the target stays as it was. Processes and threads get paths of their
    own: the last one to end wins.
    """
    partial = target.with_name(f".{target.name}.{os.getpid()}.{threading.get_ident()}.part")
    partial.unlink(missing_ok=True)  # of a process that was killed
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
    """The same as plain JSON values: arrays as lists, non-finite numbers as null, else text."""
    if isinstance(value, dict):
        return {str(k): finite(v) for k, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [finite(v) for v in value]
    if hasattr(value, "tolist"):
        return finite(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value if value is None or isinstance(value, (bool, int, float, str)) else str(value)
