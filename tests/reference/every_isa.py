"""Runs code of a test in another variant of the SIMD kernels."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from viscache import _core

ISAS = ("portable", "avx2", "avx512")


def printed_by(isa: str, module: str, expression: str) -> str:
    """What a fresh process of that variant prints for an expression of a test module."""
    if ISAS.index(isa) > ISAS.index(_core.best_isa()):
        pytest.skip(f"this CPU has no {isa}")
    found = f"import sys; sys.path[:0] = {sys.path!r}; import {module}"
    code = f"{found}; print({module}.{expression})"
    env = os.environ | {"VISCACHE_ISA": isa}
    return subprocess.run(
        [sys.executable, "-c", code], env=env, capture_output=True, text=True, check=True
    ).stdout.strip()
