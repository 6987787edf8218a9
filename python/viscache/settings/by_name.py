"""Settings by name: "whitted", "aqvc", `c_e=8` → the dataclasses that `viscache.render` takes."""

from __future__ import annotations

import ast
import dataclasses
import json
import math
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from viscache.base.array_digests import array_in_words
from viscache.settings import integrators as _integrators  # noqa: F401  (these three register)
from viscache.settings import rays as _rays  # noqa: F401
from viscache.settings import visibility as _visibility  # noqa: F401
from viscache.settings.not_given import NotGiven
from viscache.settings.registry import NAMES as NAMES
from viscache.settings.registry import Role as Role
from viscache.settings.spelling import GONE, by_symbol, nearest, unknown

ROLES: tuple[Role, ...] = ("integrator", "rays", "visibility")
#: `--visibility vlf` is short for `--rays vlf --visibility exact`.
RAYS_AS_VISIBILITY = ("vlf", "bsp")


def settings_class(role: Role, name: str) -> type[Any]:
    """The dataclass of a name; ValueError for an unknown one has the nearest known one."""
    if name not in NAMES[role]:
        raise ValueError(f"unknown {role} {name!r}{nearest(name, NAMES[role])}")
    return NAMES[role][name]


def name_of(role: Role, settings: Any) -> str:
    """The short name of a settings object: `Whitted(...)` → "whitted"."""
    cls = type(settings)
    return next((n for n, known in NAMES[role].items() if known is cls), cls.__name__.lower())


def make(role: Role, spec: str | Mapping[str, Any]) -> Any:
    """Settings from a name, `whitted?n_vpls=1024`, or a table `{name = "whitted", n_vpls = 1024}`.

    A `preset` in the table is a parameter like the others.
    """
    table = _table(role, spec) if isinstance(spec, str) else dict(spec)
    name = table.pop("name", None)
    if not isinstance(name, str):
        raise ValueError(f"{role} must be a name or a table with a name, got {spec!r}")
    cls = settings_class(role, name)
    return replaced(cls(), table, role)


def _table(role: Role, spec: str) -> dict[str, Any]:
    """`aqvc?c_e=8&c_n=4` as a table, as scenes are written."""
    name, mark, rest = spec.partition("?")
    table: dict[str, Any] = {"name": name}
    for pair in rest.split("&") if mark else ():
        parameter, equals, text = pair.partition("=")
        if not equals or not parameter or parameter in table:
            raise ValueError(
                f"{role} must be a name, then ?parameter=value&..., each once, got {spec!r}"
            )
        table[parameter] = literal(text)
    return table


def setting(role: Role, value: Any, default: str | None = None) -> Any:
    """Settings from an argument: a name, a table, an object, or None for the default."""
    value = default if value is None else value
    if isinstance(value, type):
        raise ValueError(f"{role} must be an object of a class, got the class {value.__name__}")
    return make(role, value) if isinstance(value, (str, Mapping)) else value


def parameters(settings: Any) -> dict[str, Any]:
    """Names and values of a settings object, those of settings within it under their own names."""
    found: dict[str, Any] = {}
    for f in dataclasses.fields(settings):
        value = getattr(settings, f.name)
        found |= parameters(value) if dataclasses.is_dataclass(value) else {f.name: value}
    return found


def nested(settings: Any) -> dict[str, Any]:
    """The settings within a settings object by their field's name: `paper` of `Aqvc`."""
    values = {f.name: getattr(settings, f.name) for f in dataclasses.fields(settings)}
    return {name: value for name, value in values.items() if dataclasses.is_dataclass(value)}


def replaced(settings: Any, values: Mapping[str, Any], what: str) -> Any:
    """The settings with some values replaced. An unknown name is an error with the nearest one.

    Parameters of inner settings have three spellings: `hash`, `paper.hash`, or a table
    `paper={"hash": "scheme1"}`.
    """
    within, own = nested(settings), {f.name for f in dataclasses.fields(settings)}
    kept: dict[str, Any] = {}
    inner: dict[str, dict[str, Any]] = {name: {} for name in within}
    for name, value in by_symbol(values).items():
        part, dot, rest = name.partition(".")
        if part in within and (dot or isinstance(value, Mapping)):
            inner[part] |= {rest: value} if dot else value
        elif name in own:
            kept[name] = tuple(value) if isinstance(value, list) else value
        else:
            check_parameter(settings, name, what)
            inner[next(n for n in within if name in parameters(within[n]))][name] = value
    for name, given in inner.items():
        if given:
            kept[name] = replaced(kept.get(name, within[name]), given, what)
    return dataclasses.replace(settings, **kept) if kept else settings


