"""Section 4 of the visibility-map paper in plain NumPy.

Clarberg, Akenine-Möller, *Exploiting Visibility Correlation in Direct Illumination*, EGSR 2008,
with the resolutions of docs/deviations.md. Visibility is a boolean array, points by directions.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Bools = npt.NDArray[np.bool_]
Floats = npt.NDArray[np.float32]
Ints = npt.NDArray[np.int64]


def packed(visible: Bools, words: int | None = None) -> npt.NDArray[np.uint64]:
    """Rows of bits: direction k is bit k % 64 of word k // 64."""
    n, n_directions = visible.shape
    words = -(-n_directions // 64) if words is None else words
    padded = np.zeros((n, 64 * words), bool)
    padded[:, :n_directions] = visible
    return np.packbits(padded, axis=1, bitorder="little").view(np.uint64)


def equal_area_directions(edge: int) -> Floats:
    """Centres of the cells of the equal-area octahedral map, row by row; (edge², 3)."""
    centre = (np.arange(edge) + 0.5) / edge
    u, v = np.meshgrid(2 * centre - 1, 2 * centre - 1)
    signed = 1 - abs(u) - abs(v)
    r = 1 - abs(signed)
    phi = np.pi / 4 * ((abs(v) - abs(u)) / r + 1)
    z = np.copysign(1 - r * r, signed)
    s = r * np.sqrt(2 - r * r)
    x, y = np.copysign(np.cos(phi) * s, u), np.copysign(np.sin(phi) * s, v)
    return np.stack([x, y, z], axis=-1).reshape(-1, 3).astype(np.float32)


def _squared(v: Floats) -> Floats:
    return (v[..., 0] * v[..., 0] + v[..., 1] * v[..., 1]) + v[..., 2] * v[..., 2]


def distance_bins(d2: Floats, edges: npt.NDArray[np.float64]) -> Ints:
    """Number of edges at or below, of d² in float32 against squares in float64."""
    return np.searchsorted(edges**2, d2.astype(np.float64), side="right")


def angle_bins(chord2: Floats, edges_deg: npt.NDArray[np.float64]) -> Ints:
    """The same for the squared chord against 4 sin²(edge/2); nothing lies past 180 degrees."""
    squares = 4 * np.sin(np.radians(edges_deg) / 2) ** 2
    squares[edges_deg == 180] = np.inf
    return np.searchsorted(squares, chord2.astype(np.float64), side="right")


@dataclass(frozen=True, kw_only=True)
class Pairs:
    """Pairs i < j of points: counts within their domain, and places."""

    i: Ints
    j: Ints
    of: Ints
    n1: Ints
    n2: Ints
    n11: Ints
    d2: Floats
    chord2: Floats


def all_pairs(
    visible: Bools,
    positions: Floats,
    normals: Floats,
    *,
    domain: str = "sphere",
    directions: Floats | None = None,
) -> Pairs:
    """Counts by brute force, a row of pairs at a time."""
    n, n_directions = visible.shape
    inside = np.ones((n, n_directions), bool)
    if domain != "sphere":
        assert directions is not None
        inside = _facing(normals, directions)
        visible = visible & inside
    rows = []
    for i in range(n):
        j = np.arange(i + 1, n)
        within = inside[i] | inside[j] if domain == "union" else inside[i] & inside[j]
        a, b = visible[i] & within, visible[j] & within
        counts = [x.sum(axis=1) for x in (within, a, b, a & b)]
        rows.append(np.stack([np.full(len(j), i), j, *counts]))
    i, j, of, n1, n2, n11 = np.concatenate(rows, axis=1)
    d2, chord2 = (_squared(x[j] - x[i]) for x in (positions, normals))
    return Pairs(i=i, j=j, of=of, n1=n1, n2=n2, n11=n11, d2=d2, chord2=chord2)


def _facing(normals: Floats, directions: Floats) -> Bools:
    n, w = normals[:, None], directions[None]
    return (n[..., 0] * w[..., 0] + n[..., 1] * w[..., 1]) + n[..., 2] * w[..., 2] > 0


def quantized_rho(
    p: Pairs, *, min_bits: int = 1, one_if_both: bool = False, single: bool = True
) -> tuple[Ints, Bools]:
    """q = round(2²⁰ ρ) and which pairs have one; `single` for the sphere's float32 roots."""
    few1, few2 = p.n1 < min_bits, p.n2 < min_bits
    full1, full2 = ~few1 & (p.n1 == p.of), ~few2 & (p.n2 == p.of)
    defined = ~(few1 | few2 | full1 | full2)
    v1, v2 = p.n1 * (p.of - p.n1), p.n2 * (p.of - p.n2)
    v1, v2 = np.where(defined, v1, 1), np.where(defined, v2, 1)
    numerator = p.of * p.n11 - p.n1 * p.n2
    if single:
        roots = [(1 / np.sqrt(v.astype(np.float64))).astype(np.float32) for v in (v1, v2)]
        rho = numerator.astype(np.float32) * (roots[0] * roots[1])
    else:
        spread = np.sqrt(v1.astype(np.float64)) * np.sqrt(v2.astype(np.float64))
        rho = (numerator / spread).astype(np.float32)
    q = np.rint(rho.astype(np.float64) * 2**20).astype(np.int64)
    if one_if_both:
        both = (few1 & few2) | (full1 & full2)
        q, defined = np.where(both, 2**20, q), defined | both
    return q, defined


def pair_sums(
    p: Pairs,
    q: Ints,
    defined: Bools,
    group: Ints,
    d_edges: npt.NDArray[np.float64],
    theta_edges_deg: npt.NDArray[np.float64],
) -> dict[str, npt.NDArray[np.object_]]:
    """n, n_undefined, Σq and Σq² per pair of groups, bin of distance and bin of angle."""
    d, t = distance_bins(p.d2, d_edges), angle_bins(p.chord2, theta_edges_deg)
    groups = int(group.max()) + 1
    g, h = np.minimum(group[p.i], group[p.j]), np.maximum(group[p.i], group[p.j])
    pair = g * groups - g * (g + 1) // 2 + h
    shape = (groups * (groups + 1) // 2, len(d_edges) + 1, len(theta_edges_deg) + 1)
    sums = {name: np.zeros(shape, object) for name in ("n", "n_undefined", "sum_q", "sum_q2")}
    where = (pair, d, t)
    for name, values in (("n", defined), ("sum_q", q * defined), ("sum_q2", q * q * defined)):
        np.add.at(sums[name], where, values.astype(object))
    np.add.at(sums["n_undefined"], where, (~defined).astype(object))
    return {name: values[:, 1:-1, 1:-1] for name, values in sums.items()}
