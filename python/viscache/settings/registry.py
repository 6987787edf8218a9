"""The settings by role and name, and what a method of visibility works with."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias, TypeVar

from viscache.settings.spelling import setting

Role: TypeAlias = Literal["integrator", "rays", "visibility"]
Class = TypeVar("Class", bound=type[Any])


@dataclass(frozen=True, kw_only=True)
class Works:
    """What a method of visibility works with, and what its answers are.

    `exact`: rays answer every query. `unbiased`: frames have the expectation of exact ones. `bdpt`:
    bidirectional path tracing. `product`: product samples of the environment. `parts`: frames in
    parts. `weighted`: its answers have weights, which an audit of single queries does not know.
    """

    exact: bool = False
    unbiased: bool = False
    bdpt: bool = True
    product: bool = False
    parts: bool = False
    audit: bool = True
    weighted: bool = False


#: What the command line and sweep files call the settings.
NAMES: dict[Role, dict[str, type[Any]]] = {"integrator": {}, "rays": {}, "visibility": {}}
_WORKS: dict[type[Any], Works] = {}


def registered(role: Role, name: str, **found: bool) -> Callable[[Class], Class]:
    """Decorate a dataclass of settings: its role, its name, and the attributes of `Works`."""

    def decorate(cls: Class) -> Class:
        NAMES[role][name] = cls
        _WORKS[cls] = Works(**found)
        return setting(cls)

    return decorate


def works(visibility: Any) -> Works:
    """What a visibility setting works with; an oracle of the caller's own has the defaults."""
    return _WORKS.get(type(visibility), Works())


def is_setting(role: Role, given: Any) -> bool:
    """Whether an object is of a registered class."""
    return isinstance(given, tuple(NAMES[role].values()))


def _fitting(role: Role, found: dict[str, bool]) -> list[str]:
    """The classes of a role with these attributes, exact ones first."""
    fit = [c for c in NAMES[role].values() if found.items() <= vars(_WORKS[c]).items()]
    return [c.__name__ for c in sorted(fit, key=lambda c: not _WORKS[c].exact)]


def classes(role: Role, **found: bool) -> str:
    """The classes of a role with these attributes, in words: `vc.Exact(...) or vc.Aqvc(...)`."""
    *names, last = (f"vc.{name}(...)" for name in _fitting(role, found))
    return f"{', '.join(names)} or {last}" if names else last


def listed(role: Role, **found: bool) -> str:
    """The same in a table of the docs: `Exact`, `Aqvc`."""
    return ", ".join(f"`{name}`" for name in _fitting(role, found))
