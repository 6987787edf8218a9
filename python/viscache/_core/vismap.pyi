# mypy: disable-error-code="misc, no-untyped-def, type-arg"
"""
Visibility maps and product sampling of the environment.
"""
from __future__ import annotations
import collections.abc
import enum
import numpy
import numpy.typing
import typing
import viscache._core.sampling
__all__: list[str] = ['EnvironmentPyramid', 'PointSet', 'ProductTree', 'morton2', 'points', 'reflection_at_nodes', 'time_product']
class PointSet(enum.Enum):
    """
    Points of the square.
    """
    INDEPENDENT: typing.ClassVar[PointSet]
    ZERO_TWO: typing.ClassVar[PointSet]
    @classmethod
    def __new__(cls, value):
        ...
class EnvironmentPyramid:
    """
    Sums of luminance × solid angle over the equal-area map.
    """
    def __init__(self, pixels: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]) -> None:
        """
        From N × N texels of the map, N a power of two, row by row.
        """
    def sums(self, level: typing.SupportsInt | typing.SupportsIndex) -> numpy.typing.NDArray[numpy.float64]:
        """
        Sums of the nodes of a level along the Morton curve, (4^level,).
        """
    @property
    def levels(self) -> int:
        ...
    @property
    def total(self) -> float:
        """
        Integral of luminance over the sphere.
        """
class ProductTree:
    """
    L·B̃ over the sphere for one point, to draw directions from.
    """
    @staticmethod
    def of_surface(light: EnvironmentPyramid, shading: viscache._core.sampling.ShadingPoint, map_level: typing.SupportsInt | typing.SupportsIndex = 5) -> ProductTree:
        ...
    @staticmethod
    def of_table(light: EnvironmentPyramid, b: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], map_level: typing.SupportsInt | typing.SupportsIndex = 5) -> ProductTree:
        """
        From B as a table over the map, (N, N, 3).
        """
    def b_tilde(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        B̃ of the texels, (R, R, 3).
        """
    def masses(self, level: typing.SupportsInt | typing.SupportsIndex) -> numpy.typing.NDArray[numpy.float64]:
        """
        Integrals of L·B̃ over the nodes of a level along the Morton curve.
        """
    def sample(self, u: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> tuple:
        """
        Texels drawn by points (N, 2) of the square, row-major numbers (N,), and directions (N, 3).
        """
    def texel_masses(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        Integrals of L·B̃ over the texels, (R, R); over L_ns the probability to be drawn.
        """
    @property
    def dense_level(self) -> int:
        ...
    @property
    def leaves(self) -> int:
        ...
    @property
    def total(self) -> float:
        """
        L_ns, the integral of L·B̃.
        """
def morton2(x: typing.SupportsInt | typing.SupportsIndex, y: typing.SupportsInt | typing.SupportsIndex) -> int:
    """
    Z-order number of a cell, x in the even bits.
    """
def points(set: PointSet, count: typing.SupportsInt | typing.SupportsIndex, *, seed: typing.SupportsInt | typing.SupportsIndex = 0, pixel: typing.SupportsInt | typing.SupportsIndex = 0, pass_: typing.SupportsInt | typing.SupportsIndex = 0) -> numpy.typing.NDArray[numpy.float64]:
    """
    Random or randomised (0, 2)-sequence points of the square, (count, 2).
    """
def reflection_at_nodes(shading: viscache._core.sampling.ShadingPoint, level: typing.SupportsInt | typing.SupportsIndex, first: typing.SupportsInt | typing.SupportsIndex) -> tuple[numpy.typing.NDArray[numpy.float32], numpy.typing.NDArray[numpy.float32]]:
    """
    Sixteen node centres (16, 3) and B = f·cos there, as the tree sees it (16, 3).
    """
def time_product(light: EnvironmentPyramid, shading: collections.abc.Sequence[viscache._core.sampling.ShadingPoint], samples: typing.SupportsInt | typing.SupportsIndex, map_level: typing.SupportsInt | typing.SupportsIndex = 5) -> dict:
    """
    CPU seconds per tree and per sample over the shading points, and the mean number of leaves.
    """
