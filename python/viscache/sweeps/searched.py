"""The number that `tune` searches: a parameter of the visibility, or the share of `vc.Correct`."""

from __future__ import annotations

import dataclasses
import math
import types
import typing
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from viscache.oracles.correct import Correct
from viscache.settings import by_name
from viscache.settings.checks import is_whole, require
from viscache.settings.spelling import nearest
from viscache.settings.visibility import Aqvc
from viscache.sweeps.samples import Setting
from viscache.sweeps.search import Span

#: The range of C_E, and the first two pilots. The error rises with C_E.
C_E = Span(low=0.25, high=128.0, first=(4.0, 16.0), rises=True)
SHARE = "use.share"


@dataclass(frozen=True, slots=True, kw_only=True)
class Searched:
    """A parameter, where to search it, and the settings it belongs to."""

    parameter: str
    span: Span
    visibility: Any
    use: Any
    joint: bool = False
    """No parameter was named, so others may be chosen with it."""

    @property
    def is_c_e(self) -> bool:
        """Whether it is C_E of the quantized cache."""
        return isinstance(self.visibility, Aqvc) and self.parameter == "c_e"

    @property
    def is_joint(self) -> bool:
        """Whether `c_finest` and `bright` are chosen with C_E."""
        cells = self.is_c_e and self.visibility.c_finest != "log2"
        return self.joint and cells and self.visibility.paper.form == "waves"

    def at(self, value: float, also: Mapping[str, float] | None = None) -> Setting:
        """The settings with this value, and others with it."""
        if self.parameter == SHARE:
            return self.visibility, dataclasses.replace(self.use, share=value)
        values = {self.parameter: value, **(also or {})}
        return by_name.replaced(self.visibility, values, "visibility"), self.use


def searched(
    visibility: Any, use: Any, parameter: str | Mapping[str, tuple[float, float]] | None
) -> Searched:
    """What a call of `tune` asks for.

    ValueError if there is no such parameter, it is not a number, or the range does not fit.
    """
    between = None
    if isinstance(parameter, Mapping):
        require(len(parameter) == 1, "parameter must have one name", parameter)
        ((parameter, between),) = parameter.items()
    kinds = _numbers(visibility)
    if isinstance(use, Correct):
        kinds[SHARE] = float
    require(bool(kinds), "visibility must have a parameter that is a number", visibility)
    name = _name(visibility, parameter, kinds)
    whole = kinds[name] is int
    if name == "c_e" and isinstance(visibility, Aqvc):
        low, high = _ends(between, whole) if between is not None else (C_E.low, C_E.high)
        span = C_E if between is None else Span(low=low, high=high, rises=True)
    else:
        low, high = _ends(between, whole)
        span = Span(low=low, high=high, whole=whole)
    joint = parameter is None and use in (None, "replace")
    found = Searched(parameter=name, span=span, visibility=visibility, use=use, joint=joint)
    for end in (low, high):  # a value out of the parameter's own range is refused here
        found.at(end)
    return found


def _name(visibility: Any, parameter: str | None, kinds: dict[str, type]) -> str:
    if parameter is None:
        if isinstance(visibility, Aqvc):
            return "c_e"
        one = len(kinds) == 1
        require(one, f"parameter must be one of {', '.join(kinds)}", parameter)
        return next(iter(kinds))
    require(isinstance(parameter, str), "parameter must be a name", parameter)
    name = parameter.removeprefix("visibility.")
    if name in kinds:
        return name
    if dataclasses.is_dataclass(visibility) and name in by_name.parameters(visibility):
        known = ", ".join(kinds)
        raise ValueError(f"parameter must be a number: one of {known}, got {name!r}")
    whose = type(visibility).__name__
    raise ValueError(f"visibility {whose} has no parameter {name!r}{nearest(name, kinds)}")


def _ends(between: Any, whole: bool) -> tuple[float, float]:
    what = "whole numbers" if whole else "numbers"
    must = f"parameter must be {{name: (low, high)}}, two {what} with low < high"
    pair = isinstance(between, Sequence) and not isinstance(between, str) and len(between) == 2
    require(pair, must, between)
    for end in between:
        number = isinstance(end, int | float) or is_whole(end)
        fits = number and not isinstance(end, bool) and math.isfinite(end)
        require(fits and (not whole or end == int(end)), must, between)
    low, high = ((int(v) if whole else float(v)) for v in between)
    require(low < high, must, between)
    return low, high


def _numbers(settings: Any) -> dict[str, type]:
    """Names of the parameters that are numbers, each with int or float."""
    found: dict[str, type] = {}
    if not dataclasses.is_dataclass(settings) or isinstance(settings, type):
        return found
    try:
        hints = typing.get_type_hints(type(settings))
    except NameError:  # an annotation names what only its function knew
        hints = {}
    for field in dataclasses.fields(settings):
        value = getattr(settings, field.name)
        if dataclasses.is_dataclass(value) and not isinstance(value, type):
            found |= _numbers(value)
            continue
        hint = hints.get(field.name, type(value))
        union = typing.get_origin(hint) in (typing.Union, types.UnionType)
        kinds = [k for k in (float, int) if k in (typing.get_args(hint) if union else (hint,))]
        if kinds:
            found[field.name] = kinds[0]
    return found
