"""Identifies the code that made a figure."""

from __future__ import annotations

import hashlib
from functools import cache
from pathlib import Path

from viscache import _core

__all__ = ["code_hash"]


@cache
def code_hash() -> str:
    """Hash of the code that determines a figure: the package's sources and its core."""
    package = Path(__file__).parents[1]
    files = [Path(_core.__file__), *sorted(package.rglob("*.py"))]
    digest = hashlib.sha256()
    for file in files:
        digest.update(file.name.encode() + hashlib.sha256(file.read_bytes()).digest())
    return digest.hexdigest()
