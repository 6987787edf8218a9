"""Parameters whose ranges, defaults and meanings stand in a table of the C++ core, one row each."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterable, Mapping
from dataclasses import fields
from typing import Any, ClassVar

from viscache.settings.checks import check_types


def fill(cls: type[Any], place: str, entries: Iterable[tuple[str, str]]) -> None:
    """Replace the line `{place}` of a docstring by entries: a line, and a text below it."""
    lines = []
    for line, text in entries:
        lines.append(line)
        lines.append(textwrap.fill(text, 88, initial_indent="    ", subsequent_indent="    "))

    def indented(found: re.Match[str]) -> str:  # since Python 3.13 docstrings have no indent
        return textwrap.indent("\n".join(lines), found[1])

    if cls.__doc__:
        cls.__doc__ = re.sub(rf"^( *)\{{{place}\}}$", indented, cls.__doc__, flags=re.M)


class ParameterRows:
    """The rows of one C++ struct."""

    def __init__(self, struct: type[Any]) -> None:
        self.struct = struct
        self.by_name: dict[str, dict[str, Any]] = {
            row["name"]: row for row in struct.parameter_rows()
        }
        self._defaults = struct()

    def default(self, name: str) -> Any:
        """The C++ default."""
        return getattr(self._defaults, name)

    def documented(self, cls: type[Any]) -> type[Any]:
        """Decorate a dataclass: its parameters replace the line `{parameters}` of its docstring."""
        entries = []
        for f in fields(cls):
            if f.name in self.by_name:
                row, default = self.by_name[f.name], self.default(f.name)
                shown = "{}" if isinstance(default, Mapping) else repr(default).replace("'", '"')
                entries.append((f"{f.name} : {row['kind']}, default {shown}", row["doc"]))
        fill(cls, "parameters", entries)
        return cls

    def core(self, *settings: Any) -> Any:
        """The C++ struct with the values of these settings; ValueError if one is out of range."""
        given = {f.name: getattr(part, f.name) for part in settings for f in fields(part)}
        return self.struct(**{n: v for n, v in given.items() if n in self.by_name})


class RowSettings:
    """Base of dataclasses whose fields are rows: their values are checked when they are made."""

    __slots__ = ()
    ROWS: ClassVar[ParameterRows]

    def __post_init__(self) -> None:
        check_types(self)
        self.core()

    def core(self) -> Any:
        """The C++ struct."""
        return self.ROWS.core(self)

    def parameters(self) -> dict[str, Any]:
        """Names and values."""
        return {f.name: getattr(self, f.name) for f in fields(self)}  # type: ignore[arg-type]
