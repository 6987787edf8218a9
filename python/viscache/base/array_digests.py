"""SHA-256 of content, by which files, stores and pictures tell what is the same."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt


def bytes_digest(data: bytes | bytearray) -> str:
    """Hex digest of bytes."""
    return hashlib.sha256(data).hexdigest()


def content_key(parts: Mapping[str, Any]) -> str:
    """Hex digest of a JSON-able description, whatever the order of its names."""
    text = json.dumps(parts, sort_keys=True, separators=(",", ":"), allow_nan=True)
    return bytes_digest(text.encode())


def array_in_words(array: npt.NDArray[Any]) -> str:
    """Type, shape and digest of an array of numbers."""
    content = bytes_digest(np.ascontiguousarray(array).tobytes())
    return f"array {array.dtype} {array.shape} sha256 {content}"


def pixels_digest(pixels: npt.NDArray[np.float32]) -> str:
    """Hex digest of little-endian float32 pixels."""
    return hashlib.sha256(np.ascontiguousarray(pixels, dtype="<f4").tobytes()).hexdigest()


def layer_digests(layers: Mapping[str, npt.NDArray[np.float32]]) -> dict[str, str]:
    """The digest of each layer of a frame, by name."""
    return {name: pixels_digest(pixels) for name, pixels in layers.items()}


def changed_layers(found: Mapping[str, str], wanted: Mapping[str, str]) -> list[str]:
    """Names of layers whose digests differ, and of those that only one side has; sorted."""
    return sorted(n for n in {*found, *wanted} if found.get(n) != wanted.get(n))


def arrays_digest(start: bytes, arrays: Mapping[str, npt.NDArray[Any]], end: bytes = b"") -> str:
    """Hex digest of some bytes, of named arrays, their types and shapes, and of more bytes."""
    h = hashlib.sha256(start)
    for name in sorted(arrays):
        array = np.ascontiguousarray(arrays[name])
        h.update(f"{name} {array.dtype.str} {array.shape}".encode())
        h.update(array.tobytes())
    h.update(end)
    return h.hexdigest()
