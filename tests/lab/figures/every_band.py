"""Shared by the tests of bands."""

from __future__ import annotations

from types import SimpleNamespace

from viscache_lab.experiment import Band


def all_bands(bands: SimpleNamespace) -> dict[str, Band]:
    """Every band by its name; those of a table by name and key."""
    found = {}
    for name, value in vars(bands).items():
        if isinstance(value, Band):
            found[name] = value
        else:
            found |= {f"{name}[{key}]": band for key, band in value.items()}
    return found
