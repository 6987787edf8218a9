"""Shared by the tests of bands."""

from __future__ import annotations

from types import ModuleType

from viscache_lab.experiment import Band


def all_bands(bands: ModuleType) -> dict[str, Band]:
    """Every band of a module by its name; those of a table by name and key."""
    found = {}
    for name, value in vars(bands).items():
        if isinstance(value, Band):
            found[name] = value
        elif name.isupper() and isinstance(value, dict):
            found |= {f"{name}[{key}]": band for key, band in value.items()}
    return found
