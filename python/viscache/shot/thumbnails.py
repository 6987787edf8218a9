"""Small pictures of scenes, for `Scene` in notebooks."""

from __future__ import annotations

import numpy as np

from viscache.frame.html import picture
from viscache.scene import Scene
from viscache.scene.cameras import find_camera
from viscache.settings.integrators import Direct
from viscache.shot.render import render

#: Pixels along the longer edge of a thumbnail.
EDGE_PX = 240
#: Few samples: a thumbnail is not used for measurements.
QUICK = Direct(n_area=4, n_environment=4, n_brdf=0)


def thumbnail(scene: Scene) -> str:
    """An HTML element: the scene in direct light, or its normals if that is black."""
    view = find_camera(scene, None)
    scale = EDGE_PX / max(view.width, view.height)
    size = (max(1, round(view.width * scale)), max(1, round(view.height * scale)))
    frame = render(scene, QUICK, size=size)
    if frame.image.any():
        return picture(frame.image, "thumbnail")
    seen = frame.layers["normal"].any(axis=2, keepdims=True)
    return picture(np.where(seen, 0.5 + 0.5 * frame.layers["normal"], 0), "normals")
