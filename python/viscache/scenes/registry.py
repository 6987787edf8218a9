"""The list of built-in scenes, and building one from text such as `room?triangles=200000`."""

from __future__ import annotations

import functools
import inspect
import math
import types
import typing
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, ParamSpec

from viscache.scene import Scene
from viscache.scenes.builder import Builder
from viscache.settings.spelling import nearest

P = ParamSpec("P")


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


#: Name to scene, in the order `viscache scenes` lists them.
SCENES: dict[str, SceneInfo] = {}


def scene(
    shown: Mapping[str, Any] | None = None,
) -> Callable[[Callable[P, Builder]], Callable[P, Any]]:
    """Register a function that returns a `Builder` as a built-in scene.

    `shown` overrides defaults in `SceneInfo.parameters` where the signature says None.
    """

    def register(function: Callable[P, Builder]) -> Callable[P, Any]:
        @functools.wraps(function)
        def make(*args: P.args, **kwargs: P.kwargs) -> Any:
            given = signature.bind(*args, **kwargs).arguments
            query = "&".join(f"{k}={v}" for k, v in given.items() if v is not None)
            spec = f"{name}?{query}" if query else name
            return Scene.from_description(function(*args, **kwargs).description, spec=spec)

        name = function.__name__
        signature = inspect.signature(function)
        defaults = {p.name: p.default for p in signature.parameters.values()}
        SCENES[name] = SceneInfo(
            name=name,
            function=make,
            builder=function,
            description=(inspect.getdoc(function) or "").split("\n")[0].rstrip("."),
            parameters=types.MappingProxyType(defaults | dict(shown or {})),
        )
        return make

    return register


def at_least(name: str, value: float, low: float) -> None:
    """Refuse a parameter below `low` or not finite."""
    if not (math.isfinite(value) and value >= low):
        raise ValueError(f"{name} must be >= {low}, got {value}")


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
    kinds = [k for k in typing.get_args(hint) or (hint,) if k is not type(None)]
    kind = kinds[0]
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
