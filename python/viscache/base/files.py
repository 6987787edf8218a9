"""Writing files atomically, and values as JSON."""

from __future__ import annotations

import hashlib
import math
import os
import socket
import stat
import threading
import tokenize
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from pathlib import Path
from typing import Any

#: What NumPy raises for files of arrays that are cut off or changed.
DAMAGED_ARRAYS = (
    ValueError,
    KeyError,
    TypeError,
    AttributeError,
    EOFError,
    OverflowError,
    OSError,
    RuntimeError,
    SyntaxError,
    tokenize.TokenError,
    zipfile.BadZipFile,
    zlib.error,
)


@contextmanager
def whole_file(
    target: Path, within: AbstractContextManager[object] | None = None
) -> Iterator[Path]:
    """A path beside the target to write to. At the end that file replaces the target.

    If the block raises, the target does not change. Every process and thread has its own path; the
    last one to finish wins. What processes of this machine left when they were killed is removed.
    `within` is entered for the moment in which the file takes its place; if it raises, it does not.
    """
    for left in _left_over(target):
        left.unlink(missing_ok=True)
    partial = target.with_name(
        f".{target.name}.{_machine()}.{os.getpid()}.{threading.get_ident()}.part"
    )
    partial.unlink(missing_ok=True)  # a link there would lead elsewhere
    try:
        yield partial
        with within or nullcontext():
            partial.replace(target)
    except OSError as error:
        if error.filename is not None:
            raise
        raise named(error, target) from error
    finally:
        partial.unlink(missing_ok=True)


def inside(folder: Path, name: str) -> Path:
    """The path of a file in a folder that may come from somebody else, and may be a link.

    The name has parts of this package, divided by "/", never what was read from a file. ValueError
    if the file, or a folder on the way to it, is a link, which may lead anywhere, or a device.
    """
    path = folder
    for part in name.split("/"):
        path = path / part
        try:
            mode = path.lstat().st_mode
        except (FileNotFoundError, NotADirectoryError):
            continue
        if not (stat.S_ISREG(mode) or stat.S_ISDIR(mode)):
            given = f"a link to {path.readlink()}" if stat.S_ISLNK(mode) else "a device or pipe"
            raise ValueError(f"{path} must be a file or folder of its own, got {given}; remove it")
    return path


def named(error: OSError, target: Path) -> OSError:
    """The error with the name of the file; those of writes have none."""
    if error.errno is None:  # NumPy's, of arrays
        return OSError(f"{target} cannot be written: {error}")
    return OSError(error.errno, error.strerror, str(target))


def _machine() -> str:
    """Short digest of this machine's name, as process numbers are those of a machine."""
    return hashlib.sha256(socket.gethostname().encode()).hexdigest()[:8]


def _left_over(target: Path) -> list[Path]:
    """Partial files of a target whose processes have ended."""
    start = f".{target.name}.{_machine()}."
    found = []
    for entry in os.scandir(target.parent):
        if entry.name.startswith(start) and entry.name.endswith(".part"):
            pid = entry.name.removeprefix(start).partition(".")[0]
            if pid.isdecimal() and not _runs(int(pid)):
                found.append(Path(entry.path))
    return found


def _runs(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    except OSError:
        pass
    return True


def write_whole(target: Path, text: str) -> None:
    """Write UTF-8 text."""
    with whole_file(target) as partial:
        partial.write_text(text, encoding="utf-8")


def about_exr(error: Exception) -> str:
    """What an error of OpenEXR says to a user; it calls any damage to the header a missing part."""
    text = str(error)
    return "it is damaged or incomplete" if text.startswith("Invalid part index") else text


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
