"""A scene that is long in work, for processes that are stopped while they render it."""

from __future__ import annotations

import viscache as vc
from render.mitsuba_scene import Model, ball, box, quad


def busy_scene() -> vc.Scene:
    parts = (
        box((-3, 0, -3), (3, 3, 3)).reversed(),
        *(ball((x, y, z), 0.3, 24) for x in (-1, 0, 1) for y in (0.5, 1.5) for z in (-1, 0)),
        quad((-1, 2.9, -1), (2, 0, 0), (0, 0, 2), emission=(5, 5, 5)),
    )
    return Model(parts, env=(0.5, 0.5, 0.5), origin=(0, 1.5, 2.8)).to_viscache()
