"""A digest of the code of a class, so that a sweep does not reuse frames of changed code.

It is a digest of the bytecode, not of the source. Notebooks and consoles have no source file, a
file may have changed since its import, and comments and layout do not matter. The same code has the
same digest in every process of one version of Python.
"""

from __future__ import annotations

import dis
import functools
import types
import warnings
from collections.abc import Iterator
from typing import Any

import numpy as np

from viscache.base.array_digests import array_in_words, bytes_digest

#: Methods that `dataclasses` writes: the fields decide them.
GENERATED = {
    "__init__",
    "__repr__",
    "__eq__",
    "__hash__",
    "__lt__",
    "__le__",
    "__gt__",
    "__ge__",
    "__setattr__",
    "__delattr__",
    "__getstate__",
    "__setstate__",
    "__replace__",
}
#: Base classes of these modules change with the version of Python or of viscache alone.
KNOWN_MODULES = ("builtins", "typing", "abc", "viscache")


def code_digest(code: type[Any] | types.FunctionType, *, warns: bool = True) -> str:
    """Hex digest of a function, or of a class: its methods, constants and bases.

    Functions and classes of the same module that methods use belong to it, and so do numbers, texts
    and arrays that they read from that module. Functions of other modules do not. A compiled method
    has no bytecode: its changes remain unseen, which a warning says, unless the name of the class
    is enough.
    """
    reader = _Reader(code.__module__)
    text = "\n".join(reader.lines(code))
    if reader.unreadable and warns:
        warnings.warn(
            f"the code of {', '.join(reader.unreadable)} cannot be read: a sweep does not notice"
            " when it changes, so use another directory then",
            stacklevel=2,
        )
    return bytes_digest(text.encode())


class _Reader:
    """Walks through code; everything is read once."""

    def __init__(self, module: str) -> None:
        self.module = module
        self.unreadable: list[str] = []
        self._seen: set[int] = set()

    def lines(self, value: Any) -> Iterator[str]:
        """Text that says what a value does."""
        inner = _function_of(value)
        own = getattr(inner, "__module__", "") == self.module
        if isinstance(inner, type):
            if own:
                yield from self._class(inner)
        elif isinstance(inner, types.FunctionType):
            if own:
                yield from self._function(inner)
        elif isinstance(value, property):
            for part in (value.fget, value.fset):
                yield from self.lines(part)
        else:
            yield _plain(value)

    def _class(self, cls: type[Any]) -> Iterator[str]:
        if id(cls) in self._seen:
            return
        self._seen.add(id(cls))
        for base in reversed(cls.__mro__):
            if base.__module__.partition(".")[0] in KNOWN_MODULES:
                continue
            yield f"class {base.__qualname__}"
            for name, value in sorted(vars(base).items()):
                if _is_of_python(base, name, value):
                    continue
                yield name
                inner = _function_of(value)
                if isinstance(inner, types.FunctionType):  # of other modules too
                    yield from self._function(inner)
                else:
                    yield from self.lines(value)
                if callable(value) and not isinstance(inner, type | types.FunctionType):
                    self.unreadable.append(f"{base.__qualname__}.{name}")

    def _function(self, function: types.FunctionType) -> Iterator[str]:
        if id(function) in self._seen:
            return
        self._seen.add(id(function))
        yield from self._code(function.__code__)
        for default in (function.__defaults__, function.__kwdefaults__):
            yield _plain(default)
        for cell in function.__closure__ or ():
            yield from self.lines(_content(cell))
        for name in sorted(_globals_read(function.__code__)):
            yield name
            yield from self.lines(function.__globals__.get(name))

    def _code(self, code: types.CodeType) -> Iterator[str]:
        yield code.co_code.hex()
        yield getattr(code, "co_exceptiontable", b"").hex()
        yield repr((code.co_names, code.co_varnames, code.co_freevars, code.co_flags))
        for constant in code.co_consts:
            if isinstance(constant, types.CodeType):
                yield from self._code(constant)
            else:
                yield _plain(constant)


def _function_of(value: Any) -> Any:
    """The Python function or class behind a decorated one."""
    if isinstance(value, staticmethod | classmethod):
        value = value.__func__
    if isinstance(value, functools.cached_property):
        value = value.func
    if isinstance(value, type | types.FunctionType):
        return value
    return getattr(value, "__wrapped__", getattr(value, "py_func", value))


def _is_of_python(cls: type[Any], name: str, value: Any) -> bool:
    """Whether Python or `dataclasses` put an attribute there, which is not code of the class."""
    if "__dataclass_fields__" in vars(cls) and name in GENERATED:
        return name != "__init__" or value.__code__.co_filename == "<string>"
    special = name.startswith("__") and name.endswith("__")
    return special and not isinstance(_function_of(value), types.FunctionType)


def _content(cell: types.CellType) -> Any:
    try:
        return cell.cell_contents
    except ValueError:  # not assigned yet
        return None


def _globals_read(code: types.CodeType) -> set[str]:
    names = {
        str(i.argval)
        for i in dis.get_instructions(code)
        if i.opname in ("LOAD_GLOBAL", "LOAD_NAME")
    }
    inner = [_globals_read(c) for c in code.co_consts if isinstance(c, types.CodeType)]
    return names.union(*inner)


def _plain(value: Any) -> str:
    """A text that is the same in every process; empty for what has none."""
    if isinstance(value, set | frozenset):
        return "{" + ",".join(sorted(_plain(v) for v in value)) + "}"
    if isinstance(value, tuple | list):
        return "(" + ",".join(_plain(v) for v in value) + ")"
    if isinstance(value, dict):
        return "{" + ",".join(f"{_plain(k)}:{_plain(v)}" for k, v in value.items()) + "}"
    if isinstance(value, np.ndarray):
        # Bytes of objects are their places in memory
        return _plain(value.tolist()) if value.dtype.hasobject else array_in_words(value)
    simple = value is None or value is ... or isinstance(value, int | float | complex | str | bytes)
    return f"{type(value).__name__} {value!r}" if simple else ""
