# mypy: disable-error-code="misc, no-untyped-def, type-arg"
"""
Quantized visibility cache (AQVC).
"""
from __future__ import annotations
import collections.abc
import numpy
import numpy.typing
import typing
__all__: list[str] = ['AqvcParameters', 'full_keys', 'hash_keys', 'level_hashes', 'resolution_eye']
class AqvcParameters:
    """
    Parameters of the quantized cache; see viscache.Aqvc.
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
    def level_list(self, group: typing.SupportsInt | typing.SupportsIndex, *, spp: typing.SupportsInt | typing.SupportsIndex = 1, lift: typing.SupportsFloat | typing.SupportsIndex = 1.0) -> list[float]:
        """
        C_E of every level of a light group, coarse to fine.
        """
def full_keys(parameters: AqvcParameters, center: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], radius: typing.SupportsFloat | typing.SupportsIndex, points: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], normals: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], resolutions: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], semantic: typing.SupportsInt | typing.SupportsIndex, far: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], far_normals: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], far_resolutions: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], dx: typing.SupportsInt | typing.SupportsIndex = 0, dy: typing.SupportsInt | typing.SupportsIndex = 0) -> tuple:
    """
    Keys of AQVC Sec. 3.3 and 3.5.
    """
def hash_keys(keys: typing.Annotated[numpy.typing.ArrayLike, numpy.int32], scheme: str = 'scheme2') -> numpy.typing.NDArray[numpy.uint32]:
    """
    AQVC Eq. 10: (κ, c).
    """
def level_hashes(parameters: AqvcParameters, center: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(3)"], radius: typing.SupportsFloat | typing.SupportsIndex, points: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], normals: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], resolutions: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], lights: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], *, at_once: bool) -> tuple:
    """
    κ and digest (N, 4) of points (N, 3) at four resolutions (N, 4) with one point light each, and the CPU seconds. `at_once` hashes four levels together instead of one by one.
    """
def resolution_eye(arg0: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], arg1: typing.Annotated[numpy.typing.ArrayLike, numpy.float64], arg2: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> typing.Any:
    """
    AQVC Eq. 7, eye side: D_e, C_E, B_R.
    """
