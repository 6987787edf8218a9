"""Exact frames, rendered once and kept in a folder by the hash of all that determines them."""

from __future__ import annotations

import os
import shutil
import time
from pathlib import Path
from typing import Any

from viscache import _core, sources
from viscache.frame import Frame
from viscache.progress import Progress
from viscache.provenance import code_hash, embree_version, isa
from viscache.render import render
from viscache.scene.cameras import find_camera, frame_size
from viscache.scene.scene import Env
from viscache.settings import by_name
from viscache.settings.checks import is_whole, require
from viscache.settings.integrators import Integrator
from viscache.settings.rays import Rays
from viscache.settings.spelling import spelled
from viscache.sweeps.plan import Task, checked_size, env_hash, frame_spec, positive
from viscache.sweeps.store import Store, content_key

__all__ = ["ExactFrames"]

#: Frames of other code that were not used for so long are removed.
KEPT_S = 30 * 24 * 3600.0
#: Seconds between looks at a frame that another process renders.
POLL_S = 0.05


class ExactFrames:
    """A function that renders exact frames and keeps them in a folder.

    A frame is found by the content of its scene and environment, integrator, rays, camera, size,
    samples and seed, and by the code of viscache, the version of Embree and the instruction set.
    So it is never one that would be rendered otherwise today. What is read is checked by its hash;
    a damaged frame is rendered again. Processes that share the folder render each frame once: the
    others wait for it. Frames of other code are removed after 30 days without use.

    Parameters
    ----------
    directory : path, optional
        Created with the first frame. None: nothing is kept.

    Examples
    --------
    >>> import tempfile, viscache as vc
    >>> exact = vc.testing.ExactFrames(tempfile.mkdtemp())
    >>> scene = vc.scenes.cube_on_plane()
    >>> first = exact(scene, vc.Direct(), size=(32, 20))
    >>> again = exact(scene, vc.Direct(), size=(32, 20))  # read, not rendered
    >>> again.sha256 == first.sha256 == vc.render(scene, vc.Direct(), size=(32, 20)).sha256
    True
    """

    def __init__(self, directory: str | os.PathLike[str] | None) -> None:
        self.directory = None if directory is None else Path(directory)

    def __repr__(self) -> str:
        return f"ExactFrames({None if self.directory is None else str(self.directory)!r})"

    @spelled
    def __call__(
        self,
        scene: Any,
        integrator: Integrator | str,
        *,
        size: tuple[int, int] | None = None,
        spp: int = 1,
        seed: int = 0,
        camera: str | int | _core.Camera | None = None,
        env: Env | None = None,
        rays: Rays | str | None = None,
        threads: int | None = None,
        progress: Progress = False,
    ) -> Frame:
        """An exact frame; parameters as of `viscache.render`.

        Timings are those of its rendering. Each call returns a frame of its own, which the caller
        may change.

        Raises
        ------
        ValueError
            As `viscache.render`.
        """
        opened = sources.opened(scene)
        view = find_camera(opened, camera)
        require(is_whole(seed) and 0 <= seed < 1 << 63, "seed must be in [0, 2^63)", seed)
        task = Task(
            scene=opened,
            scene_hash=str(opened.content_hash),
            integrator=by_name.setting("integrator", integrator),
            rays=by_name.setting("rays", rays, "embree"),
            visibility=by_name.make("visibility", "exact"),
            use=None,
            camera=view,
            env=env,
            env_hash=env_hash(env),
            size=checked_size(frame_size(size, view)),
            spp=positive("spp", spp),
            seed=int(seed),
            threads=threads,
        )
        if self.directory is None:
            return _rendered(task, progress)
        with Store(_room(self.directory)) as store:
            return _once(store, task, progress)


def _rendered(task: Task, progress: Progress) -> Frame:
    return render(
        task.scene,
        task.integrator,
        rays=task.rays,
        size=task.size,
        spp=task.spp,
        seed=task.seed,
        threads=task.threads,
        camera=task.camera,
        env=task.env,
        progress=progress,
    )


def _once(store: Store, task: Task, progress: Progress) -> Frame:
    """The frame of a store; one process renders it, the others wait."""
    spec = frame_spec(task)
    key = content_key(spec)
    while (found := _kept(store, key)) is None:
        if not store.claim(key):
            time.sleep(POLL_S)
            continue
        try:
            found = _kept(store, key)  # finished by another process before the claim
            if found is None:
                found = _rendered(task, progress)
                store.put(key, spec, found)
            return found
        finally:
            store.release(key)
    return found


def _kept(store: Store, key: str) -> Frame | None:
    """The frame of a key if it is there and as it was written."""
    try:
        return store.frame(key)
    except (KeyError, OSError, ValueError):
        return None


def _room(directory: Path) -> Path:
    """The folder of this code, Embree and instruction set; old ones of others are removed."""
    here = content_key({"code": code_hash(), "embree": embree_version(), "isa": isa()[0]})[:16]
    room = directory / here
    if not room.is_dir():
        room.mkdir(parents=True, exist_ok=True)
        for other in directory.iterdir():
            if (other / "sweep.sqlite").is_file() and _age_s(other) > KEPT_S:
                shutil.rmtree(other, ignore_errors=True)
    os.utime(room)
    return room


def _age_s(folder: Path) -> float:
    try:
        return time.time() - folder.stat().st_mtime
    except FileNotFoundError:  # another process was faster
        return 0.0
