"""One frame of a sweep, rendered here or in a worker."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any

from viscache.frame import Frame
from viscache.shot.render import render
from viscache.shot.shot import BareShot, lit_here

#: Tests put a stand-in here.
render_function: Callable[..., Frame] = render


def render_task(task: BareShot, scene: Any = None) -> Frame:
    """Render one frame; runs in this process or in a worker."""
    cpu = time.process_time()
    frame = render_function(**lit_here(task, scene).arguments)
    # CPU time is that of the process, so it is unknown for one thread of a pool
    if threading.current_thread() is threading.main_thread():
        frame.timings.setdefault("cpu_s", time.process_time() - cpu)
    return frame
