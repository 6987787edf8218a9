"""Errors for unknown keywords name the nearest known one; `repr` shows what differs."""

from __future__ import annotations

import dataclasses
import difflib
import functools
import inspect
from collections.abc import Callable, Iterable, Mapping
from typing import Any, TypeVar

#: Parameters that went, by who had them, and what there is instead.
GONE = {
    "AmbientOcclusion.cosmin": "it is 0.05",
    "AmbientOcclusion.p_mode": "densities are those of the last vertex",
    "Aqvc.refinement_groups": 'give the mapping to refinement=, as in refinement={"area": "on"}',
    "Bdpt.cosmin": "it is 0.05",
    "Direct.cosmin": "it is 0.05",
    "Direct.light_choice": "lights are chosen by contribution",
    "Direct.p_mode": "densities are those of the last vertex",
    "PaperForm.level_rule": 'write Aqvc(c_finest="log2") for the levels of the paper',
    "PaperForm.res_rule": "Bdpt uses Eq. 6, other integrators Eq. 7",
    "Whitted.cosmin": "it is 0.05",
    "Whitted.light_choice": "lights are chosen by contribution",
    "Whitted.p_mode": "densities are those of the last vertex",
    "Whitted.vpl_candidates": "it is 4",
    "Whitted.vpl_eye_points": "it is 64",
    "correlate.store": "it is called directory",
    "measure.spatial": "local means are always measured",
    "measure.store": "it is called directory",
    "passes_over_time.reference_passes": "give their number to reference=",
    "tune.between": 'give it to parameter=, as in parameter={"cell": (0.02, 2)}',
    "tune.metric": "the target names its metric, rel_l1_reflected= or rel_l1=",
}

Called = TypeVar("Called", bound=Callable[..., Any])
Class = TypeVar("Class", bound=type[Any])


def nearest(name: str, known: Iterable[str]) -> str:
    """'; did you mean "x"?' or '; known: ...': the end of a message about an unknown name."""
    names = list(known)
    close = difflib.get_close_matches(name, names, 1, cutoff=0.5)
    if close:
        return f"; did you mean {close[0]!r}?"
    return f"; known: {', '.join(names)}" if names else "; there are none"


def unknown(whose: str, name: str, known: Iterable[str]) -> str:
    """The error for a parameter that there is not: what came instead, or the nearest known name."""
    instead = GONE.get(f"{whose}.{name}")
    return f"{whose} has no parameter {name!r}" + (
        f": {instead}" if instead else nearest(name, known)
    )


def by_symbol(values: Mapping[str, Any]) -> dict[str, Any]:
    """Parameters by their names, where some have the papers' symbols: `C_E` is c_e.

    TypeError if one has both.
    """
    named: dict[str, Any] = {}
    for given, value in values.items():
        name = given.lower() if given.rpartition(".")[2].isupper() else given
        if name in named:
            raise TypeError(f"{name} must be given once, got {given} too")
        named[name] = value
    return named


def spelled(called: Called) -> Called:
    """Decorate a class or function: an unknown keyword raises TypeError with the nearest known one.

    The papers' symbols are known, too: `C_E`. Signatures, `help`, pickling and
    `dataclasses.replace` stay as they are.
    """
    function = called.__init__ if isinstance(called, type) else called  # type: ignore[misc]
    known = [
        name
        for name, parameter in inspect.signature(function).parameters.items()
        if parameter.kind in (parameter.POSITIONAL_OR_KEYWORD, parameter.KEYWORD_ONLY)
        and name != "self"
    ]
    accepted = frozenset(known)
    public = [name for name in known if not name.startswith("_")]
    whose = called.__name__

    @functools.wraps(function)
    def checked(*args: Any, **kwargs: Any) -> Any:
        __tracebackhide__ = True  # pytest shows the caller
        if not accepted.issuperset(kwargs):
            kwargs = by_symbol(kwargs)
        if not accepted.issuperset(kwargs):
            name = next(name for name in kwargs if name not in accepted)
            raise TypeError(unknown(whose, name, public))
        return function(*args, **kwargs)

    if not isinstance(called, type):
        return checked  # type: ignore[return-value]
    called.__init__ = checked  # type: ignore[misc]
    return called


def keywords_of(settings: type[Any], *without: str, **usual: Any) -> Callable[[Called], Called]:
    """Decorate a function whose `**keywords` are the fields of a dataclass: `help` lists them.

    All but those that it goes `without`; `usual` are defaults that differ from the dataclass's,
    also where None is given.
    """
    fields = [f for f in dataclasses.fields(settings) if f.kw_only and f.name not in without]

    def decorate(called: Called) -> Called:
        own = inspect.signature(called)
        named = [p for p in own.parameters.values() if p.kind is not p.VAR_KEYWORD]
        more = [
            inspect.Parameter(
                f.name,
                inspect.Parameter.KEYWORD_ONLY,
                default=usual.get(f.name, f.default),
                annotation=f.type,
            )
            for f in fields
        ]

        @functools.wraps(called)
        def filled(*args: Any, **kwargs: Any) -> Any:
            given = {n: v for n, v in kwargs.items() if v is not None or n not in usual}
            return called(*args, **(usual | given))

        filled.__signature__ = own.replace(  # type: ignore[attr-defined]
            parameters=[*named, *more]
        )
        return filled  # type: ignore[return-value]

    return decorate


def setting(cls: Class) -> Class:
    """Decorate a dataclass of settings: `spelled`, and `repr` shows what differs from the preset.

    Without a preset: from the defaults.
    """
    type.__setattr__(cls, "__repr__", _what_differs)
    return spelled(cls)


def _what_differs(self: Any) -> str:
    given = {f.name: getattr(self, f.name) for f in dataclasses.fields(self) if f.repr}
    preset = {"preset": given["preset"]} if "preset" in given else {}
    usual, base = type(self)(), type(self)(**preset)
    shown = ", ".join(
        f"{name}={value!r}"
        for name, value in given.items()
        if value != getattr(usual if name in preset else base, name)
    )
    return f"{type(self).__qualname__}({shown})"
