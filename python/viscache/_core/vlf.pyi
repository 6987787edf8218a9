# mypy: disable-error-code="misc, no-untyped-def, type-arg"
"""
The visibility field.
"""
from __future__ import annotations
import numpy
import numpy.typing
import typing
__all__: list[str] = ['direction_frames', 'direction_weights', 'directions', 'is_direction_count', 'nearest_direction']
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
def is_direction_count(n: typing.SupportsInt | typing.SupportsIndex) -> bool:
    ...
def nearest_direction(directions: typing.Annotated[numpy.typing.ArrayLike, numpy.float32], n_directions: typing.SupportsInt | typing.SupportsIndex) -> numpy.typing.NDArray[numpy.uint32]:
    """
    Index of the axis nearest to each row.
    """
