"""Orders in which pixels may insert records."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

Indices = npt.NDArray[np.int64]


def pixel_order(order: str, width: int, height: int) -> Indices:
    """Row-major indices of the pixels in the given order.

    "scanline": row by row. "hilbert": along Hilbert's curve. "coarse_to_fine": every 2^k-th pixel
    of every 2^k-th row first, then those half way between them.
    """
    numbers = np.arange(width * height, dtype=np.int64)
    if order == "scanline":
        return numbers
    y, x = np.divmod(numbers, width)
    bits = max(width, height, 2).bit_length()
    key = _hilbert(x, y, bits) if order == "hilbert" else _coarse_to_fine(x, y, bits)
    return np.argsort(key, kind="stable").astype(np.int64)


def _coarse_to_fine(x: Any, y: Any, bits: int) -> Indices:
    """Interleaved reversed bits of both coordinates: coarse positions come first."""
    key = np.zeros_like(x)
    for bit in range(bits):
        key = key << 2 | (x >> bit & 1) << 1 | (y >> bit & 1)
    return np.asarray(key)


def _hilbert(x: Any, y: Any, bits: int) -> Indices:
    """Index along Hilbert's curve."""
    x, y, key = x.copy(), y.copy(), np.zeros_like(x)
    for bit in reversed(range(bits)):
        step = 1 << bit
        right, up = (x & step) > 0, (y & step) > 0
        key += step * step * ((3 * right) ^ up)
        # Turn the quadrant so that the curve within it starts at its origin
        flip = right & ~up
        x, y = np.where(flip, step - 1 - x, x), np.where(flip, step - 1 - y, y)
        x, y = np.where(up, x, y), np.where(up, y, x)
    return np.asarray(key)
