"""Files of visibility-map caches."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from viscache.base.formats import (
    COUNT,
    FLAG,
    TABLE,
    TEXT,
    ArrayField,
    Field,
    Format,
    is_number,
    list_of,
)
from viscache.base.provenance import VERSION
from viscache.settings.checks import require

#: Arrays of records, also in states of `vc.Progressive`.
RECORDS = {
    "positions": ArrayField("f4", ("records", 3)),
    "normals": ArrayField("f4", ("records", 3)),
    "bits": ArrayField("u8", ("records", "words")),
    **dict.fromkeys(("rays", "misses", "last_used"), ArrayField("u4", ("records",))),
    **dict.fromkeys(("ambient", "nearest_hit"), ArrayField("f4", ("records",))),
}
#: Version 2 has another head than version 1.
FORMAT = Format(
    kind="a file of VisibilityMapCache.save",
    version=2,
    fields={
        "viscache": TEXT,
        "scene_hash": TEXT,
        "settings": TABLE,
        "frame": COUNT,
        "started": FLAG,
        "rays": COUNT,
        "thresholds": Field("two finite numbers", lambda v: list_of(is_number)(v) and len(v) == 2),
    },
    arrays={"directions": ArrayField("f4", ("bits", 3)), **RECORDS},
)


@dataclass(frozen=True, kw_only=True, slots=True)
class State:
    """Content of a file."""

    scene_hash: str
    settings: dict[str, Any]
    directions: npt.NDArray[np.float32]
    frame: int
    started: bool
    rays: int
    thresholds: tuple[float, float]
    records: dict[str, npt.NDArray[Any]]


def write(path: str | os.PathLike[str], state: State) -> None:
    """Write a file atomically."""
    fields = {name: getattr(state, name) for name in FORMAT.fields if name != "viscache"}
    target = Path(path)
    try:
        FORMAT.write_npz(
            target,
            fields | {"viscache": VERSION, "thresholds": list(state.thresholds)},
            {"directions": state.directions, **state.records},
            compressed=True,
        )
    except OSError as error:
        raise OSError(f"cannot write {target}: {error}") from error


def read(path: str | os.PathLike[str], scene_hash: str) -> State:
    """Read a file of the scene with this hash.

    ValueError if it is no cache, is damaged, of another version, or of another scene; OSError if it
    cannot be read.
    """
    fields, arrays = FORMAT.read_npz(Path(path))
    scene = fields["scene_hash"]
    require(
        scene == scene_hash,
        f"{path}: the cache must be of the scene given, whose hash is {scene_hash}",
        f"a cache of the scene {scene}",
    )
    fields["thresholds"] = tuple(fields["thresholds"])
    return State(
        directions=arrays.pop("directions"),
        records=arrays,
        **{name: value for name, value in fields.items() if name != "viscache"},
    )
