"""Converged reference pictures, rendered once and stored by content hash."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import Any

from viscache.frame import Frame
from viscache.render import render
from viscache.scene import Scene
from viscache.settings import by_name
from viscache.sweeps.store import Store, content_key

__all__ = ["kept_in", "reference"]

_FOLDER: ContextVar[tuple[Path, str] | None] = ContextVar("references", default=None)


@contextmanager
def kept_in(folder: Path, code: str) -> Iterator[None]:
    """In this context `reference` stores its frames in a folder, separately for each `code`."""
    token = _FOLDER.set((folder, code))
    try:
        yield
    finally:
        _FOLDER.reset(token)


def reference(
    scene: Scene,
    integrator: Any,
    *,
    size: tuple[int, int],
    spp: int = 1,
    seed: int = 0,
    camera: Any = None,
    progress: bool = False,
) -> Frame:
    """An exact frame, read from the folder if it exists there, with the timings of its rendering.

    Do not use it for timed frames.
    """
    options: dict[str, Any] = {"size": size, "spp": spp, "seed": seed, "camera": camera}
    where = _FOLDER.get()
    if where is None or not isinstance(camera, str | int | None):
        return render(scene, integrator, progress=progress, **options)
    folder, code = where
    spec = {
        "code": code,
        "scene": scene.content_hash,
        "integrator": by_name.described("integrator", integrator),
        **options,
    }
    key = content_key(spec)
    with Store(folder) as store:
        if store.get(key) is None:
            store.put(key, spec, render(scene, integrator, progress=progress, **options))
        return store.frame(key)
