"""The list of built-in scenes, and building one from text such as `room?triangles=200000`."""

from __future__ import annotations

import functools
import inspect
import numbers
import types
import typing
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, ParamSpec

from viscache.scene import Scene
from viscache.scenes.builder import Builder
from viscache.settings.checks import is_whole, require
from viscache.settings.spelling import nearest

P = ParamSpec("P")


@dataclass(frozen=True, slots=True)
class Range:
    """Values that a parameter of a scene may have; the parameter's type is `Annotated` with it."""

    low: float
    high: float
    open: bool = False
    """Whether the ends are left out."""

    def check(self, name: str, value: Any, *, whole: bool) -> None:
        """Refuse what is no number, not whole where it must be, or outside."""
        require(is_whole(value) or not whole, f"{name} must be a whole number", value)
        number = isinstance(value, numbers.Real) and not isinstance(value, bool)
        require(number, f"{name} must be a number", value)
        if self.open:
            require(self.low < value < self.high, f"{name} must be {self}", value)
        else:
            require(value >= self.low, f"{name} must be >= {_text(self.low)}", value)
            require(value <= self.high, f"{name} must be <= {_text(self.high)}", value)

    def __str__(self) -> str:
        low, high = _text(self.low), _text(self.high)
        return f"> {low} and < {high}" if self.open else f"{low} to {high}"


def _text(number: float) -> str:
    return f"{number:,.10g}"


#: Takes minutes and most of the memory of a large machine.
MOST_TRIANGLES = 100_000_000


@dataclass(frozen=True, kw_only=True, slots=True)
class SceneInfo:
    """One built-in scene."""

    name: str
    function: Callable[..., Any]
    """Builds the scene."""
    builder: Callable[..., Builder]
    """The same, but returns the `Builder` with its records."""
    description: str
    """One-line description."""
    parameters: Mapping[str, Any] = field(default_factory=dict)
    """Name to default, in the order of the signature."""
    ranges: Mapping[str, Range] = field(default_factory=dict)
    """Name to range, of all parameters that are numbers."""


#: Name to scene, in the order `viscache scenes` lists them.
SCENES: dict[str, SceneInfo] = {}


def scene(
    shown: Mapping[str, Any] | None = None,
) -> Callable[[Callable[P, Builder]], Callable[P, Any]]:
    """Register a function that returns a `Builder` as a built-in scene.

    `shown` overrides defaults in `SceneInfo.parameters` where the signature says None.
    """

    def register(function: Callable[P, Builder]) -> Callable[P, Any]:
        def given(*args: P.args, **kwargs: P.kwargs) -> dict[str, Any]:
            named = signature.bind(*args, **kwargs).arguments
            return {k: v for k, v in named.items() if v is not None}

        @functools.wraps(function)
        def checked(*args: P.args, **kwargs: P.kwargs) -> Builder:
            for parameter, value in given(*args, **kwargs).items():
                if parameter in ranges:
                    ranges[parameter].check(parameter, value, whole=parameter in whole)
            return function(*args, **kwargs)

        @functools.wraps(function)
        def make(*args: P.args, **kwargs: P.kwargs) -> Any:
            builder = checked(*args, **kwargs)
            query = "&".join(f"{k}={v}" for k, v in given(*args, **kwargs).items())
            spec = f"{name}?{query}" if query else name
            return Scene.from_description(builder.description, spec=spec)

        name = function.__name__
        signature = inspect.signature(function)
        ranges = _ranges(function)
        whole = {k for k, hint in typing.get_type_hints(function).items() if int in kinds(hint)}
        defaults = {p.name: p.default for p in signature.parameters.values()}
        SCENES[name] = SceneInfo(
            name=name,
            function=make,
            builder=checked,
            description=(inspect.getdoc(function) or "").split("\n")[0].rstrip("."),
            parameters=types.MappingProxyType(defaults | dict(shown or {})),
            ranges=types.MappingProxyType(ranges),
        )
        return make

    return register


def kinds(hint: Any) -> list[Any]:
    """The types of an annotation, without None."""
    return [k for k in typing.get_args(hint) or (hint,) if k is not type(None)]


def _ranges(function: Callable[..., Any]) -> dict[str, Range]:
    hints = typing.get_type_hints(function, include_extras=True)
    notes = {k: getattr(hint, "__metadata__", ()) for k, hint in hints.items()}
    return {k: note for k, found in notes.items() for note in found if isinstance(note, Range)}


def parse(spec: str) -> tuple[SceneInfo, dict[str, Any]]:
    """Scene and arguments of a text such as `room?triangles=200000&lights=24`.

    Raises
    ------
    ValueError
        For an unknown scene or parameter (with the nearest known name) and for values that
        cannot be read as the parameter's type.
    """
    name, _, query = spec.partition("?")
    info = SCENES.get(name)
    if info is None:
        raise ValueError(f"unknown scene {name!r}{nearest(name, SCENES)}")
    hints = typing.get_type_hints(info.builder)
    arguments: dict[str, Any] = {}
    for item in filter(None, query.split("&")):
        key, equals, text = item.partition("=")
        if key not in info.parameters:
            raise ValueError(f"{name} has no parameter {key!r}{nearest(key, info.parameters)}")
        if key in arguments:
            raise ValueError(f"{key} must be given once, got it again in {spec!r}")
        if not equals:
            raise ValueError(f"{key} must have a value, as in {key}={info.parameters[key]}")
        arguments[key] = _value(key, text, hints[key])
    return info, arguments


def build(spec: str) -> Any:
    """Build a scene from text: a name, then optionally `?` and `name=value` joined by `&`."""
    info, arguments = parse(spec)
    return info.function(**arguments)


TRUE, FALSE = ("true", "1", "yes", "on"), ("false", "0", "no", "off")


def _value(name: str, text: str, hint: Any) -> Any:
    kind = kinds(hint)[0]
    if kind is bool:
        if text.lower() not in TRUE + FALSE:
            raise ValueError(f"{name} must be true or false, got {text!r}")
        return text.lower() in TRUE
    try:
        number = float(text.replace("_", ""))
        if kind is float:
            return number
        if number == int(number):
            return int(text.replace("_", "")) if "e" not in text.lower() else int(number)
    except (ValueError, OverflowError):
        pass
    what = "a number" if kind is float else "a whole number"
    raise ValueError(f"{name} must be {what}, got {text!r}")
