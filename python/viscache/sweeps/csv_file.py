"""Tables as CSV, whose text is text in spreadsheets, too.

A cell that begins with one of "=+-@" is a formula to a spreadsheet, and may start programs there.
So text that begins with one, with white space or with an apostrophe gets an apostrophe in front;
`str.removeprefix("'")` gives every text back. Numbers are written as they are.
"""

from __future__ import annotations

import csv
import io
import numbers
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from viscache.base.files import whole_file

#: What begins a formula, also in full width; what a program may leave out before one; and the mark.
MARKED = ("=", "+", "-", "@", "\uff1d", "\uff0b", "\uff0d", "\uff20", "\t", "\r", "\n", " ", "'")


def write_csv(path: Path, rows: Sequence[Mapping[str, Any]], columns: Sequence[str]) -> None:
    """Write a table as a whole. Undefined values are empty cells."""
    lines = [_line({column: column for column in columns}, columns)]
    lines += [_line(row, columns) for row in rows]
    with whole_file(path) as partial:
        partial.write_bytes("".join(lines).encode())


def append_csv(path: Path, row: Mapping[str, Any], columns: Sequence[str]) -> None:
    """Add a row in one write."""
    with path.open("a", newline="", encoding="utf-8") as file:
        file.write(_line(row, columns))


def _line(row: Mapping[str, Any], columns: Sequence[str]) -> str:
    text = io.StringIO(newline="")
    csv.writer(text).writerow([_cell(row.get(column)) for column in columns])
    return text.getvalue()


def _cell(value: Any) -> Any:
    """The value of a cell: text never begins a formula."""
    if value is None or isinstance(value, numbers.Real):
        return value
    text = str(value)
    return f"'{text}" if text.startswith(MARKED) else text
