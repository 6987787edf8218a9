"""Scenes from files."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Literal

from viscache import _core
from viscache._core import SceneError
from viscache.base.progress import Progress, progress_bar
from viscache.scene.environments import apply_environment, decode_image, pending_images
from viscache.scene.parts import origin_of
from viscache.scene.scene import Env, Scene
from viscache.settings.checks import checked_threads, require
from viscache.settings.spelling import spelled


@spelled
def load_scene(
    path: str | os.PathLike[str],
    *,
    strict: bool = False,
    missing: Literal["error", "skip"] = "error",
    allow_outside: bool = False,
    env: Env | None = None,
    origin: Sequence[float] = (0.0, 0.0, 0.0),
    threads: int | None = None,
    progress: Progress = False,
) -> Scene:
    """Load a scene file.

    Parameters
    ----------
    path : path
        `.xml` (Mitsuba), `.pbrt`, `.gltf`, `.glb`, `.obj` or `.ply`.
    strict : bool
        What makes the picture wrong is an error: features that viscache does not model, values and
        files that cannot be used. By default each is one line of `Scene.warnings`, with the places
        where it stands.
    missing : {"error", "skip"}
        What happens where a Mitsuba or pbrt scene names a mesh file that is not there: an error, or
        the shape is left out with a warning.
    allow_outside : bool
        Files outside of the scene's folder may be read. By default they are errors, and textures
        are left out with a warning. Folders of assets beside the scene's folder, or one level
        higher, are no outside: `../textures`, `../hdr`, `../../common`.
    env : Sky, path, float, (3,) or (H, W, 3), optional
        Environment light that replaces the file's.
    origin : (3,) float
        The point of the file's world that becomes (0, 0, 0) of the scene, as in
        `Scene.from_arrays`. glTF files lose nothing, as their transforms are doubles. Others are
        moved when their coordinates are floats already: rays lose no more, shapes have lost.
    threads : int, optional
        All cores by default.
    progress : bool or callable
        True shows a bar. A callable gets (done, total) after each step: the file, its EXR images
        one by one, and Embree's structure.

    Raises
    ------
    SceneError
        The file is missing, malformed or inconsistent; the message gives file and place.
    """
    if str(path) and Path(path).is_dir():
        raise SceneError(f"{path}: is a directory, not a scene file")
    require(missing in ("error", "skip"), 'missing must be "error" or "skip"', missing)
    count = checked_threads(threads)
    with progress_bar(progress, unit="step") as report:
        told = report or (lambda done, total: None)
        told(0, 2)
        description = _core.load_scene_file(
            os.fspath(path),
            strict=strict,
            skip_missing=missing == "skip",
            allow_outside=allow_outside,
            origin=origin_of(origin),
        )
        images = pending_images(description)
        steps = len(images) + 2
        told(1, steps)
        for done, image in enumerate(images, 2):
            decode_image(description, image)
            told(done, steps)
        if env is not None:
            apply_environment(description, env)
        try:
            frozen = _core.Scene.freeze(description, count, take=True)
        except SceneError as error:  # parts are checked once all are read; they know no file
            raise SceneError(f"{os.fspath(path)}: {error}") from error
        told(steps, steps)
    return Scene(frozen, str(Path(path)))
