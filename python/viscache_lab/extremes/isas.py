"""The instruction sets of the kernels."""

from __future__ import annotations

from viscache.base import provenance

#: All of them, from the plainest.
ISAS = ("portable", "avx2", "avx512")


def instruction_sets() -> tuple[str, ...]:
    """Those that this CPU has."""
    return ISAS[: ISAS.index(provenance.isa()[1]) + 1]
