"""The memory that a frame takes, and whether there is as much."""

from __future__ import annotations

import resource
from pathlib import Path
from typing import Any

from viscache.settings.integrators import AmbientOcclusion, Bdpt

#: Frames of fewer pixels are not looked at: they take less than half a GB.
SMALL_PX = 1 << 22
#: Layers of every frame: color, emitted, normal and albedo; depth and coverage.
CHANNELS = 4 * 3 + 2
#: The core's layers are copied once, into arrays of 4 bytes per channel.
BYTES_PER_CHANNEL = 2 * 4
CGROUP = Path("/sys/fs/cgroup")


def frame_bytes(
    scene: Any, integrator: Any, size: tuple[int, int], *, corrects: bool = False
) -> int:
    """Peak of the memory of a frame's layers; corrected answers add one of variances."""
    if isinstance(integrator, AmbientOcclusion):
        groups = 1
    else:
        groups = len({_group(light["kind"]) for light in scene.lights})
        groups += bool(getattr(integrator, "n_vpls", 0)) + 2 * isinstance(integrator, Bdpt)
    channels = CHANNELS + 3 * groups + 3 * corrects
    return size[0] * size[1] * channels * BYTES_PER_CHANNEL


def _group(kind: str) -> str:
    known = {"constant": "environment", "spot": "point", "sphere": "area"}
    return known.get(kind, kind)


def available_bytes() -> int | None:
    """What this process may still take: of the machine, its control group and its own limit."""
    found = [
        _line("/proc/meminfo", "MemAvailable:"),
        _left(_number(CGROUP / "memory.max"), _number(CGROUP / "memory.current")),
        _left(resource.getrlimit(resource.RLIMIT_AS)[0], _line("/proc/self/status", "VmSize:")),
    ]
    known = [value for value in found if value is not None]
    return min(known) if known else None


def require_memory(
    scene: Any, integrator: Any, size: tuple[int, int], *, corrects: bool = False
) -> None:
    """MemoryError, before anything is allocated, if a frame takes more than there is."""
    if size[0] * size[1] < SMALL_PX:
        return
    needed, there = frame_bytes(scene, integrator, size, corrects=corrects), available_bytes()
    if there is not None and needed > there:
        raise MemoryError(
            f"a frame of {size[0]}x{size[1]} pixels needs about {needed / 2**30:.1f} GiB,"
            f" {there / 2**30:.1f} GiB are available; a smaller size needs less"
        )


def _left(limit: int | None, used: int | None) -> int | None:
    if limit is None or used is None or limit in (-1, resource.RLIM_INFINITY):
        return None
    return max(0, limit - used)


def _number(file: Path) -> int | None:
    try:
        return int(file.read_text())
    except (OSError, ValueError):  # no such file, or "max"
        return None


def _line(file: str, name: str) -> int | None:
    """A line in kB of a file of the kernel, in bytes."""
    try:
        lines = Path(file).read_text().splitlines()
        return next(int(x.split()[1]) * 1024 for x in lines if x.startswith(name))
    except (OSError, StopIteration, ValueError):
        return None
