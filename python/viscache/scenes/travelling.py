"""Pickling of scenes: by their spec if it gives the same scene again, else by their arrays."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from viscache._core import SceneDescription, SceneError
from viscache.base.sharing import Newest
from viscache.scene import Scene
from viscache.scenes import sources

#: The newest scene, so that a process makes a scene once if it is sent many times.
_NEWEST = Newest()


def reduced(scene: Scene) -> tuple[Callable[..., Scene], tuple[Any, ...]]:
    """How a scene is made again: what `copyreg.pickle` takes."""
    if scene._made.get("reopens", lambda: _reopens(scene)):
        spec = str(scene.spec)
        return _from_spec, (sources.absolute(spec, Path.cwd()), spec, scene.content_hash)
    return _from_arrays, (scene.description(), scene.spec, scene.content_hash)


def _reopens(scene: Scene) -> bool:
    """Whether the spec gives a scene of the same content."""
    if scene.spec is None or scene.origin.any():
        return False
    try:
        return sources.open_scene(str(scene.spec)).content_hash == scene.content_hash
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
    return _NEWEST.get(key, make)
