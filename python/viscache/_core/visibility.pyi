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
__all__: list[str] = ['TriangleKernel', 'flat_triangles', 'triangle_hits']
class TriangleKernel(enum.Enum):
    """
    Ray against triangle.
    """
    WALD: typing.ClassVar[TriangleKernel]
    WATERTIGHT: typing.ClassVar[TriangleKernel]
    @classmethod
    def __new__(cls, value):
        ...
def flat_triangles(scene: viscache._core.Scene) -> dict:
    """
    Placed triangles: corners (T, 3, 3), mesh, triangle and instance (-1: none), and the number of degenerate ones, left out.
    """
def triangle_hits(kernel: TriangleKernel, a: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], b: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], c: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], origins: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], directions: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], t_min: typing.SupportsFloat | typing.SupportsIndex = 0.0, t_max: typing.SupportsFloat | typing.SupportsIndex = ...) -> numpy.typing.NDArray[numpy.float32]:
    """
    Ray i against triangle (a, b, c)[i]: rows (t, u, v) for t_min < t <= t_max, NaN where it misses.
    """
