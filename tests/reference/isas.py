"""The variants of the SIMD kernels."""

from viscache import _core

ISAS = ("portable", "avx2", "avx512")
#: Those of this CPU.
AVAILABLE = ISAS[: ISAS.index(_core.best_isa()) + 1]
