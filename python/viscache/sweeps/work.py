"""One frame of a sweep, rendered here or in a worker."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any

from viscache import sources
from viscache.array_digests import content_key
from viscache.frame import Frame
from viscache.render import render
from viscache.sharing import Newest
from viscache.shot import Shot, environment_in_words, require_same

#: Tests put a stand-in here.
render_function: Callable[..., Frame] = render


def render_task(task: Shot, scene: Any = None) -> Frame:
    """Render one frame; runs in this process or in a worker."""
    opened = _lit(task, scene if scene is not None else _opened(task))
    cpu = time.process_time()
    frame = render_function(
        opened,
        task.integrator,
        rays=task.rays,
        visibility=task.visibility,
        use=task.use,
        size=task.size,
        spp=task.spp,
        seed=task.seed,
        threads=task.threads,
        camera=task.camera,
    )
    # CPU time is that of the process, so it is unknown for one thread of a pool
    if threading.current_thread() is threading.main_thread():
        frame.timings.setdefault("cpu_s", time.process_time() - cpu)
    return frame


_SCENE, _LIT = Newest(), Newest()


def _opened(task: Shot) -> Any:
    """The scene of a task, in a worker."""
    scene = task.scene
    if not isinstance(scene, str):  # a scene that travelled, or a stand-in
        return scene
    opened = _SCENE.get(scene, lambda: sources.open_scene(scene))
    if str(opened.content_hash) != task.parts["scene"]:
        raise ValueError(f"scene {scene} is not the one the sweep began with (its content differs)")
    return opened


def _lit(task: Shot, scene: Any) -> Any:
    """The scene under the task's environment, which must be the one that the sweep began with."""
    if task.env is None:
        return scene
    env = task.parts["env"]

    def make() -> Any:
        require_same(env, environment_in_words(task.env), "as when the sweep began", "env")
        return scene.with_environment(task.env, threads=task.threads)

    return _LIT.get(content_key({"scene": task.parts["scene"], "env": env}), make)
