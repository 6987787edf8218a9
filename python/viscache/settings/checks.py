"""Checks of arguments: what must hold, what was given."""

from __future__ import annotations

import math
import numbers
import reprlib
import typing
from dataclasses import fields
from types import NoneType
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from viscache.base.real_numbers import real_array
from viscache.settings.not_given import NotGiven


def require(holds: bool, what: str, given: Any) -> None:
    """Raise ValueError("<what>, got <given>") unless the condition holds.

    Comparisons with NaN are false, so ranges refuse it.
    """
    if not holds:
        raise ValueError(f"{what}, got {given!r}")


def require_kept(now: dict[str, Any], before: dict[str, Any], of: str) -> None:
    """Raise ValueError unless settings are those of the frames before; `of`: what was kept."""
    for name, value in now.items():
        what = f"{name} must be {before[name]} as in the {of} frames before"
        require(value == before[name], what, value)


def check_types(settings: Any) -> None:
    """Check every field of a frozen dataclass by its annotation; numbers become Python numbers.

    Checked are int, float (finite), bool, Literal, unions of these with None, and unions of a
    number with a Literal. The class checks fields of other types. Values that were not given are
    not checked. ValueError says `n_vpls must be a whole number, got 1.5`.
    """
    hints = _hints(type(settings))
    for field in fields(settings):
        value = getattr(settings, field.name)
        if isinstance(value, NotGiven):
            continue
        kinds = typing.get_args(hints[field.name]) or (hints[field.name],)
        optional = NoneType in kinds
        if typing.get_origin(hints[field.name]) is Literal:
            kinds = (hints[field.name],)
        if optional and value is None:
            continue
        kind = next(k for k in kinds if k is not NoneType)
        words = [k for k in kinds if typing.get_origin(k) is Literal]
        if isinstance(value, str) and words:  # int | Literal["auto"]
            kind = words[0]
        plain = _plain(field.name, kind, value)
        if plain is not value:
            object.__setattr__(settings, field.name, plain)


_HINTS: dict[type, dict[str, Any]] = {}


def _hints(cls: type) -> dict[str, Any]:
    if cls not in _HINTS:
        _HINTS[cls] = typing.get_type_hints(cls)
    return _HINTS[cls]


def is_whole(value: Any) -> bool:
    """Whether a value is an integer of Python or numpy; True and False are not."""
    return isinstance(value, numbers.Integral) and not isinstance(value, bool)


def is_number(value: Any) -> bool:
    """Whether a value is a real number of Python or numpy; True and False are not."""
    return isinstance(value, numbers.Real) and not isinstance(value, bool)


def _plain(name: str, kind: Any, value: Any) -> Any:
    if typing.get_origin(kind) is Literal:
        words = typing.get_args(kind)
        choices = " or ".join(f'"{w}"' for w in words) if len(words) < 3 else f"one of {words}"
        require(isinstance(value, str) and value in words, f"{name} must be {choices}", value)
    if kind is bool:
        flag = isinstance(value, bool) or type(value).__name__ in ("bool_", "bool")
        require(flag, f"{name} must be true or false", value)
        return bool(value)
    if kind is int:
        require(is_whole(value), f"{name} must be a whole number", value)
        return int(value)
    if kind is float:
        require(is_number(value) and math.isfinite(value), f"{name} must be a finite number", value)
        return float(value)
    return value


def checked_threads(wish: int | None) -> int:
    """The number of threads as the core takes it: 0 for all cores."""
    fits = wish is None or (is_whole(wish) and 1 <= wish <= 1024)
    require(fits, "threads must be a whole number in [1, 1024]", wish)
    return wish or 0


def checked_floats(
    values: npt.ArrayLike, name: str, dtype: type[Any] = np.float32
) -> npt.NDArray[Any]:
    """Numbers of any shape as floats; ValueError where they are none. What overflows is inf."""
    try:
        with np.errstate(over="ignore"):
            return np.asarray(real_array(values, name), dtype=dtype, order="C")
    except (TypeError, ValueError) as error:
        raise ValueError(f"{name} must be numbers, got {reprlib.repr(values)}") from error


def checked_points(
    value: npt.ArrayLike, name: str, *, order: Literal["C", "K"] = "C"
) -> npt.NDArray[np.float32]:
    """Numbers as the core takes them; it checks their shape. Order "K" keeps their layout."""
    array = np.asarray(value)
    if array.dtype.kind not in "fiu":
        raise ValueError(f"{name} must be numbers, got dtype {array.dtype}")
    with np.errstate(over="ignore"):  # what overflows float32 becomes inf and is refused by name
        return np.asarray(array, dtype=np.float32, order=order)
