"""What made a frame: versions and settings, but nothing that identifies the machine."""

from __future__ import annotations

import datetime
import hashlib
import os
import platform
from functools import cache
from pathlib import Path
from typing import Any

from viscache import _core

#: The version of viscache.
VERSION = "0.1.0"


def embree_version() -> str:
    """Version of the Embree library in use."""
    return str(_core.embree_version())


def isa() -> tuple[str, str]:
    """(variant of the kernels in use, best variant this CPU has)."""
    return (str(_core.active_isa()), str(_core.best_isa()))


def thread_count(threads: int | None = None) -> int:
    """`threads`, or the number of processors this process may use."""
    return threads if threads else len(os.sched_getaffinity(0))


@cache
def cpu_model() -> str:
    """Name of the processor, "unknown" if the system does not tell."""
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as lines:  # noqa: PTH123
            for line in lines:
                if line.startswith("model name"):
                    return line.split(":", 1)[1].strip()
    except OSError:
        pass
    return platform.processor() or "unknown"


def provenance(threads: int | None = None) -> dict[str, Any]:
    """Versions, ISA variant, threads and date of a frame made now; JSON-able."""
    import numpy

    return {
        "viscache": VERSION,
        "numpy": numpy.__version__,
        "python": platform.python_version(),
        "embree": embree_version(),
        "isa": isa()[0],
        "threads": thread_count(threads),
        "date": datetime.datetime.now(datetime.timezone.utc).isoformat(timespec="seconds"),
    }


@cache
def code_hash(more: Path | None = None) -> str:
    """Hash of the code that determines a frame: the package's sources and core, and a folder's.

    Of the folder, tables (`.csv`) count, too.
    """
    package = Path(__file__).parents[1]
    files = [Path(_core.__file__), *sorted(package.rglob("*.py"))]
    if more is not None:
        files += sorted(file for file in more.rglob("*") if file.suffix in (".py", ".csv"))
    digest = hashlib.sha256()
    for file in files:
        digest.update(file.name.encode() + hashlib.sha256(file.read_bytes()).digest())
    return digest.hexdigest()
