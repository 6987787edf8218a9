"""Denormals flushed to zero, and other rounding modes, set by the caller: the same bytes."""

from __future__ import annotations

import ctypes
import platform
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial

import numpy as np

from viscache_lab.experiment import FAMILIES, Case
from viscache_lab.extremes import scenes
from viscache_lab.extremes.moved import moved
from viscache_lab.extremes.pictures import DIRECT, METHODS, Method, picture

#: Bits of the control word of SSE (MXCSR) beside the default, 0x1f80.
MODES = {
    "denormals are zero (FTZ, DAZ)": 0x8040,
    "rounding down": 0x2000,
    "rounding up": 0x4000,
    "rounding to zero": 0x6000,
}
DEFAULT = 0x1F80
#: Bytes of glibc's fenv_t on x86-64; the control word is the last four.
ENVIRONMENT_BYTES = 32
WHY = "the core sets the mode that it computes in, and restores the caller's"


@FAMILIES.add("float_modes", "denormals and rounding modes set by the caller")
def float_modes(full: bool) -> Iterator[Case]:
    if not can_set_mode():
        return
    for mode, bits in MODES.items():
        yield Case(
            name=f"{mode}: modes that could not be set",
            measure=partial(_not_set, bits),
            why="otherwise the checks below would show nothing",
        )
        for name, method in METHODS.items():
            if method.maps and not full and mode != next(iter(MODES)):
                continue
            for scale in (1.0, 1e-6) if full else (1.0,):
                for threads in (1, 3) if full else (1,):
                    yield Case(
                        name=f"{mode}, {name}, {scale:g} times as large, {threads} thread(s): "
                        "frames whose bytes differ",
                        measure=partial(_differing, method, bits, scale, threads),
                        why=WHY,
                    )
        yield Case(
            name=f"{mode}: answers of rays that differ", measure=partial(_rays, bits), why=WHY
        )


def can_set_mode() -> bool:
    """Whether this is glibc on x86-64, whose control word is set below."""
    return platform.machine() == "x86_64" and platform.libc_ver()[0] == "glibc"


@contextmanager
def float_mode(bits: int) -> Iterator[None]:
    """This thread with bits of the SSE control word set."""
    before = _environment()
    changed = bytearray(before)
    changed[-4:] = (DEFAULT | bits).to_bytes(4, "little")
    ctypes.CDLL("libm.so.6").fesetenv(bytes(changed))
    try:
        yield
    finally:
        ctypes.CDLL("libm.so.6").fesetenv(before)


def _environment() -> bytes:
    """This thread's floating-point environment."""
    found = ctypes.create_string_buffer(ENVIRONMENT_BYTES)
    ctypes.CDLL("libm.so.6").fegetenv(found)
    return found.raw


def _not_set(bits: int) -> float:
    with float_mode(bits):
        now = int.from_bytes(_environment()[-4:], "little")
    return float(now & bits != bits)


def _differing(method: Method, bits: int, scale: float, threads: int) -> float:
    # Settings are converted before the core sets its mode: those of DIRECT are exact or not used
    given = {"threads": threads, "integrator": method.integrator if method.maps else DIRECT}
    box = moved(scenes.lit_box(), scale=scale)
    plain = picture(box, method, **given)
    with float_mode(bits):
        other = picture(box, method, **given)
    return float(other.sha256 != plain.sha256)


def _rays(bits: int) -> float:
    rng, scene = np.random.default_rng(1), scenes.lit_box()
    x, y = rng.uniform(-0.5, 0.5, (2, 3000, 3)).astype(np.float32)
    d = y - x
    found = []
    for mode in (0, bits):
        with float_mode(mode):
            hits = scene.intersect(x, d, threads=1)
            found.append((hits.t, hits.triangle, scene.visible(x, y, threads=1)))
    return float(sum((a != b).sum() for a, b in zip(*found, strict=True)))
