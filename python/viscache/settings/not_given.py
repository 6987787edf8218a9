"""Marks for values that were not given: they act as their value, and presets replace them."""

from __future__ import annotations

from typing import Any

__all__ = ["NotGiven", "not_given", "plain"]


class NotGiven:
    """Base class of values that were not given."""

    __slots__ = ()


class _Int(NotGiven, int):
    __slots__ = ()


class _Float(NotGiven, float):
    __slots__ = ()


class _Text(NotGiven, str):
    __slots__ = ()


class _Tuple(NotGiven, tuple[Any, ...]):
    __slots__ = ()


class _Flag(NotGiven, int):
    """True or False, which cannot have subclasses."""

    __slots__ = ()

    def __repr__(self) -> str:
        return repr(bool(self))

    __str__ = __repr__


def not_given(value: Any) -> Any:
    """The value marked as not given; what is no number, text, tuple or flag stays as it is."""
    if isinstance(value, bool):
        return _Flag(value)
    if isinstance(value, tuple):
        return _Tuple(value)
    for kind, marked in ((int, _Int), (float, _Float), (str, _Text)):
        if isinstance(value, kind):
            return marked(value)
    return value


def plain(value: Any) -> Any:
    """The value without its mark."""
    if isinstance(value, _Flag):
        return bool(value)
    if isinstance(value, _Tuple):
        return tuple(value)
    for marked, kind in ((_Int, int), (_Float, float), (_Text, str)):
        if isinstance(value, marked):
            return kind(value)
    return value
