"""Files of visibility-map caches."""

from __future__ import annotations

import io
import json
import math
import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from viscache.array_digests import arrays_digest
from viscache.files import DAMAGED_ARRAYS, whole_file
from viscache.provenance import VERSION
from viscache.settings.checks import require

__all__ = ["State", "read", "write"]

FORMAT = "viscache visibility-map cache"
#: Version of the layout and of the meaning of the bits; other versions are refused.
FORMAT_VERSION = 1
#: Settings whose names in older files differ.
RENAMED = {"settle": "repeat_passes"}


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


def digest(head: dict[str, Any], arrays: dict[str, npt.NDArray[Any]]) -> str:
    """Hash of scene, settings, version and content."""
    return arrays_digest(json.dumps(head, sort_keys=True).encode(), arrays)


def write(path: str | os.PathLike[str], state: State) -> None:
    """Write a file atomically."""
    head = {
        "format": FORMAT,
        "format_version": FORMAT_VERSION,
        "viscache": VERSION,
        "scene_hash": state.scene_hash,
        "settings": state.settings,
        "frame": state.frame,
        "started": state.started,
        "rays": state.rays,
        "thresholds": list(state.thresholds),
    }
    arrays = {"directions": state.directions, **state.records}
    text = json.dumps(head | {"digest": digest(head, arrays)})
    target = Path(path)
    try:
        with whole_file(target) as partial, partial.open("wb") as file:
            np.savez_compressed(file, head=np.array(text), **arrays)  # type: ignore[arg-type]
    except OSError as error:
        raise OSError(f"cannot write {target}: {error}") from error


def read(path: str | os.PathLike[str], scene_hash: str) -> State:
    """Read a file of the scene with this hash.

    Raises
    ------
    ValueError
        The file is not a cache, is damaged, has another version, or is of another scene.
    OSError
        The file cannot be read.
    """
    head, arrays = _opened(path)
    found = head.get("format_version")
    require(found == FORMAT_VERSION, f"{path}: the cache's version must be {FORMAT_VERSION}", found)
    scene = head.get("scene_hash")
    require(
        scene == scene_hash,
        f"{path}: the cache must be of the scene given, whose hash is {scene_hash}",
        f"a cache of the scene {scene}",
    )
    claimed = head.pop("digest", None)
    fits = claimed == digest(head, arrays)
    require(fits, f"{path}: the cache must be undamaged", "content that its digest does not fit")
    require("directions" in arrays, f"{path}: the cache must have directions", sorted(arrays))
    return State(
        scene_hash=scene_hash,
        directions=arrays.pop("directions"),
        records=arrays,
        **{name: _field(path, head, name) for name in FIELDS},
    )


def _field(path: str | os.PathLike[str], head: dict[str, Any], name: str) -> Any:
    """A field of the head; ValueError unless it is there and of its kind."""
    what, fits = FIELDS[name]
    value: Any = head.get(name)
    require(fits(value), f"{path}: {name} of the cache must be {what}", value)
    if name == "settings":
        return {RENAMED.get(key, key): setting for key, setting in value.items()}
    return tuple(value) if name == "thresholds" else value


def _is_count(value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and 0 <= value < 1 << 63


#: What the head must hold beside the version, the scene and the digest.
FIELDS: dict[str, tuple[str, Callable[[Any], bool]]] = {
    "settings": ("a table of settings", lambda v: isinstance(v, dict)),
    "frame": ("a whole number >= 0", _is_count),
    "started": ("true or false", lambda v: isinstance(v, bool)),
    "rays": ("a whole number >= 0", _is_count),
    "thresholds": (
        "two finite numbers",
        lambda v: (
            isinstance(v, list)
            and len(v) == 2
            and all(isinstance(x, int | float) and math.isfinite(x) for x in v)
        ),
    ),
}


def _opened(path: str | os.PathLike[str]) -> tuple[dict[str, Any], dict[str, npt.NDArray[Any]]]:
    """Head and arrays of any file that looks like a cache."""
    content = io.BytesIO(Path(path).read_bytes())
    try:
        with np.load(content, allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
        head = json.loads(str(arrays.pop("head")))
    except DAMAGED_ARRAYS as error:
        raise ValueError(f"{path}: must be a file of VisibilityMapCache.save: {error}") from error
    known = isinstance(head, dict) and head.get("format") == FORMAT
    require(known, f"{path}: must be a file of VisibilityMapCache.save", head)
    return head, arrays
