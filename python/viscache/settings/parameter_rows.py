"""Parameters whose ranges, defaults and meanings stand in a table of the C++ core, one row each."""

from __future__ import annotations

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
                lines.append(f"    {f.name} : {row['kind']}, default {shown}")
                lines.append(
                    textwrap.fill(row["doc"], 92, initial_indent=8 * " ", subsequent_indent=8 * " ")
                )
        if cls.__doc__:
            cls.__doc__ = cls.__doc__.replace("    {parameters}", "\n".join(lines))
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
