"""Marks for values that were not given: they act as their value, and presets replace them."""

from __future__ import annotations

from typing import Any


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


#: Types of values, and what marks them.
MARKS: tuple[tuple[Any, Any], ...] = ((int, _Int), (float, _Float), (str, _Text), (tuple, _Tuple))


def not_given(value: Any) -> Any:
    """The value marked as not given; what is no number, text, tuple or flag stays as it is."""
    if isinstance(value, bool):
        return _Flag(value)
    for kind, marked in MARKS:
        if isinstance(value, kind):
            return marked(value)
    return value


def plain(value: Any) -> Any:
    """The value without its mark."""
    if isinstance(value, _Flag):
        return bool(value)
    for kind, marked in MARKS:
        if isinstance(value, marked):
            return kind(value)
    return value
