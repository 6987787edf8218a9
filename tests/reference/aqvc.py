"""The quantized cache in plain NumPy and dictionaries, written from the paper.

Popov, Georgiev, Slusallek, Dachsbacher, *Adaptive Quantization Visibility Caching*,
Eurographics 2013, with the corrections documented in docs/deviations.md. Slow on purpose: one
eye point, one light at a time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Key = tuple[int, ...]
NEIGHBOURS = ((1, 0), (0, 1), (-1, 0), (0, -1))


def expected_paths(n_p: Array, p_e: Array, a_e: Array, p_l: Array, a_l: Array) -> Array:
    """Eq. 2: paths in a cluster of patches A_e, A_l."""
    return n_p * (p_e * a_e) * (p_l * a_l)


def patch_area_product(p_e: Array, p_l: Array, n_p: Array, c_e: Array) -> Array:
    """Eq. 3: A_e·A_l that holds C_E² paths."""
    return c_e**2 / (p_e * p_l * n_p)


def patch_area(r: Array, b_r: Array) -> Array:
    """Eq. 5."""
    return (2 * b_r / r) ** 2


def resolution_pair(d_e: Array, d_l: Array, c_e: float, b_r: float) -> Array:
    """Eq. 6 with the fourth root; D_e·D_l = P_e·P_l·N_P."""
    return 2 * b_r * (d_e * d_l / c_e**2) ** 0.25


def resolution_eye(d_e: Array, c_e: float, b_r: float) -> Array:
    """Eq. 7, eye side."""
    return 2 * b_r * np.sqrt(d_e) / c_e


def resolution_light(d_l: Array, b_r: float) -> Array:
    """Eq. 7, light side."""
    return 2 * b_r * np.sqrt(d_l)


def resolution_environment(d: Array) -> Array:
    """Eq. 9 with 4π on the side where the areas agree."""
    return np.sqrt(4 * np.pi * d)


def resolution_environment_printed(d: Array) -> Array:
    """Eq. 9 as printed."""
    return np.sqrt(d / (4 * np.pi))


def normal_bins(n: Array, c_n: Array, rounding: bool) -> Array:
    """Eq. 4: ω_q of a component of the normal."""
    return np.clip(np.floor((n + 1) / 2 * c_n + (0.5 if rounding else 0.0)), 0, c_n)


def ladder(r: Array, c_r: float = 1.2) -> Array:
    """Eq. 8 as printed, after R >= 1."""
    r = np.maximum(np.asarray(r, np.float64), 1.0)
    k = np.floor(np.log(r) / np.log(c_r) + 0.5)
    return np.maximum(1.0, np.floor(c_r**k))


def mixed(v: int) -> int:
    """MurmurHash3's finaliser."""
    m = 2**64 - 1
    h = v & m
    h ^= h >> 33
    h = h * 0xFF51AFD7ED558CCD & m
    h ^= h >> 33
    h = h * 0xC4CEB9FE1A85EC53 & m
    return h ^ h >> 33


def fold(v: int) -> int:
    """64-bit coordinate mixed down to a signed 32-bit slot."""
    h = mixed(v) & 0xFFFFFFFF
    return h - 2**32 if h >= 2**31 else h


def offset(seed: int, shifted: bool = True) -> tuple[float, ...]:
    """Shift of the grids in cells."""
    if not shifted:
        return 0.0, 0.0, 0.0
    start = (0.7549, 0.5698, 0.4263)
    return tuple(
        s + ((mixed(3 * seed + a) >> 11) / 2**53 if seed else 0.0) for a, s in enumerate(start)
    )


def octahedral_steps(c_n: int) -> int:
    """Steps along the square's edge: even, for about the bins that rounding uses."""
    return 2 * int(np.floor(1.085 * c_n + 0.5))


def octahedral_bin(n: Array, steps: int) -> tuple[int, int, int]:
    """Nearest lattice point on the octahedral square; the two halves of an edge are one."""
    i, j = (int(v) for v in np.floor(octahedron(n) * steps + 0.5))
    if i in (0, steps):
        j = min(j, steps - j)
    if j in (0, steps):
        i = min(i, steps - i)
    return 0, i, j


def octahedral_axis(i: int, j: int, steps: int) -> Array:
    """Direction of a lattice point, not normalised."""
    x, y = 2.0 * i / steps - 1, 2.0 * j / steps - 1
    z = 1 - abs(x) - abs(y)
    if z < 0:
        x, y = (1 - abs(y)) * (-1 if x < 0 else 1), (1 - abs(x)) * (-1 if y < 0 else 1)
    return np.array([x, y, z])


