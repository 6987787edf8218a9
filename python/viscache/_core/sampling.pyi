# mypy: disable-error-code="misc, no-untyped-def, type-arg"
"""
Directions, light and reflection.
"""
from __future__ import annotations
import collections.abc
import enum
import numpy
import numpy.typing
import typing
import viscache._core
__all__: list[str] = ['EnvironmentMap', 'PatternKind', 'ShadingPoint', 'direction_pattern', 'direction_to_equal_area', 'equal_area_to_direction', 'eval_bsdf']
class EnvironmentMap:
    """
    Environment light on the equal-area octahedral map.
    """
    @staticmethod
    def constant(radiance: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"]) -> EnvironmentMap:
        ...
    @staticmethod
    def from_latlong(pixels: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], *, scale: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"] = [1.0, 1.0, 1.0], to_world: typing.Annotated[numpy.typing.ArrayLike, numpy.float64] | None = None, resolution: typing.SupportsInt | typing.SupportsIndex = 0, threads: typing.SupportsInt | typing.SupportsIndex = 0) -> EnvironmentMap:
        """
        Resample a lat-long image (H, W, C); to_world (3, 3) rotates the map into the world.
        """
    def eval(self, wi: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]) -> numpy.typing.NDArray[numpy.float32]:
        """
        Radiance (N, 3) that arrives from unit vectors (N, 3).
        """
    def pdf(self, wi: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]) -> numpy.typing.NDArray[numpy.float32]:
        """
        Density of `sample` per solid angle, (N,).
        """
    def sample(self, u: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]) -> tuple[numpy.typing.NDArray[numpy.float32], numpy.typing.NDArray[numpy.float32], numpy.typing.NDArray[numpy.float32]]:
        """
        Directions (N, 3), radiances (N, 3) and densities (N,).
        """
    @property
    def is_constant(self) -> bool:
        ...
    @property
    def pixels(self) -> numpy.ndarray:
        ...
    @property
    def power_ratio(self) -> float:
        ...
    @property
    def resolution(self) -> int:
        ...
    @property
    def total_power(self) -> float:
        ...
class ShadingPoint:
    """
    Normals and material of a shaded point.
    """
    def __init__(self, kind: viscache._core.MaterialKind, wo: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], *, ns: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"] = [0.0, 0.0, 1.0], ng: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"] = [0.0, 0.0, 1.0], base: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"] = [0.0, 0.0, 0.0], specular: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"] = [0.0, 0.0, 0.0], roughness: typing.SupportsFloat | typing.SupportsIndex = 0.10000000149011612, eta: typing.SupportsFloat | typing.SupportsIndex = 1.5, coat: viscache._core.CoatKind = viscache._core.CoatKind.NONE, nonlinear: bool = False, metal_eta: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"] = [0.0, 0.0, 0.0], metal_k: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"] = [0.0, 0.0, 0.0], beckmann: bool = False, f90: typing.SupportsFloat | typing.SupportsIndex = 1.0) -> None:
        ...
class PatternKind(enum.Enum):
    """
    Position of a direction inside its cell.
    """
    CENTRES: typing.ClassVar[PatternKind]
    JITTERED: typing.ClassVar[PatternKind]
    LLOYD: typing.ClassVar[PatternKind]
    @classmethod
    def __new__(cls, value):
        ...
def direction_pattern(map_size: typing.SupportsInt | typing.SupportsIndex, kind: PatternKind, seed: typing.SupportsInt | typing.SupportsIndex) -> numpy.typing.NDArray[numpy.float32]:
    """
    Unit vectors (map_size², 3), one in each cell of the equal-area map, row by row.
    """
def direction_to_equal_area(d: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]) -> numpy.typing.NDArray[numpy.float32]:
    """
    Equal-area octahedral map of unit vectors (N, 3) into [0, 1]², (N, 2).
    """
def equal_area_to_direction(p: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]) -> numpy.typing.NDArray[numpy.float32]:
    """
    Its inverse: (N, 2) to unit vectors (N, 3).
    """
def eval_bsdf(sp: ShadingPoint, wi: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]) -> numpy.typing.NDArray[numpy.float32]:
    """
    f without the cosine factor, (N, 3).
    """
