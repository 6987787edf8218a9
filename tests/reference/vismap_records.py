"""Section 5 of the visibility-map paper in plain NumPy: maps and weights of records.

Clarberg, Akenine-Möller, *Exploiting Visibility Correlation in Direct Illumination*, EGSR 2008,
with the resolutions of docs/deviations.md. A map is a boolean array, (row y, column x).
"""

from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]
Bools = npt.NDArray[np.bool_]
Words = npt.NDArray[np.uint64]


def z_order(x: int, y: int) -> int:
    """(10): y_{M-1} x_{M-1} ... y_0 x_0."""
    return sum((x >> i & 1) << 2 * i | (y >> i & 1) << 2 * i + 1 for i in range(16))


def cells(edge: int) -> list[tuple[int, int]]:
    """(x, y) of every cell along the curve."""
    places = [(x, y) for y in range(edge) for x in range(edge)]
    return sorted(places, key=lambda p: z_order(*p))


def packed(square: Bools) -> Words:
    """Words of a map: cell z is bit z % 64 of word z // 64."""
    along = np.array([square[y, x] for x, y in cells(len(square))])
    return np.packbits(along, bitorder="little").view(np.uint64)


def unpacked(words: Words, edge: int) -> Bools:
    """The map that words hold."""
    along = np.unpackbits(words.view(np.uint8), bitorder="little").astype(bool)
    square = np.zeros((edge, edge), bool)
    for z, (x, y) in enumerate(cells(edge)):
        square[y, x] = along[z]
    return square


def codes(square: Bools, level: int) -> Array:
    """Of every node of a quadtree level along the curve: bit 0 = any is free, bit 1 = all."""
    size = len(square) >> level
    nodes = [
        square[y * size : (y + 1) * size, x * size : (x + 1) * size] for x, y in cells(1 << level)
    ]
    return np.array([int(n.any()) + 2 * int(n.all()) for n in nodes])


def neighbour(x: int, y: int, edge: int) -> tuple[int, int]:
    """The cell of the octahedral map that a place beside the square continues with."""
    if x < 0:
        x, y = -1 - x, edge - 1 - y
    elif x >= edge:
        x, y = 2 * edge - 1 - x, edge - 1 - y
    if y < 0:
        x, y = edge - 1 - x, -1 - y
    elif y >= edge:
        x, y = edge - 1 - x, 2 * edge - 1 - y
    return x, y


def dilated(square: Bools, level: int) -> Bools:
    """V^level: any on blocks of 2^(level − 1), then every block with its eight neighbours."""
    block = 1 << level - 1
    edge = len(square) // block
    coarse = square.reshape(edge, block, edge, block).any(axis=(1, 3))
    out = np.zeros_like(coarse)
    for y, x in np.argwhere(coarse):
        for dy in (-1, 0, 1):
            for dx in (-1, 0, 1):
                nx, ny = neighbour(int(x) + dx, int(y) + dy, edge)
                out[ny, nx] = True
    return out


def weight(t: Array, theta: Array, lam: float = 5.0) -> Array:
    """(9)"""
    return np.asarray((1 - theta / np.pi) * (1 - t / (1 + lam * t)))


def normalized(w: Array, theta_max: float, lam: float = 5.0) -> Array:
    """ŵ: (9) stretched from its least value to [0, 1]."""
    least = weight(np.array(1.0), np.array(theta_max), lam)
    return np.asarray((w - least) / (1 - least))


def full_weights(
    x: Array, n: Array, positions: Array, normals: Array, d_max: float, theta_max: float
) -> Array:
    """w_g·ŵ of records for a point; NaN where they are not candidates."""
    to = positions.astype(float) - x
    d = np.linalg.norm(to, axis=1)
    theta = 2 * np.arctan2(np.linalg.norm(normals - n, axis=1), np.linalg.norm(normals + n, axis=1))
    w = normalized(weight(d / d_max, theta), theta_max)
    with np.errstate(invalid="ignore", divide="ignore"):
        w_g = np.where(d < 1e-6 * d_max, 1, 1 - np.abs(to @ n) / d)
    return np.asarray(np.where((d < d_max) & (theta < theta_max), w_g * w, np.nan))


def ambient_test(weights: Array, distances: Array, nearest_hits: Array) -> float:
    """Sec. 6.1: max w_i (1 - d_i / R_i) over candidates, R_i the nearest hit of record i's rays."""
    there = ~np.isnan(weights)
    reached = weights[there] * np.maximum(0, 1 - distances[there] / nearest_hits[there])
    return float(reached.max(initial=0.0))
