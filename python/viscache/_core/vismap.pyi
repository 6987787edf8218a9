# mypy: disable-error-code="misc, no-untyped-def, type-arg"
"""
Visibility maps and product sampling of the environment.
"""
from __future__ import annotations
import collections.abc
import numpy
import numpy.typing
import typing
import viscache._core
import viscache._core.sampling
__all__: list[str] = ['EnvironmentPyramid', 'PointEstimate', 'ProductTree', 'best_alpha', 'control_variate_estimate', 'correlation', 'least_residual_variance', 'morton2', 'points', 'product_terms', 'reflection_at_nodes', 'regressed_alpha', 'residual_variance', 'time_product']
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
class PointEstimate:
    """
    Light × reflection × maps at one point, all of them tables.
    """
    def __init__(self, light: EnvironmentPyramid, b: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], maps: typing.Annotated[numpy.typing.ArrayLike, numpy.bool], beta: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], *, dilated: collections.abc.Sequence[typing.Annotated[numpy.typing.ArrayLike, numpy.bool]] = [], eta: typing.SupportsFloat | typing.SupportsIndex = 1.0) -> None:
        """
        b (N, N, 3); maps (n, 2^m, 2^m) of bool; dilated: its two (m < 6) or three growths.
        """
    def b_tilde(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        Luminance of B̃ of the texels, (R, R).
        """
    def cells(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        Ṽ, (2^m, 2^m).
        """
    def density(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        D of the texels, (R, R).
        """
    def flat(self, isa: str) -> tuple[float, float, typing.Annotated[list[float], "FixedSize(3)"], typing.Annotated[list[float], "FixedSize(3)"]]:
        """
        J, ∫ L·B̃·Ṽ², J per channel, ∫ L·B̃·Ṽ^k by one instruction set.
        """
    def guided_masses(self, level: typing.SupportsInt | typing.SupportsIndex) -> numpy.typing.NDArray[numpy.float64]:
        """
        ∫ L·B̃·D over the nodes of a level, along the Morton curve.
        """
    def probabilities(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        Probability of every texel, (R, R).
        """
    def sample(self, u: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> dict:
        """
        texel, f, g, z, w and D of the points (N, 2) of the square.
        """
    def simulate(self, visible: typing.Annotated[numpy.typing.ArrayLike, numpy.bool], *, n: typing.SupportsInt | typing.SupportsIndex, passes: typing.SupportsInt | typing.SupportsIndex = 1, replicates: typing.SupportsInt | typing.SupportsIndex = 1, set: viscache._core.PointSet = viscache._core.PointSet.INDEPENDENT, mode: viscache._core.AlphaMode = viscache._core.AlphaMode.FIXED, alpha: typing.SupportsFloat | typing.SupportsIndex = 1.0, seed: typing.SupportsInt | typing.SupportsIndex = 0, threads: typing.SupportsInt | typing.SupportsIndex = 1) -> numpy.typing.NDArray[numpy.float64]:
        """
        Estimates (replicates, passes, 3) with the true visibility (R, R) of bool.
        """
    def walk(self) -> tuple[float, float, int]:
        """
        J and ∫ L·B̃·Ṽ² by the joint quadtree walk, and the nodes visited.
        """
    @property
    def dilated(self) -> typing.Annotated[list[float], "FixedSize(3)"]:
        """
        ∫ L·B̃·Ṽ^k.
        """
    @property
    def guided(self) -> bool:
        ...
    @property
    def j(self) -> typing.Annotated[list[float], "FixedSize(3)"]:
        """
        J per channel.
        """
    @property
    def j_luminance(self) -> float:
        ...
    @property
    def l_ns(self) -> float:
        ...
    @property
    def mean_w(self) -> float:
        ...
    @property
    def variance_w(self) -> float:
        ...
    @property
    def w2(self) -> float:
        """
        ∫ L·B̃·Ṽ² of luminances.
        """
def best_alpha(var_w: typing.SupportsFloat | typing.SupportsIndex, covariance: typing.SupportsFloat | typing.SupportsIndex) -> float:
    ...
def control_variate_estimate(sum_f: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], sum_g: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], j: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], alpha: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], n: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> typing.Any:
    """
    Eq. 2 for one channel.
    """
def correlation(var_z: typing.SupportsFloat | typing.SupportsIndex, var_w: typing.SupportsFloat | typing.SupportsIndex, covariance: typing.SupportsFloat | typing.SupportsIndex) -> float:
    """
    Eq. 6: ρ.
    """
def least_residual_variance(var_z: typing.SupportsFloat | typing.SupportsIndex, rho: typing.SupportsFloat | typing.SupportsIndex) -> float:
    """
    Eq. 5: variance at the best α.
    """
def morton2(x: typing.SupportsInt | typing.SupportsIndex, y: typing.SupportsInt | typing.SupportsIndex) -> int:
    """
    Z-order number of a cell, x in the even bits.
    """
def points(set: viscache._core.PointSet, count: typing.SupportsInt | typing.SupportsIndex, *, seed: typing.SupportsInt | typing.SupportsIndex = 0, pixel: typing.SupportsInt | typing.SupportsIndex = 0, pass_: typing.SupportsInt | typing.SupportsIndex = 0) -> numpy.typing.NDArray[numpy.float64]:
    """
    Random or randomised (0, 2)-sequence points of the square, (count, 2).
    """
def product_terms(b_over_b_tilde: typing.SupportsFloat | typing.SupportsIndex, visible: typing.SupportsFloat | typing.SupportsIndex, approximate: typing.SupportsFloat | typing.SupportsIndex, d: typing.SupportsFloat | typing.SupportsIndex = 1.0) -> tuple[float, float]:
    """
    Eq. 3: Z and W.
    """
def reflection_at_nodes(shading: viscache._core.sampling.ShadingPoint, level: typing.SupportsInt | typing.SupportsIndex, first: typing.SupportsInt | typing.SupportsIndex) -> tuple[numpy.typing.NDArray[numpy.float32], numpy.typing.NDArray[numpy.float32]]:
    """
    Sixteen node centres (16, 3) and B = f·cos there, as the tree sees it (16, 3).
    """
def regressed_alpha(z: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], w: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], var_w: typing.SupportsFloat | typing.SupportsIndex) -> float:
    """
    α from samples (N,), both less the mean of W.
    """
def residual_variance(var_z: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], var_w: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], covariance: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], alpha: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> typing.Any:
    """
    Eq. 4: variance of Z − αW.
    """
def time_product(light: EnvironmentPyramid, shading: collections.abc.Sequence[viscache._core.sampling.ShadingPoint], samples: typing.SupportsInt | typing.SupportsIndex, map_level: typing.SupportsInt | typing.SupportsIndex = 5) -> dict:
    """
    CPU seconds per tree and per sample over the shading points, and the mean number of leaves.
    """
