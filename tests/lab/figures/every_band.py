"""Shared by the tests of bands."""

from types import SimpleNamespace

from viscache_lab.experiment import Band
from viscache_lab.figures.bands import aqvc, vismap, vlf


def all_bands(bands: SimpleNamespace) -> dict[str, Band]:
    """Every band by its name; those of a table by name and key."""
    found = {}
    for name, value in vars(bands).items():
        if isinstance(value, Band):
            found[name] = value
        else:
            found |= {f"{name}[{key}]": band for key, band in value.items()}
    return found


#: Bands of the papers' figures, by paper, name and key.
EVERY = {
    f"{paper}.{name}": band
    for paper, bands in (("aqvc", aqvc), ("vlf", vlf), ("vismap", vismap))
    for name, band in all_bands(bands).items()
}