def described(role: Role, settings: Any) -> dict[str, Any]:
    """`{"name": ..., parameter: value, ...}`, JSON-able: the inverse of `make`.

    What a preset decides is left out.
    """
    given = {n: v for n, v in parameters(settings).items() if not isinstance(v, NotGiven)}
    return {"name": name_of(role, settings), **plain(given)}


def plain(values: Mapping[str, Any]) -> dict[str, Any]:
    """The values after a round trip through JSON. Arrays become a digest, other objects text."""
    kept = {n: dict(v) if isinstance(v, Mapping) else v for n, v in values.items()}
    return dict(json.loads(json.dumps(kept, default=_text)))


def _text(value: Any) -> Any:
    """Numbers of NumPy as numbers, arrays by their content, anything else as `str` has it."""
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, np.ndarray):
        return array_in_words(value)
    return str(value)


def literal(text: str) -> Any:
    """The value of `--set name=text`: a Python literal, true/false/none, else the text itself."""
    words = {"true": True, "false": False, "none": None, "inf": math.inf, "nan": math.nan}
    if text.lower() in words:
        return words[text.lower()]
    try:
        return ast.literal_eval(text)
    except (ValueError, SyntaxError):
        return text


def assign(
    settings: Mapping[Role, Any], assignments: Iterable[str], *, bare: tuple[Role, ...] = ROLES
) -> dict[Role, Any]:
    """Apply `name=value` assignments of the command line.

    A prefix names the role: `visibility.c_e=8`, `integrator.n_vpls=64`, `rays.n_tiles=32`. A name
    without prefix must belong to exactly one of the roles in `bare`.
    """
    result = dict(settings)
    for assignment in assignments:
        name, equals, text = assignment.partition("=")
        if not equals or not name:
            raise ValueError(f"--set must be name=value, got {assignment!r}")
        role, parameter = owner(name.strip(), result, bare)
        result[role] = replaced(result[role], {parameter: literal(text.strip())}, role)
    return result


def owner(
    name: str, settings: Mapping[Role, Any], bare: tuple[Role, ...] = ROLES
) -> tuple[Role, str]:
    """Whose parameter a bare or dotted name is: (role, parameter)."""
    (name,) = by_symbol({name: None})
    prefix, dot, parameter = name.partition(".")
    if dot and prefix in ROLES:
        return prefix, _bare(settings[prefix], parameter, prefix)
    if dot:
        for role in bare:
            if prefix in nested(settings[role]):
                return role, _bare(settings[role], name, role)
        raise ValueError(f"{name!r} must start with one of {', '.join(ROLES)}")
    owners = [role for role in bare if name in parameters(settings[role])]
    if len(owners) == 1:
        return owners[0], name
    if owners:
        raise ValueError(
            f"{name!r} is ambiguous: write {' or '.join(f'{r}.{name}' for r in owners)}"
        )
    for role in bare:
        if f"{_whose(settings[role], name)}.{name}" in GONE:
            check_parameter(settings[role], name, role)
    known = [parameter for role in bare for parameter in parameters(settings[role])]
    whose = " or ".join(f"{role} {type(settings[role]).__name__}" for role in bare)
    raise ValueError(f"unknown parameter {name!r} of {whose}{nearest(name, known)}")


def _bare(settings: Any, name: str, role: str) -> str:
    """`paper.hash` → `hash`, where `settings` has that."""
    part, dot, rest = name.partition(".")
    within = nested(settings)
    inside = bool(dot) and part in within
    check_parameter(within[part] if inside else settings, rest if inside else name, role)
    return rest if inside else name


def check_parameter(settings: Any, parameter: str, role: str) -> None:
    """ValueError with the nearest known name where `settings` has no such parameter."""
    known = parameters(settings)
    if parameter not in known:
        raise ValueError(f"{role} {unknown(_whose(settings, parameter), parameter, known)}")


def _whose(settings: Any, parameter: str) -> str:
    """The class that an unknown parameter belongs to: the one that had it before, if there is."""
    own = [type(s).__name__ for s in (settings, *nested(settings).values())]
    return next((name for name in own if f"{name}.{parameter}" in GONE), own[0])
