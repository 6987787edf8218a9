# mypy: disable-error-code="misc, no-untyped-def, type-arg"
"""
Ray casters and what they are made of.
"""
from __future__ import annotations
import enum
import numpy
import numpy.typing
import typing
import viscache._core
__all__: list[str] = ['BspCaster', 'BspSettings', 'TriangleKernel']
class TriangleKernel(enum.Enum):
    """
    Ray against triangle.
    """
    WALD: typing.ClassVar[TriangleKernel]
    WATERTIGHT: typing.ClassVar[TriangleKernel]
    @classmethod
    def __new__(cls, value):
        ...
class BspSettings:
    kernel: TriangleKernel
    def __init__(self) -> None:
        ...
    @property
    def leaf_size(self) -> int:
        ...
    @leaf_size.setter
    def leaf_size(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> None:
        ...
    @property
    def max_bytes(self) -> int:
        ...
    @max_bytes.setter
    def max_bytes(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> None:
        ...
    @property
    def max_depth(self) -> int:
        ...
    @max_depth.setter
    def max_depth(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> None:
        ...
class BspCaster(viscache._core.RayCaster):
    """
    Single rays through a BSP.
    """
    def __init__(self, scene: viscache._core.Scene, settings: BspSettings, *, threads: typing.SupportsInt | typing.SupportsIndex = 0) -> None:
        ...
    def count_steps(self, origins: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], directions: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]) -> dict:
        """
        Nodes and leaves visited and triangles tested for the nearest hits, over all rays.
        """
    def intersect(self, origins: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], directions: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], threads: typing.SupportsInt | typing.SupportsIndex = 0) -> tuple:
        ...
    def occluded(self: viscache._core.RayCaster, origins: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], directions: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], t_max: typing.Any, threads: typing.SupportsInt | typing.SupportsIndex = 0) -> numpy.typing.NDArray[numpy.bool]:
        ...
    def visible(self: viscache._core.RayCaster, x: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], y: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], threads: typing.SupportsInt | typing.SupportsIndex = 0) -> numpy.typing.NDArray[numpy.bool]:
        ...
    def visible_matrix(self: viscache._core.RayCaster, points: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], targets: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], threads: typing.SupportsInt | typing.SupportsIndex = 0, progress: typing.Any = None) -> numpy.typing.NDArray[numpy.uint64]:
        ...
    @property
    def stats(self) -> dict:
        ...
