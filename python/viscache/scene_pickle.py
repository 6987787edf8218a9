"""Scenes that travel to other processes: by their spec where that gives the same scene again."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from viscache import _core, sources
from viscache._core import SceneDescription, SceneError
from viscache.newest import Newest
from viscache.scene import Scene

__all__ = ["reduced", "reopens"]

#: A process that is sent one scene many times makes it once.
_NEWEST = Newest()


def reduced(scene: Scene) -> tuple[Callable[..., Scene], tuple[Any, ...]]:
    """What `Scene.__reduce__` returns."""
    if scene.spec is not None and scene._reopens:
        where = sources.absolute(scene.spec, Path.cwd())
        return _from_spec, (where, scene.spec, scene.content_hash)
    return _from_arrays, (_core.description_of(scene._core), scene.spec, scene.content_hash)


def reopens(scene: Scene) -> bool:
    """Whether the spec gives a scene of the same content now."""
    try:
        return sources.open_scene(scene.spec or "").content_hash == scene.content_hash
    except (ValueError, OSError, MemoryError):
        return False


def _from_spec(where: str, spec: str, content_hash: str) -> Scene:
    def make() -> Scene:
        made = sources.open_scene(where)
        if made.content_hash != content_hash:
            raise SceneError(f"{where}: must be the scene that was sent, its content differs")
        made.spec = spec
        return made

    return _kept((content_hash, spec), make)


def _from_arrays(description: SceneDescription, spec: str | None, content_hash: str) -> Scene:
    return _kept((content_hash, spec), lambda: Scene.from_description(description, spec=spec))


def _kept(key: tuple[str, str | None], make: Callable[[], Scene]) -> Scene:
    made: Scene = _NEWEST.get(key, make)
    return made
