# mypy: disable-error-code="misc, no-untyped-def, type-arg"
"""
Correlation statistics of visibility.
"""
from __future__ import annotations
import collections.abc
import numpy
import numpy.typing
import typing
import viscache._core
import viscache._core.vlf
__all__: list[str] = ['PairRows', 'aligned_rows', 'and_popcount_add', 'area_points', 'camera_points', 'intersections', 'near_pairs', 'pair_statistics', 'point_rows', 'spatial_groups', 'spatial_map', 'tiles', 'total_intersections', 'visibility_rows']
class PairRows:
    """
    Points, their bit rows, and the rules of the statistics.
    """
    def __init__(self, bits: typing.Annotated[numpy.typing.ArrayLike, numpy.uint64], n_directions: typing.SupportsInt | typing.SupportsIndex, positions: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], normals: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], group: typing.Annotated[numpy.typing.ArrayLike, numpy.int32], n_groups: typing.SupportsInt | typing.SupportsIndex, domain: str, directions: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], min_bits: typing.SupportsInt | typing.SupportsIndex, one_if_both: bool) -> None:
        ...
def aligned_rows(scene: viscache._core.Scene, batch: viscache._core.vlf.AlignedBatch, caster: viscache._core.RayCaster, positions: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], normals: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], directions: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], *, t_max: typing.SupportsFloat | typing.SupportsIndex = ..., choose: bool = True, threads: typing.SupportsInt | typing.SupportsIndex = 0, isa: str | None = None, progress: typing.Any = None) -> tuple:
    """
    The same, traced by the batch, or by the faster engine if `choose` is set. Also whether the batch traced them, and the predicted ns per ray of the batch and of Embree.
    """
def and_popcount_add(steps: typing.SupportsInt | typing.SupportsIndex) -> int:
    """
    Baseline of the bench: and, popcount and add of 512 bits, repeated `steps` times.
    """
def area_points(scene: viscache._core.Scene, n: typing.SupportsInt | typing.SupportsIndex, seed: typing.SupportsInt | typing.SupportsIndex) -> dict:
    """
    Points with uniform density over the surface area; the same fields.
    """
def camera_points(scene: viscache._core.Scene, caster: viscache._core.RayCaster, camera: viscache._core.Camera, n: typing.SupportsInt | typing.SupportsIndex, seed: typing.SupportsInt | typing.SupportsIndex, threads: typing.SupportsInt | typing.SupportsIndex = 0) -> dict:
    """
    Primary hits: position, normal, shading_normal (N, 3), group, stratum (N,), width, height, bad_normals, misses.
    """
def intersections(bits_a: typing.Annotated[numpy.typing.ArrayLike, numpy.uint64], bits_b: typing.Annotated[numpy.typing.ArrayLike, numpy.uint64], threads: typing.SupportsInt | typing.SupportsIndex = 0, isa: str | None = None) -> numpy.typing.NDArray[numpy.int32]:
    """
    Number of directions that are visible in both rows, (NA, NB).
    """
def near_pairs(rows: PairRows, d_edges: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], theta_edges_deg: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], threads: typing.SupportsInt | typing.SupportsIndex = 0, isa: str | None = None, progress: typing.Any = None) -> dict:
    """
    Sums over all pairs that are closer than the last edge of distance.
    """
def pair_statistics(rows: PairRows, d_edges: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], theta_edges_deg: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], tiles: collections.abc.Sequence[typing.SupportsInt | typing.SupportsIndex] | None, tile: typing.SupportsInt | typing.SupportsIndex, threads: typing.SupportsInt | typing.SupportsIndex = 0, isa: str | None = None, skip_dead: bool = True, progress: typing.Any = None) -> dict:
    """
    Sums over the pairs of tiles; see viscache.correlation.pair_statistics.
    """
def point_rows(scene: viscache._core.Scene, source: viscache._core.OracleSource, positions: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], normals: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], ends: dict, *, threads: typing.SupportsInt | typing.SupportsIndex = 0, progress: typing.Any = None) -> tuple:
    """
    Bit rows (N, words) uint64 of far ends that are points, the number of rays, and what the engines did.
    """
def spatial_groups(positions: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]) -> numpy.typing.NDArray[numpy.int32]:
    """
    Group numbers (N,): sixteen compact groups of nearly equal size.
    """
def spatial_map(rows: PairRows, d_max: typing.SupportsFloat | typing.SupportsIndex, theta_max_deg: typing.SupportsFloat | typing.SupportsIndex, threads: typing.SupportsInt | typing.SupportsIndex = 0, isa: str | None = None, progress: typing.Any = None) -> numpy.typing.NDArray[numpy.float32]:
    """
    Mean ρ between every point and its neighbours.
    """
def tiles(group: typing.Annotated[numpy.typing.ArrayLike, numpy.int32], n_groups: typing.SupportsInt | typing.SupportsIndex, tile: typing.SupportsInt | typing.SupportsIndex) -> numpy.typing.NDArray[numpy.int64]:
    """
    One row (K, 7) per tile: groups a and b, first and last point of a and of b, number of pairs.
    """
def total_intersections(bits_a: typing.Annotated[numpy.typing.ArrayLike, numpy.uint64], bits_b: typing.Annotated[numpy.typing.ArrayLike, numpy.uint64], threads: typing.SupportsInt | typing.SupportsIndex = 0, isa: str | None = None, skip_dead: bool = True) -> int:
    """
    Sum of the intersections over all pairs of rows.
    """
def visibility_rows(scene: viscache._core.Scene, caster: viscache._core.RayCaster, positions: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], normals: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], directions: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], *, t_max: typing.SupportsFloat | typing.SupportsIndex = ..., order: viscache._core.PacketOrder | None = None, threads: typing.SupportsInt | typing.SupportsIndex = 0, progress: typing.Any = None) -> tuple:
    """
    Bit rows (N, words) uint64 and the number of rays.
    """