def octahedron(w: Array) -> Array:
    """Octahedral map of unit directions to [0, 1]², sgn(0) = +1."""
    w = np.asarray(w, np.float64)
    p = w / np.abs(w).sum(-1, keepdims=True)
    s = np.where(p[..., :2] >= 0, 1.0, -1.0)
    folded = (1 - np.abs(p[..., 1::-1])) * s
    return np.where(p[..., 2:] < 0, folded, p[..., :2]) * 0.5 + 0.5


@dataclass
class Grid:
    """Virtual grids of one scene: what Eq. 4 and Sec. 3.3 need."""

    center: Sequence[float]
    radius: float
    c_n: int = 8
    c_z: float = 4.0
    c_r: float = 1.2
    mode: str = "round"
    offset: tuple[float, float, float] = (0.7549, 0.5698, 0.4263)
    tangent: bool = True
    scale_free: bool = False

    @property
    def half(self) -> float:
        """Half of what one is divided by: B_R, or half a unit of length."""
        return 0.5 if self.scale_free else self.radius

    def rung(self, r: float) -> tuple[float, int]:
        """R on the ladder and what stands for it in the key."""
        if not self.scale_free:
            big = float(ladder(np.array(r), self.c_r))
            return big, int(big)
        k = int(np.floor(np.log(r) / np.log(self.c_r) + 0.5))
        power = 1.0
        for _ in range(abs(k)):
            power = power * self.c_r if k > 0 else power / self.c_r
        return power, k

    def bins(self, n: Array) -> tuple[int, ...]:
        """Bin of a normal."""
        if self.mode == "single":
            return 0, 0, 0
        if self.mode == "octahedral":
            return octahedral_bin(n, octahedral_steps(self.c_n))
        shift = 0.5 if self.mode == "round" else 0.0
        found = np.clip(np.floor((n + 1) / 2 * self.c_n + shift), 0, self.c_n)
        return tuple(int(b) for b in found)

    def frame(self, bins: Sequence[int]) -> tuple[Array, Array, Array]:
        """Axes of the grid of a normal bin (Duff et al.'s basis around d_z of Eq. 4)."""
        if self.mode == "single":
            return tuple(np.eye(3))
        if self.mode == "octahedral":
            d = octahedral_axis(bins[1], bins[2], octahedral_steps(self.c_n))
        else:
            d = 2.0 * np.asarray(bins, np.float64) / self.c_n - 1
        n = np.sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2])
        x, y, z = d / n if n > 0 else np.array([0.0, 0.0, 1.0])
        s = np.copysign(1.0, z)
        a = -1 / (s + z)
        b = x * y * a
        return (
            np.array([1 + s * x * x * a, s * b, -s * x]),
            np.array([b, s + y * y * a, -y]),
            np.array([x, y, z]),
        )

    def place(self, p: Array, n: Array, r: float) -> Placed:
        """Cell of point p with normal n for the real-valued resolution r."""
        p, n = np.asarray(p, np.float64), np.asarray(n, np.float64)
        bins = self.bins(n)
        c_z = 1.0 if self.mode == "single" else self.c_z
        ex, ey, ez = self.frame(bins)
        origin = (0, 0, 0) if self.scale_free else self.center
        q = p - np.asarray(origin, np.float64)

        def along(e: Array, v: Array) -> float:
            return float(e[0] * v[0] + e[1] * v[1] + e[2] * v[2])

        big, slot = self.rung(r)
        s = big / (2 * self.half)
        f = (
            (along(ex, q) + self.half) * s + self.offset[0],
            (along(ey, q) + self.half) * s + self.offset[1],
            (along(ez, q) + self.half) * s * c_z + self.offset[2],
        )
        nz = along(ez, n)
        steep = abs(nz) <= 0.01
        slope = (0.0, 0.0) if steep else tuple(c_z * along(e, n) / nz for e in (ex, ey))
        v = tuple(int(np.floor(c)) for c in f)
        return Placed(bins, slot, v, f, slope)


@dataclass(frozen=True)
class Placed:
    """A point in its cell."""

    bins: tuple[int, ...]
    resolution: int
    v: tuple[int, ...]
    f: tuple[float, ...]
    slope: tuple[float, ...]

    @property
    def key(self) -> Key:
        """Seven integers: ω_q, voxel, R."""
        return (*self.bins, *self.v, self.resolution)

    def neighbour(self, dx: int, dy: int, tangent: bool) -> Key:
        """Key of the neighbour; along the tangent plane, or at the same v_z."""
        z = self.v[2]
        if tangent:
            z = int(np.floor(self.f[2] - (dx * self.slope[0] + dy * self.slope[1])))
        return (*self.bins, self.v[0] + dx, self.v[1] + dy, z, self.resolution)

    @property
    def distance2(self) -> float:
        """Squared distance to the centre in the tangent coordinates, in cells."""
        a, b = self.f[0] - self.v[0] - 0.5, self.f[1] - self.v[1] - 0.5
        return a * a + b * b


