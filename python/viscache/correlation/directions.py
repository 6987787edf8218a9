"""The directions of visibility rows, and the order of their bits."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from viscache import _core
from viscache.settings.checks import check_types, require
from viscache.settings.spelling import spelled

Indices = npt.NDArray[np.int64]

PACKET_BITS = 512
#: A packet is one patch of sky; so are its words, and the 16 bits that share a packet of rays.
PATCHES = (PACKET_BITS, 64, 16, 4, 1)


@spelled
@dataclass(frozen=True, kw_only=True, slots=True)
class DirectionSet:
    """Directions over the whole sphere in world space, the same for every point.

    There is one direction in each cell of the equal-area octahedral map, whose cells have equal
    solid angles. Bit k of a row is direction k. The bits are ordered so that each packet of 512
    bits is a compact patch of sky (16 x 32 cells where the map can be divided this way), and so is
    each word and each group of 16 bits.

    Parameters
    ----------
    map_size : int in [1, 256]
        Cells along an edge of the map; the paper's 96 x 96.
    kind : {"centres", "jittered", "lloyd"}
        Centres of the cells; uniform in each cell; or spread evenly over the sphere by Lloyd's
        iteration, each direction staying in its cell.
    seed : int >= 0
        Of the random kinds.

    Examples
    --------
    >>> import viscache as vc
    >>> sky = vc.correlation.DirectionSet(map_size=96)
    >>> sky.directions.shape, sky.packet_axes.shape
    ((9216, 3), (18, 3))
    """

    map_size: int = 96
    kind: Literal["centres", "jittered", "lloyd"] = "centres"
    seed: int = 0

    def __post_init__(self) -> None:
        check_types(self)
        require(1 <= self.map_size <= 256, "map_size must be in [1, 256]", self.map_size)
        require(0 <= self.seed < 1 << 64, "seed must be in [0, 2^64)", self.seed)

    @property
    def directions(self) -> npt.NDArray[np.float32]:
        """Unit vectors (map_size², 3) in the order of the bits; read-only."""
        return _directions(self.map_size, self.kind, self.seed)

    @property
    def packet_axes(self) -> npt.NDArray[np.float32]:
        """Unit vectors (packets, 3): the mean direction of each packet."""
        first = np.arange(0, self.map_size**2, PACKET_BITS)
        sums = np.add.reduceat(self.directions.astype(np.float64), first)
        axes: npt.NDArray[np.float64] = sums / np.linalg.norm(sums, axis=1, keepdims=True)
        return axes.astype(np.float32)


@lru_cache(maxsize=8)
def _directions(map_size: int, kind: str, seed: int) -> npt.NDArray[np.float32]:
    pattern = _core.sampling.direction_pattern(
        map_size, _core.sampling.PatternKind[kind.upper()], seed
    )
    ordered = pattern[patch_order(map_size)]
    ordered.setflags(write=False)
    return ordered


def patch_order(map_size: int) -> Indices:
    """Cells (map_size²,) of a square map, row-major, in an order in which neighbours stay close.

    The square is halved repeatedly across its longer side. Each part is a whole number of packets,
    then of words, then of 16 and of 4 cells. Cuts are straight where possible.
    """
    y, x = np.divmod(np.arange(map_size**2), map_size)
    return _halved(np.stack([x, y], axis=1), np.arange(map_size**2), 0)


def _halved(places: Indices, cells: Indices, level: int) -> Indices:
    while level < len(PATCHES) and len(cells) <= PATCHES[level]:
        level += 1
    if level == len(PATCHES):
        return cells
    extent = np.ptp(places[cells], axis=0) + 1
    along = int(extent[1] > extent[0])
    order = np.lexsort((places[cells, 1 - along], places[cells, along]))
    cut = _cut(len(cells), PATCHES[level], int(extent[1 - along]))
    first, second = cells[order[:cut]], cells[order[cut:]]
    return np.concatenate([_halved(places, first, level), _halved(places, second, level)])


def _cut(n: int, patch: int, width: int) -> int:
    """The multiple of `patch` nearest to n / 2, preferably a straight cut across `width` cells."""
    cuts = np.arange(patch, n, patch)
    straight = cuts[(cuts % width == 0) & (4 * cuts >= n) & (4 * cuts <= 3 * n)]
    chosen: Any = straight if len(straight) else cuts
    return int(chosen[np.argmin(np.abs(2 * chosen - n))])
