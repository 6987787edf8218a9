"""Values in words: the same in every process and folder, another text for another value."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Mapping
from pathlib import Path
from types import FunctionType
from typing import Any

import numpy as np

from viscache import _core
from viscache.base.array_digests import array_in_words, bytes_digest
from viscache.oracles.code_digest import code_digest
from viscache.scene import Sky
from viscache.scene.cameras import camera_in_words
from viscache.scene.environments import environment_pixels, existing_file
from viscache.vismap.cache import VisibilityMapCache
from viscache.vismap.pass_maps import records_digest


def environment_in_words(env: Any) -> Any:
    """An environment by its content: the file's bytes, the pixels, or the numbers.

    SceneError if there is no such file, ValueError if it is no environment.
    """
    if env is None or isinstance(env, Sky):
        return by_value(env, "env")
    if isinstance(env, str | os.PathLike):
        return f"file sha256 {bytes_digest(existing_file(env).read_bytes())}"
    pixels = environment_pixels(env)
    return array_in_words(pixels) if pixels.ndim == 3 else np.resize(pixels, 3).tolist()


def by_value(value: Any, what: str, within: tuple[int, ...] = ()) -> Any:
    """A value in words, JSON-able and the same in every process.

    ValueError if an object says nothing of its value, or contains itself.
    """
    if isinstance(value, np.generic):
        value = value.item()
    elif isinstance(value, np.ndarray) and value.dtype.hasobject:
        value = value.tolist()
    if value is None or isinstance(value, bool | int | float | str):
        return value
    try:
        words = _known(value)
    except Exception as error:
        raise ValueError(_unknown(value, what)) from error
    if words is not None:
        return words
    if id(value) in within:
        raise ValueError(_unknown(value, what))
    within = (*within, id(value))
    if isinstance(value, Mapping):
        named = {n if isinstance(n, str) else repr(by_value(n, what, within)): n for n in value}
        return {n: by_value(value[key], f"{what}.{n}", within) for n, key in named.items()}
    if isinstance(value, list | tuple):
        return [by_value(v, what, within) for v in value]
    if isinstance(value, set | frozenset):
        return sorted((by_value(v, what, within) for v in value), key=repr)
    if dataclasses.is_dataclass(value) and type(value).__module__.startswith("viscache."):
        fields = {f.name: getattr(value, f.name) for f in dataclasses.fields(value)}
        return {"name": type(value).__name__, **by_value(fields, what, within)}
    return by_value(_copied(value, what), what, within)


def _copied(value: Any, what: str) -> Any:
    """How an object would be copied: its class and its state."""
    try:
        made = value.__reduce_ex__(4)
    except Exception as error:
        raise ValueError(_unknown(value, what)) from error
    if isinstance(made, str):
        return made
    return [list(part) if hasattr(part, "__next__") else part for part in made]


def _known(value: Any) -> Any:
    """Objects whose content has a short name, else None."""
    if isinstance(value, type | FunctionType):
        return f"{value.__qualname__} {code_digest(value, warns=False)}"
    if isinstance(value, VisibilityMapCache):
        return f"maps sha256 {records_digest(value)}"
    if isinstance(value, _core.Camera):
        return camera_in_words(value)
    if isinstance(value, bytes | bytearray):
        return f"bytes sha256 {bytes_digest(value)}"
    if isinstance(value, Path):
        return str(value)
    own = getattr(value, "content_hash", None)
    if isinstance(own, str):
        return f"{type(value).__name__} {own}"
    if hasattr(value, "__array__"):
        array = np.asarray(value)
        return None if array.dtype.hasobject else array_in_words(array)
    return None


def object_in_words(chosen: Any, role: str) -> dict[str, Any]:
    """A setting that is not viscache's: its code and what its attributes say."""
    cls = type(chosen)
    named = {"name": cls.__qualname__, "code": code_digest(cls)}
    if isinstance(getattr(chosen, "content_hash", None), str):
        return named | {"content_hash": chosen.content_hash}
    fields = dataclasses.fields(chosen) if dataclasses.is_dataclass(chosen) else ()
    values = {f.name: getattr(chosen, f.name) for f in fields} | getattr(chosen, "__dict__", {})
    if not values:  # its slots
        values = {"state": _copied(chosen, role)[2:]}
    return {**named, **by_value(values, role)}


def _unknown(value: Any, what: str) -> str:
    return (
        f"{what} must be known by its value, as pictures are told apart by it, got"
        f" {type(value).__module__}.{type(value).__qualname__}; an attribute content_hash (text)"
        " of it, or of its oracle, can say what it is"
    )
