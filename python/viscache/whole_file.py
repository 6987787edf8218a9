"""Files that are there whole or not at all, whatever ends the process that writes them."""

from __future__ import annotations

import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


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
