"""Parameters whose ranges, defaults and meanings stand in a table of the C++ core, one row each."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Mapping
from dataclasses import fields
from typing import Any

__all__ = ["ParameterRows"]


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
        lines = []
        for f in fields(cls):
            if f.name in self.by_name:
                row, default = self.by_name[f.name], self.default(f.name)
                shown = "{}" if isinstance(default, Mapping) else repr(default).replace("'", '"')
                lines.append(f"{f.name} : {row['kind']}, default {shown}")
                lines.append(
                    textwrap.fill(row["doc"], 88, initial_indent=4 * " ", subsequent_indent=4 * " ")
                )

        def indented(place: re.Match[str]) -> str:  # since Python 3.13 docstrings have no indent
            return textwrap.indent("\n".join(lines), place[1])

        if cls.__doc__:
            cls.__doc__ = re.sub(r"^( *)\{parameters\}$", indented, cls.__doc__, flags=re.M)
        return cls

    def core(self, *settings: Any) -> Any:
        """The C++ struct with the values of these settings.

        Raises
        ------
        ValueError
            A value is out of range.
        """
        made = self.struct()
        for part in settings:
            for f in fields(part):
                if f.name in self.by_name:
                    setattr(made, f.name, getattr(part, f.name))
        made.validate()
        return made