def level_list(c_e: float, step: float = 4.0, finest: float = 4.0) -> list[float]:
    """C_E by level from coarse to fine: c_e, and below it finest times all powers of the step."""
    below: list[float] = []
    while (c := finest * step ** len(below)) < c_e:
        below.append(c)
    return [c_e, *reversed(below)]


@dataclass
class Result:
    """Answers and what they cost."""

    visible: NDArray[np.bool_]
    rays_per_level: list[int] = field(default_factory=list)
    leftover: int = 0

    @property
    def rays(self) -> int:
        """All rays."""
        return sum(self.rays_per_level) + self.leftover


_PLACED: dict[tuple[object, ...], list[list[Placed]]] = {}


def place_all(grid: Grid, eyes: dict, levels: Sequence[float]) -> list[list[Placed]]:
    """Cells of every eye point at every level.

    The latest are kept: lights of many kinds are asked from the same eye points.
    """
    asked = [eyes[name].tobytes() for name in ("position", "normal", "density")]
    key = (repr(grid), *levels, *asked)
    if key not in _PLACED:
        if len(_PLACED) == 4:
            _PLACED.clear()
        d = np.asarray(eyes["density"], np.float64)
        _PLACED[key] = [
            [grid.place(p, n, resolution_eye(d[i], c, grid.half)) for c in levels]
            for i, (p, n) in enumerate(zip(eyes["position"], eyes["normal"], strict=True))
        ]
    return _PLACED[key]


def alg2(
    grid: Grid,
    eyes: dict,
    levels: Sequence[float],
    exact: NDArray[np.bool_],
    wanted: NDArray[np.bool_],
    order: Sequence[int],
) -> Result:
    """Alg. 2, one query at a time in the given order, against a dictionary."""
    placed = place_all(grid, eyes, levels)
    table: dict[tuple[Key, int], bool] = {}
    out = Result(np.zeros_like(wanted), [0] * len(levels))
    for i in order:
        steps = [
            (d, c.key, [c.neighbour(*o, grid.tangent) for o in NEIGHBOURS])
            for d, c in enumerate(placed[i])
            if d == 0 or c.key != placed[i][d - 1].key
        ]
        for k in np.flatnonzero(wanted[i]):
            for d, key, neighbours in steps:
                value = table.get((key, k))
                if value is None:
                    value = bool(exact[i, k])
                    table[key, k] = value
                    out.rays_per_level[d] += 1
                    break
                near = [table.get((n, k)) for n in neighbours]
                if all(n is None or n == value for n in near):
                    break
            out.visible[i, k] = value
    return out


@dataclass(frozen=True)
class Worth:
    """C_E by contribution: what connections carry, (eye points, lights), and how C_E follows."""

    contribution: Array
    c_e: float
    step: float
    power: float = 2.5
    slack: int = 1

    def at_most(self, eye: int, k: int, c: float) -> bool:
        """Whether the connection carries no more than a level of C_E = c is good for."""
        f = self.contribution[eye]
        mean = f.sum() / max(1, (f > 0).sum())
        return bool(np.float32(f[k]) <= np.float32((self.c_e / c) ** self.power) * np.float32(mean))

    def due(self, eye: int, k: int, levels: Sequence[float], d: int) -> bool:
        """Whether level d asks the connection."""
        return d == len(levels) - 1 or self.at_most(eye, k, levels[d])

    def settled(self, eye: int, k: int, c: float) -> bool:
        """Whether a level of C_E = c settles the connection against its neighbours."""
        return self.at_most(eye, k, c * self.step**self.slack)


