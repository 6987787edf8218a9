"""Scenes as arguments: a scene, a file, or a built-in name."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, Literal

from viscache import scenes
from viscache.base.progress import Progress
from viscache.scene import Scene, load_scene
from viscache.settings.checks import require

#: Environment variable: the folder of scenes that are not part of viscache.
SCENES_VARIABLE = "VISCACHE_SCENES"


def made_by_others(path: str) -> Path | None:
    """A file in the folder `$VISCACHE_SCENES`; None if it does not exist."""
    folder = os.environ.get(SCENES_VARIABLE)
    file = Path(folder or "") / path
    return file if folder and file.is_file() else None


def scene_file(name: str) -> Path | None:
    """`$VISCACHE_SCENES/name/scene.xml` or `.pbrt`; None if neither exists."""
    return made_by_others(f"{name}/scene.xml") or made_by_others(f"{name}/scene.pbrt")


def is_builtin(spec: str) -> bool:
    """Whether a spec names a built-in scene: `room`, `room?triangles=200000&lights=24`.

    It does if there is no dot or slash before the `?`, and no file of that name. A folder of the
    same name does not hide a built-in scene.
    """
    name = spec.partition("?")[0]
    if not name or set("./\\") & set(name) or Path(spec).is_file():
        return False
    return not Path(spec).is_dir() or name in scenes.SCENES


def absolute(spec: str, relative_to: str | os.PathLike[str] | None) -> str:
    """The spec with a relative path resolved against a folder; built-in names stay."""
    if relative_to is None or is_builtin(spec):
        return spec
    return str(Path(relative_to) / spec)


def open_scene(
    spec: str,
    *,
    strict: bool = False,
    missing: Literal["error", "skip"] = "error",
    allow_outside: bool = False,
    env: str | None = None,
    progress: Progress = False,
) -> Scene:
    """The scene of a spec, with the options and errors of `load_scene`.

    ValueError for an unknown built-in scene or parameter.
    """
    require(bool(spec), "the scene must be a file or a built-in name", spec)
    if is_builtin(spec):
        made: Scene = scenes.build(spec)
        return made
    return load_scene(
        spec,
        strict=strict,
        missing=missing,
        allow_outside=allow_outside,
        env=env,
        progress=progress,
    )


def opened(scene: Any) -> Scene:
    """The scene that an argument `scene` means: a Scene itself, a path, or a built-in name."""
    if isinstance(scene, str | os.PathLike):
        return open_scene(os.fspath(scene))
    require(isinstance(scene, Scene), "scene must be a Scene, a file or a built-in name", scene)
    checked: Scene = scene
    return checked
