"""What the docstring of a settings class says about each of its parameters."""

from __future__ import annotations

import dataclasses
import inspect
import re
from dataclasses import dataclass
from typing import Any

from viscache.settings import by_name
from viscache.settings.maps import MapSettings

SECTION = re.compile(r"^Parameters\n-+\n(.*?)(?=^\w[^\n]*\n-{3,}$|\Z)", re.M | re.S)
#: Names, what follows the colon if there is one, and the indented lines below.
ENTRY = re.compile(r"^([\w, .]+?)(?: : ([^\n]*))?\n((?:(?: {4}[^\n]*)?\n)+)", re.M)
#: Another class that has the text.
ELSEWHERE = re.compile(r"(?:As in|see) `(\w+)`")
KNOWN: list[type[Any]] = [c for known in by_name.NAMES.values() for c in known.values()]
CLASSES = {cls.__name__: cls for cls in [*KNOWN, MapSettings]}


@dataclass(frozen=True, slots=True)
class ParameterDoc:
    """One parameter of a settings class."""

    name: str
    """As `--set` and sweeps take it."""
    kind: str
    """Type, range and default, in the words of the docstring."""
    text: str
    default: Any


def parameter_docs(cls: type[Any]) -> list[ParameterDoc]:
    """Parameters of a settings class in the order of its fields, then those of inner settings."""
    made = cls()
    within, told = by_name.nested(made), _told(cls)
    found = []
    for f in dataclasses.fields(made):
        if f.name not in within:
            default = by_name.plain({f.name: getattr(made, f.name)})[f.name]
            found.append(ParameterDoc(f.name, *told.get(f.name, ("", "")), default))
    for inner in within.values():
        found += parameter_docs(type(inner))
    return found


def _told(cls: type[Any]) -> dict[str, tuple[str, str]]:
    """Kinds and texts by name, those of other classes where the docstring refers to them."""
    section = SECTION.search(inspect.getdoc(cls) or "")
    own: dict[str, tuple[str, str]] = {}
    referred: dict[str, tuple[str, str]] = {}
    for names, kind, text in ENTRY.findall(section[1] + "\n" if section else ""):
        elsewhere = ELSEWHERE.search(text)
        if not kind and elsewhere:
            referred |= _told(CLASSES[elsewhere[1]])
        else:
            own |= {name.strip(): (kind, " ".join(text.split())) for name in names.split(",")}
    return referred | own