def waves(
    grid: Grid,
    eyes: dict,
    levels: Sequence[float],
    exact: NDArray[np.bool_],
    wanted: NDArray[np.bool_],
    worth: Worth | None = None,
) -> Result:
    """Level waves: Alg. 2 level by level, each cell asked through its central eye point."""
    placed = place_all(grid, eyes, levels)
    n_eyes, depth = len(placed), len(levels)
    # Cells in order of first touch; an eye point whose R did not change keeps its cell.
    cell_of: list[list[tuple[int, Key]]] = [[] for _ in range(n_eyes)]
    members: dict[tuple[int, Key], list[int]] = {}
    for d in range(depth):
        for i in range(n_eyes):
            if d > 0 and cell_of[i][d - 1][1] == placed[i][d].key:
                cell_of[i].append(cell_of[i][d - 1])
                continue
            cell = (d, placed[i][d].key)
            cell_of[i].append(cell)
            members.setdefault(cell, []).append(i)
    rep: dict[tuple[int, Key], int] = {}
    for cell, inside in members.items():
        d = cell[0]
        coarser = [i for i in inside if any(rep[cell_of[i][e]] == i for e in range(d))]
        rep[cell] = min(coarser or inside, key=lambda i: (placed[i][d].distance2, i))

    value: dict[tuple[tuple[int, Key], int], bool] = {}
    asking = [set(np.flatnonzero(wanted[i]).tolist()) for i in range(n_eyes)]
    out = Result(np.zeros_like(wanted), [0] * depth)
    need: dict[tuple[int, Key], set[int]] = {c: set() for c in members}
    for d in range(depth):
        cells = [c for c in members if c[0] == d]
        traced = {}
        for cell in cells:
            r = rep[cell]
            mine = set(np.flatnonzero(wanted[r]).tolist())
            traced[cell] = [
                k
                for k in sorted(mine if d == 0 else need[cell] & mine)
                if (cell, k) not in value and (worth is None or worth.due(r, k, levels, d))
            ]
            for k in traced[cell]:
                value[cell, k] = bool(exact[r, k])
            out.rays_per_level[d] += len(traced[cell])
        for cell in cells:  # an eye point keeps the answers of its own rays
            for k in traced[cell]:
                out.visible[rep[cell], k] = value[cell, k]
                asking[rep[cell]].discard(k)
        if d == depth - 1:
            break
        for cell in cells:
            for finer in cell_of[rep[cell]][d + 1 :]:
                for k in traced[cell]:
                    value.setdefault((finer, k), value[cell, k])
        near = {}
        for cell in cells:
            p = placed[rep[cell]][d]
            near[cell] = []
            for o in NEIGHBOURS:
                candidates = [(d, p.neighbour(*o, grid.tangent)), (d, p.neighbour(*o, False))]
                near[cell] += [c for c in candidates if c in members][:1]
        for i in range(n_eyes):
            cell = cell_of[i][d]
            if cell[0] == d:
                for k in list(asking[i]):
                    v = value.get((cell, k))
                    if v is None:
                        continue
                    final = worth is not None and worth.settled(rep[cell], k, levels[d])
                    if not final and any(value.get((c, k), v) != v for c in near[cell]):
                        continue
                    out.visible[i, k] = v
                    asking[i].discard(k)
            need[cell_of[i][d + 1]] |= asking[i]
    for i in range(n_eyes):
        for k in asking[i]:
            cell = cell_of[i][-1]
            if (cell, k) not in value:
                value[cell, k] = bool(exact[i, k])
                out.leftover += 1
            out.visible[i, k] = value[cell, k]
    return out


def halton_order(width: int, height: int) -> list[tuple[int, int]]:
    """Positions (x, y) as the Halton sequence of bases 2 and 3 visits them."""

    def inverse(i: int, base: int, digits: int) -> int:
        r = 0
        for _ in range(digits):
            r, i = r * base + i % base, i // base
        return r

    a = next(a for a in range(40) if 2**a >= width)
    b = next(b for b in range(40) if 3**b >= height)
    points = ((inverse(i % 2**a, 2, a), inverse(i % 3**b, 3, b)) for i in range(2**a * 3**b))
    return [(x, y) for x, y in points if x < width and y < height]


def scheme1(key: Sequence[int]) -> tuple[int, int]:
    """Eq. 10: two linear congruential chains; the digest is the high 31 bits of c."""
    m = 2**32 - 1
    kappa, c = 12345, 67890
    for j in key:
        kappa = (kappa * 1664525 + 1013904223 & m) ^ (j & m)
        c = (c * 2891336453 + 1640531513) + j & m
    return kappa * 1664525 + 1013904223 & m, (c * 2891336453 + 1640531513 & m) >> 1


def scheme2(key: Sequence[int]) -> tuple[int, int]:
    """Second scheme of Sec. 4.1: d ← A(C(d)) xor j."""
    m = 2**64 - 1

    def step(d: int) -> int:
        d = d * 2862933555777941757 + 7046029254386353087 & m
        d ^= d << 21 & m
        d ^= d >> 35
        return d ^ (d << 4 & m)

    d = 88172645463325252
    for j in key:
        d = step(d) ^ (j & 2**32 - 1)
    d = step(d)
    return d >> 32, d & 0x7FFFFFFF
