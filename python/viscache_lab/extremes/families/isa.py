"""Every instruction set that this CPU has, each in a process of its own: the same bytes."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from functools import cache, partial
from typing import Any

import viscache as vc
from viscache.base import provenance
from viscache_lab.experiment import FAMILIES, Case
from viscache_lab.experiment.children import instruction_sets
from viscache_lab.extremes import scenes
from viscache_lab.extremes.pictures import METHODS, WHITTED, picture

TIMEOUT_S = 100.0


@FAMILIES.add("isa", "portable code, AVX2 and AVX-512", every_isa=False)
def isa(full: bool) -> Iterator[Case]:
    here, _ = provenance.isa()
    yield Case(
        name="the kernels run another variant than the best one, or than the one asked for",
        measure=_another_variant,
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


def _another_variant() -> float:
    here, best = provenance.isa()
    return float(here != (os.environ.get("VISCACHE_ISA") or best))


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
CODE = (
    "import json; from viscache_lab.extremes.families import isa; print(json.dumps(isa.digests()))"
)


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
