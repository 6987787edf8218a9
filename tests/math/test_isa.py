"""Which variant of the SIMD kernels runs."""

import os
import platform
import subprocess
import sys
from pathlib import Path

import pytest

from viscache import _core

NEEDED = {
    "avx512": {"avx512f", "avx512bw", "avx512dq", "avx512vl", "avx512_vpopcntdq"},
    "avx2": {"avx2", "fma", "bmi2"},
}


def chosen(name):
    """A fresh process with VISCACHE_ISA set, since the choice is made once."""
    return subprocess.run(
        [sys.executable, "-c", "from viscache import _core; print(_core.active_isa())"],
        env={**os.environ, "VISCACHE_ISA": name},
        capture_output=True,
        text=True,
    )


@pytest.mark.skipif(
    platform.machine() != "x86_64" or not Path("/proc/cpuinfo").exists(), reason="needs x86 Linux"
)
def test_the_best_variant_is_the_best_the_cpu_has():
    line = next(x for x in Path("/proc/cpuinfo").read_text().splitlines() if x.startswith("flags"))
    flags = set(line.split())
    expected = next((isa for isa, needed in NEEDED.items() if needed <= flags), "portable")
    assert _core.best_isa() == expected


def test_the_best_variant_runs_unless_another_is_asked_for():
    assert _core.active_isa() == (os.environ.get("VISCACHE_ISA") or _core.best_isa())


def test_the_portable_variant_can_be_asked_for():
    assert chosen("portable").stdout.strip() == "portable"


def test_an_unknown_variant_is_refused():
    refused = chosen("sse9")
    assert refused.returncode == 1
    assert "must be portable, avx2 or avx512, got sse9" in refused.stderr
