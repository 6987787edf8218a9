"""Points, normals and rows of bits for the tests of pairs."""

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from reference import vismap as reference

SUMS = ("n", "n_undefined", "sum_q")


@dataclass(frozen=True, kw_only=True)
class Points:
    """Arguments of pair_statistics, with the bits as booleans beside."""

    visible: npt.NDArray[np.bool_]
    positions: npt.NDArray[np.float32]
    normals: npt.NDArray[np.float32]
    group: npt.NDArray[np.int32]
    directions: npt.NDArray[np.float32] | None = None
    bits: npt.NDArray[np.uint64] = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "bits", reference.packed(self.visible))

    @property
    def arguments(self):
        return self.bits, self.visible.shape[1], self.positions, self.normals, self.group


def unit(v: npt.NDArray[np.float64]) -> npt.NDArray[np.float32]:
    return (v / np.linalg.norm(v, axis=1, keepdims=True)).astype(np.float32)


def random_points(n: int = 300, n_directions: int = 500, seed: int = 0, groups: int = 3) -> Points:
    """Unrelated bits of all densities, with rows that are empty, full and of a single bit."""
    random = np.random.default_rng(seed)
    visible = random.random((n, n_directions)) < random.random((n, 1))
    visible[: n // 10] = 0
    visible[n // 10 : n // 10 + 3] = 1
    visible[n // 2, 1:] = 0
    visible[n // 2, 0] = 1
    positions = random.random((n, 3)).astype(np.float32)
    positions[n - 5 :] = positions[0]  # some at the same place
    normals = unit(random.normal(size=(n, 3)))
    normals[1], normals[2] = -normals[0], normals[0]
    shuffled = random.permutation(n)
    group = np.sort(random.integers(0, groups, n)).astype(np.int32)
    return Points(
        visible=visible[shuffled],
        positions=positions[shuffled],
        normals=normals[shuffled],
        group=group,
    )


def bumpy(n: int, n_directions: int = 500, seed: int = 0) -> Points:
    """A bumpy patch of 4×4 units; a point sees what is above it, less a random blob of sky."""
    rng = np.random.default_rng(seed)
    directions = unit(rng.normal(size=(n_directions, 3)))
    positions = np.column_stack([rng.uniform(0, 4, (n, 2)), rng.normal(0, 0.05, n)])
    normals = unit(np.column_stack([rng.normal(0, 0.5, (n, 2)), np.ones(n)]))
    blob = np.array([np.cos(positions[:, 0]), np.sin(positions[:, 1]), np.full(n, 0.4)]).T
    visible = (normals @ directions.T > 0) & (blob @ directions.T < 0.6)
    visible[::17] = False  # some points see nothing at all
    return Points(
        visible=visible,
        positions=positions.astype(np.float32),
        normals=normals,
        group=np.zeros(n, np.int32),
    )


def convex_points(n: int, edge: int = 96, seed: int = 0) -> Points:
    """Points that see the whole half space above them, as on a convex body."""
    random = np.random.default_rng(seed)
    directions = reference.equal_area_directions(edge)
    normals = unit(random.normal(size=(n, 3)))
    return Points(
        visible=normals @ directions.T > 0,
        positions=random.random((n, 3)).astype(np.float32),
        normals=normals,
        group=np.zeros(n, np.int32),
        directions=directions,
    )
