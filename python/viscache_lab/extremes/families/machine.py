"""The same bytes of every method with any threads, instruction set and mode of rounding."""

from __future__ import annotations

import ctypes
import json
import os
import platform
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache, partial
from typing import Any

import numpy as np

import viscache as vc
from viscache.base import provenance
from viscache_lab.experiment import FAMILIES, Case
from viscache_lab.experiment.children import instruction_sets
from viscache_lab.extremes import scenes
from viscache_lab.extremes.moved import moved
from viscache_lab.extremes.pictures import DIRECT, METHODS, WHITTED, Method, picture, unequal

COUNTS = (1, 2, 3, 7)
THREADS_WHY = "a tile is the unit of work; random numbers do not know threads"


@FAMILIES.add("threads", "1, 2, 3 and 7 threads")
def threads(full: bool) -> Iterator[Case]:
    for name, method in METHODS.items():
        # Larger than a tile, so that there are several
        size = (160, 100) if full else (100, 60)
        yield Case(
            name=f"{name}: frames whose bytes differ",
            measure=partial(_frames, method, size=(48, 32) if method.maps else size),
            why=THREADS_WHY,
        )
    paths = {"integrator": vc.Bdpt(max_depth=3), "visibility": vc.Aqvc(c_e=6)}
    for what, measure in {
        "bidirectional paths: frames whose bytes differ": partial(_frames, None, **paths),
        "correlation: tables that differ": partial(_others, _correlation),
        "records of maps: caches that differ": partial(_others, _records),
    }.items():
        yield Case(name=what, measure=measure, why=THREADS_WHY)


def _frames(method: Method | None, **given: Any) -> float:
    return unequal([picture(scenes.lit_box(), method, threads=t, **given) for t in COUNTS])


def _others(answers: Callable[[int], bytes]) -> float:
    """How many numbers of threads give other bytes than one."""
    first, *others = map(answers, COUNTS)
    return float(sum(other != first for other in others))


def _correlation(threads: int) -> bytes:
    given: dict[str, Any] = {"n_points": 400, "map_size": 16, "pairs": "all", "seed": 3}
    table = vc.correlation.measure(scenes.lit_box(), threads=threads, **given)
    return np.asarray(table["mean"]).tobytes()


def _records(threads: int) -> bytes:
    cache = vc.VisibilityMapCache(scenes.lit_box(), vc.MapSettings(n_startup=50))
    cache.update(size=(48, 32), threads=threads)
    made = cache.records()
    return made.bits.tobytes() + made.positions.tobytes()


TIMEOUT_S = 100.0


@FAMILIES.add("isa", "portable code, AVX2 and AVX-512", every_isa=False)
def isa(full: bool) -> Iterator[Case]:
    here, best = provenance.isa()
    yield Case(
        name="the kernels run another variant than the best one, or than the one asked for",
        measure=lambda: float(here != (os.environ.get("VISCACHE_ISA") or best)),
        why="the program chooses at its start",
    )
    for other in instruction_sets():
        if other != here:
            for name in digests():
                yield Case(
                    name=f"{other} against {here}, {name}: frames whose bytes differ",
                    measure=partial(_differs, other, name),
                    why="floating-point contraction is off, and kernels add in the same order",
                )


def _differs(other: str, name: str) -> float:
    return float(digests_of(other)[name] != digests()[name])


@cache
def digests() -> dict[str, str]:
    """The hash of a frame of every method, on this process's instruction set."""
    found = {name: picture(scenes.lit_box(), m).sha256 for name, m in METHODS.items()}
    more: dict[str, dict[str, Any]] = {
        "virtual lights": {"integrator": WHITTED},
        "virtual lights, cached": {"integrator": WHITTED, "visibility": vc.Aqvc(c_e=6)},
        "bidirectional paths": {"integrator": vc.Bdpt(max_depth=4)},
        "shared directions": {
            "integrator": vc.AmbientOcclusion(directions="shared", n_samples=129, engine="batch")
        },
    }
    return found | {n: picture(scenes.lit_box(), **given).sha256 for n, given in more.items()}


#: What a process of another instruction set runs.
CODE = """
import json
from viscache_lab.extremes.families import machine
print(json.dumps(machine.digests()))
"""


def digests_of(other: str) -> dict[str, str]:
    """The same in a process of another instruction set."""
    told = _told(other)
    if isinstance(told, str):
        raise RuntimeError(f"the process of {other} ended: {told}")
    return told


@cache
def _told(other: str) -> dict[str, str] | str:
    """The digests, or why there are none."""
    made = subprocess.run(
        [sys.executable, "-c", CODE],
        env={**os.environ, "VISCACHE_ISA": other},
        capture_output=True,
        timeout=TIMEOUT_S,
        check=False,
    )
    if made.returncode:
        return (made.stderr.decode(errors="replace").strip().splitlines() or [""])[-1]
    found: dict[str, str] = json.loads(made.stdout)
    return found


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
    if (platform.machine(), platform.libc_ver()[0]) != ("x86_64", "glibc"):
        return  # the control word is set as glibc does there
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
