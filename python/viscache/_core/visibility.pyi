# mypy: disable-error-code="misc, no-untyped-def, type-arg"
"""
Ray casters and their parts.
"""
from __future__ import annotations
import numpy
import numpy.typing
import typing
import viscache._core
__all__: list[str] = ['BspCaster', 'BspSettings', 'WatertightCaster']
class BspSettings:
    """
    Settings of the BSP; see viscache.Bsp.
    """
    @staticmethod
    def parameter_rows() -> list:
        """
        Name, kind, range, uses and doc of every parameter, as the C++ table has them.
        """
    def __getattr__(self, arg0: str) -> typing.Any:
        ...
    def __init__(self, **kwargs) -> None:
        ...
    def __setattr__(self, arg0: str, arg1: typing.Any) -> None:
        ...
class BspCaster(viscache._core.RayCaster):
    """
    Traces single rays through a BSP tree.
    """
    def __init__(self, scene: viscache._core.Scene, settings: BspSettings, *, threads: typing.SupportsInt | typing.SupportsIndex = 0) -> None:
        ...
    def count_steps(self, origins: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], directions: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]) -> dict:
        """
        Visited nodes, visited leaves and tested triangles of nearest-hit queries, summed over all rays.
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
class WatertightCaster(viscache._core.RayCaster):
    """
    Embree finds candidates, the watertight test of triangles decides.
    """
    def __init__(self, scene: viscache._core.Scene) -> None:
        ...
    def intersect(self, origins: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], directions: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], threads: typing.SupportsInt | typing.SupportsIndex = 0) -> tuple:
        ...
    def occluded(self: viscache._core.RayCaster, origins: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], directions: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], t_max: typing.Any, threads: typing.SupportsInt | typing.SupportsIndex = 0) -> numpy.typing.NDArray[numpy.bool]:
        ...
    def visible(self: viscache._core.RayCaster, x: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], y: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], threads: typing.SupportsInt | typing.SupportsIndex = 0) -> numpy.typing.NDArray[numpy.bool]:
        ...
    def visible_matrix(self: viscache._core.RayCaster, points: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], targets: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], threads: typing.SupportsInt | typing.SupportsIndex = 0, progress: typing.Any = None) -> numpy.typing.NDArray[numpy.uint64]:
        ...
