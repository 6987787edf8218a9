"""What viscache writes and reads back: kind, version, fields, arrays and hash, all demanded.

Each format is one `Format`. What is written gets a head with the kind, the version, the fields and
a hash of all that and of the arrays. A reader gives what it found to `Format.opened`, which checks
everything before anything is used. Fields and arrays have declared types, because who changes a
file can make its hash fit, too.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from viscache.base.array_digests import arrays_digest
from viscache.base.files import DAMAGED_ARRAYS, whole_file

Arrays = Mapping[str, npt.NDArray[Any]]

#: Name of the head among the arrays of a file.
HEAD = "head"


class FormatError(ValueError):
    """Something that is read back is not what viscache wrote, or of another version."""


@dataclass(frozen=True, slots=True)
class Field:
    """What a field of a head must be."""

    what: str
    fits: Callable[[Any], bool]


@dataclass(frozen=True, slots=True)
class ArrayField:
    """Type and shape of an array; a length with a name is the same in all arrays of a file.

    None: any type, shape or length.
    """

    dtype: str | None
    shape: tuple[int | str | None, ...] | None

    def __str__(self) -> str:
        shape = (
            ""
            if self.shape is None
            else f" of shape ({', '.join('any' if n is None else str(n) for n in self.shape)})"
        )
        return f"{'numbers' if self.dtype is None else np.dtype(self.dtype)}{shape}"


def is_count(value: Any) -> bool:
    """Whether a value is a whole number in [0, 2^63)."""
    return isinstance(value, int) and not isinstance(value, bool) and 0 <= value < 1 << 63


def is_number(value: Any) -> bool:
    """Whether a value is a finite number."""
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def is_digest(value: Any) -> bool:
    """Whether a value is a SHA-256 in hexadecimal digits."""
    return isinstance(value, str) and re.fullmatch("[0-9a-f]{64}", value) is not None


def list_of(fits: Callable[[Any], bool]) -> Callable[[Any], bool]:
    """Whether a value is a list of such things."""
    return lambda value: isinstance(value, list) and all(map(fits, value))


def table_of(fits: Callable[[Any], bool]) -> Callable[[Any], bool]:
    """Whether a value is a table of such things."""
    return lambda value: isinstance(value, dict) and all(map(fits, value.values()))


def is_text(value: Any) -> bool:
    """Whether a value is a text."""
    return isinstance(value, str)


COUNT = Field("a whole number in [0, 2^63)", is_count)
NUMBER = Field("a finite number", is_number)
FLAG = Field("true or false", lambda value: isinstance(value, bool))
TEXT = Field("a text", is_text)
TEXTS = Field("a list of texts", list_of(is_text))
TABLE = Field("a table", lambda value: isinstance(value, dict))
NUMBERS = Field("a table of numbers", table_of(is_number))
DIGEST = Field("a SHA-256 of 64 hexadecimal digits", is_digest)
DIGESTS = Field("a table of SHA-256", table_of(is_digest))


@dataclass(frozen=True, kw_only=True, slots=True)
class Format:
    """One format: its kind, with an article, as in messages; its version; its fields and arrays.

    An array whose name ends in "?" may be missing; one in "*" stands for any number of names.
    """

    kind: str
    version: int
    fields: Mapping[str, Field] = field(default_factory=dict)
    arrays: Mapping[str, ArrayField] = field(default_factory=dict)

    def sealed(self, fields: Mapping[str, Any], arrays: Arrays | None = None) -> str:
        """The head of what is written, as JSON."""
        plain = json.loads(json.dumps(fields))  # as it will be read
        head = {"kind": self.kind, "version": self.version, "fields": plain}
        return json.dumps(head | {"sha256": _digest(head, arrays or {})})

    def opened(self, where: str | Path, head: Any, arrays: Arrays | None = None) -> dict[str, Any]:
        """The fields of a head that `sealed` gave; `where` is its name in messages.

        FormatError if it is of another kind or version, has no hash or one that does not fit, or a
        field or an array is not what it must be.
        """
        arrays = {} if arrays is None else arrays
        found = self._head(where, head)
        given = found.pop("sha256")
        if given != _digest(found, arrays):
            raise self.refusal(where, "it is damaged: its content does not fit its hash")
        fields: dict[str, Any] = found["fields"]
        self._check_fields(where, fields)
        self._check_arrays(where, arrays)
        return fields

    def refusal(self, where: str | Path, reason: object) -> FormatError:
        """The error of something that is not of this format."""
        return FormatError(f"{where} must be {self.kind}: {reason}")

    def _head(self, where: str | Path, head: Any) -> dict[str, Any]:
        """Kind, version, fields and hash; all are there."""
        if head is None:
            raise self.refusal(where, "it has no head, as files of other programs")
        try:
            found = json.loads(head)
        except (ValueError, TypeError, RecursionError) as error:
            raise self.refusal(where, f"its head cannot be read: {error}") from error
        if not isinstance(found, dict) or not isinstance(found.get("kind"), str):
            raise self.refusal(where, f"its head has no kind, got {str(found)[:60]}")
        for name, wanted in (("kind", self.kind), ("version", self.version)):
            given = found.get(name)
            if given != wanted or isinstance(given, bool):
                raise self.refusal(where, f"its {name} must be {wanted!r}, got {given!r}")
        if not is_digest(found.get("sha256")) or not isinstance(found.get("fields"), dict):
            raise self.refusal(where, "its head must have fields and their hash")
        return {name: found[name] for name in ("kind", "version", "fields", "sha256")}

    def _check_fields(self, where: str | Path, fields: Mapping[str, Any]) -> None:
        if fields.keys() != self.fields.keys():
            names = sorted(self.fields)
            raise self.refusal(where, f"its fields must be {names}, got {sorted(fields)}")
        for name, wanted in self.fields.items():
            if not wanted.fits(fields[name]):
                given = repr(fields[name])[:200]
                raise self.refusal(where, f"{name} must be {wanted.what}, got {given}")

    def _check_arrays(self, where: str | Path, arrays: Arrays) -> None:
        lengths: dict[str, int] = {}
        missing = {name for name in self.arrays if name[-1] not in "?*"} - arrays.keys()
        if missing:
            raise self.refusal(where, f"it must have the arrays {sorted(missing)}")
        for name in sorted(arrays):
            wanted = self._array(name)
            if wanted is None:
                raise self.refusal(where, f"it must not have the array {name!r}")
            shape, dtype = arrays[name].shape, arrays[name].dtype
            ends = shape if wanted.shape is None else wanted.shape
            fits = len(ends) == len(shape) and all(
                end is None
                or length == (end if isinstance(end, int) else lengths.setdefault(end, length))
                for end, length in zip(ends, shape, strict=True)
            )
            numbers = dtype.kind in "biuf" if wanted.dtype is None else dtype == wanted.dtype
            if not (fits and numbers):
                reason = f"{name} must be {wanted}, got {dtype} of shape {shape}"
                raise self.refusal(where, f"{reason} beside {lengths}" if lengths else reason)

    def _array(self, name: str) -> ArrayField | None:
        for known, array in self.arrays.items():
            end = known[-1]
            start = known.rstrip("?*")
            if name == start or (end == "*" and name.startswith(start)):
                return array
        return None

    def write_npz(
        self, path: Path, fields: Mapping[str, Any], arrays: Arrays, *, compressed: bool = False
    ) -> None:
        """Write a file, complete or absent; OSError if it cannot be written."""
        head = np.frombuffer(self.sealed(fields, arrays).encode(), np.uint8)
        save: Any = np.savez_compressed if compressed else np.savez
        with whole_file(path) as partial, partial.open("wb") as file:
            save(file, **{HEAD: head}, **arrays)

    def read_npz(self, path: Path) -> tuple[dict[str, Any], dict[str, npt.NDArray[Any]]]:
        """Fields and arrays of a file.

        FormatError as `opened`, and if the file is damaged; OSError if it cannot be read.
        """
        if not path.exists():
            raise FileNotFoundError(f"no such file: {path}")
        with path.open("rb") as file:
            try:
                with np.load(file, allow_pickle=False) as archive:
                    arrays = {name: archive[name] for name in archive.files}
            except DAMAGED_ARRAYS as error:
                raise self.refusal(path, error) from error
        head = arrays.pop(HEAD, None)
        text = None if head is None else head.tobytes()
        return self.opened(path, text, arrays), arrays


def _digest(head: Mapping[str, Any], arrays: Arrays) -> str:
    """Hash of kind, version, fields and arrays."""
    return arrays_digest(json.dumps(head, sort_keys=True).encode(), arrays)
