"""What made a frame: versions and settings, but nothing that identifies the machine."""

from __future__ import annotations

import datetime
import hashlib
import os
import platform
from functools import cache
from pathlib import Path
from typing import Any

#: The version of viscache.
VERSION = "0.1.0"


def _core() -> Any:
    try:
        from viscache import _core as core  # type: ignore[attr-defined,unused-ignore]
    except ImportError:
        return None
    return core


def embree_version() -> str:
    """Version of the Embree library in use, "unknown" if the core does not have it."""
    value = getattr(_core(), "embree_version", None)
    return str(value() if callable(value) else value) if value is not None else "unknown"


def isa() -> tuple[str, str]:
    """(variant of the kernels in use, best variant this CPU has)."""
    core = _core()
    if core is None:
        return ("unknown", "unknown")
    return (str(core.active_isa()), str(core.best_isa()))


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
def code_hash() -> str:
    """Hash of the code that determines a frame or a figure: the package's sources and its core."""
    package = Path(__file__).parent
    files = [Path(_core().__file__), *sorted(package.rglob("*.py"))]
    digest = hashlib.sha256()
    for file in files:
        digest.update(file.name.encode() + hashlib.sha256(file.read_bytes()).digest())
    return digest.hexdigest()
