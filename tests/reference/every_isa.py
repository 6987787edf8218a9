"""Runs code of a test in another variant of the SIMD kernels."""

from __future__ import annotations

import os
import subprocess
import sys

from viscache import _core

EVERY = ("portable", "avx2", "avx512")
#: The variants of this CPU.
AVAILABLE = EVERY[: EVERY.index(_core.best_isa()) + 1]
#: Those that this process does not run itself.
ISAS = tuple(isa for isa in AVAILABLE if isa != _core.active_isa())


def printed_by(isa: str, module: str, expression: str) -> str:
    """What a fresh process of that variant prints for an expression of a test module."""
    found = f"import sys; sys.path[:0] = {sys.path!r}; import {module}"
    code = f"{found}; print({module}.{expression})"
    env = os.environ | {"VISCACHE_ISA": isa}
    return subprocess.run(
        [sys.executable, "-c", code], env=env, capture_output=True, text=True, check=True
    ).stdout.strip()
