# mypy: disable-error-code="misc, no-untyped-def, type-arg"
"""
The visibility field.
"""
from __future__ import annotations
import numpy
import numpy.typing
import typing
import viscache._core
__all__: list[str] = ['AlignedBatch', 'direction_frames', 'direction_weights', 'directions', 'embree_rows', 'is_direction_count', 'nearest_direction']
class AlignedBatch:
    def __init__(self, scene: viscache._core.Scene) -> None:
        ...
    def rows(self, scene: viscache._core.Scene, points: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], normals: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], frames: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], *, t_max: typing.SupportsFloat | typing.SupportsIndex = ..., threads: typing.SupportsInt | typing.SupportsIndex = 0, isa: str | None = None, progress: typing.Any = None) -> tuple:
        """
        Rows of bits (N, words), 1 = free, and how much work it was.
        """
    @property
    def bytes(self) -> int:
        ...
    @property
    def triangles(self) -> int:
        ...
def direction_frames(n_directions: typing.SupportsInt | typing.SupportsIndex) -> numpy.typing.NDArray[numpy.float32]:
    """
    Rows u, v, w of (l, 3, 3).
    """
def direction_weights(n_directions: typing.SupportsInt | typing.SupportsIndex) -> numpy.typing.NDArray[numpy.float32]:
    """
    Solid angles (l,), in sr.
    """
def directions(n_directions: typing.SupportsInt | typing.SupportsIndex) -> numpy.typing.NDArray[numpy.float32]:
    """
    Unit axes (l, 3).
    """
def embree_rows(caster: viscache._core.EmbreeCaster, points: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], normals: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], frames: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], *, t_max: typing.SupportsFloat | typing.SupportsIndex = ..., by_axis: bool = True, width: typing.SupportsInt | typing.SupportsIndex = 16, coherent: bool = False, threads: typing.SupportsInt | typing.SupportsIndex = 0, progress: typing.Any = None) -> numpy.typing.NDArray[numpy.uint64]:
    """
    The same bits by Embree.
    """
def is_direction_count(n: typing.SupportsInt | typing.SupportsIndex) -> bool:
    ...
def nearest_direction(directions: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], n_directions: typing.SupportsInt | typing.SupportsIndex) -> numpy.typing.NDArray[numpy.uint32]:
    """
    Index of the axis nearest to each row.
    """
