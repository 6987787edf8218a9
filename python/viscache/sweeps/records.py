"""The records of a sweep's store: its description, its frames, their comparisons."""

from __future__ import annotations

from typing import Any

from viscache.base.formats import (
    COUNT,
    DIGEST,
    DIGESTS,
    NUMBERS,
    TABLE,
    TEXT,
    TEXTS,
    Field,
    Format,
    is_count,
    is_digest,
    is_text,
    list_of,
    table_of,
)

#: Of stores and their records: others are refused.
VERSION = 2


def _is_seed(value: Any) -> bool:
    return is_count(value) or (isinstance(value, int) and 0 <= value < 1 << 64)


def _is_number(value: Any) -> bool:
    return value is None or (isinstance(value, int | float) and not isinstance(value, bool))


def _counts(value: Any) -> bool:
    """Counters of a frame, with those that the table divides."""
    if not isinstance(value, dict):
        return False
    groups = value.get("groups", {})
    return table_of(lambda group: isinstance(group, dict))(groups) and all(
        _is_number(counts.get(name)) for counts in (value, *groups.values()) for name in COUNTED
    )


def _is_point(value: Any) -> bool:
    return (
        isinstance(value, dict)
        and value.keys() == POINT.keys()
        and all(fits(value[name]) for name, fits in POINT.items())
    )


def _is_coordinates(value: Any) -> bool:
    return table_of(lambda pair: isinstance(pair, list) and len(pair) == 2)(value) and all(
        is_text(dim) and isinstance(values, list) for dim, values in value.values()
    )


COUNTED = ("rays", "queries")
POINT: dict[str, Any] = {
    "index": list_of(is_count),
    "values": lambda value: isinstance(value, dict),
    "repeat": is_count,
    "seed": _is_seed,
    "key": is_digest,
    "paired": is_digest,
    "converged": lambda value: value is None or is_digest(value),
}
_TABLE_OR_NONE = Field("a table or null", lambda value: value is None or isinstance(value, dict))
_TABLE_OR_TEXT = Field("a table or a text", lambda value: isinstance(value, dict | str))

SWEEP = Format(
    kind="the description of a sweep",
    version=VERSION,
    fields={
        **dict.fromkeys(("scene", "scene_hash", "cpu"), TEXT),
        **dict.fromkeys(("integrator", "rays", "visibility"), _TABLE_OR_TEXT),
        **dict.fromkeys(("triangles", "spp", "seed"), COUNT),
        **dict.fromkeys(("names", "dims", "metrics"), TEXTS),
        "size": Field("two whole numbers", lambda v: list_of(is_count)(v) and len(v) == 2),
        "use": Field("a table, a text or null", lambda v: v is None or isinstance(v, dict | str)),
        "camera": Field("JSON", lambda value: True),
        "repeats": COUNT,
        "converged": _TABLE_OR_NONE,
        "coords": Field("a table of (dimension, values)", _is_coordinates),
        "points": Field("a list of points, whose keys are hashes", list_of(_is_point)),
        "provenance": TABLE,
    },
)
FRAME = Format(
    kind="a frame of a sweep",
    version=VERSION,
    fields={
        "key": DIGEST,
        **dict.fromkeys(("spec", "parameters", "provenance"), TABLE),
        "counters": Field("a table of counters", _counts),
        "timings": NUMBERS,
        "layers": DIGESTS,
    },
)
COMPARISON = Format(
    kind="a comparison of a sweep",
    version=VERSION,
    fields={
        "key": DIGEST,
        "reference": DIGEST,
        "values": Field("a table of numbers", table_of(_is_number)),
    },
)
