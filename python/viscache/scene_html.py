"""What notebooks show of a scene: a thumbnail, its size, its lights, its warnings."""

from __future__ import annotations

import html
from collections import Counter
from typing import TYPE_CHECKING

import numpy as np

from viscache.cameras import find_camera
from viscache.frame_html import picture
from viscache.render import render
from viscache.settings.integrators import Direct

if TYPE_CHECKING:
    from viscache.scene import Scene

__all__ = ["scene_html", "thumbnail"]

#: Pixels of a thumbnail's longer edge.
EDGE_PX = 240
#: Few samples: a thumbnail is looked at, not measured.
QUICK = Direct(n_area=4, n_environment=4, n_brdf=0)


def scene_html(scene: Scene) -> str:
    """The thumbnail and a table; where no picture can be made, the reason in its place."""
    try:
        shown = thumbnail(scene)
    except (ValueError, MemoryError, RuntimeError) as error:  # the rest is worth showing
        shown = f"<p>{html.escape(f'no picture: {error}')}</p>"
    low, high = scene.bounds
    lights = Counter(str(light["kind"]) for light in scene.lights)
    rows = {
        "triangles": f"{scene.triangles:,}",
        "bounds": f"{_corner(low)} … {_corner(high)}",
        "lights": ", ".join(f"{count} {kind}" for kind, count in lights.items()) or "none",
        "cameras": ", ".join(camera.name for camera in scene.cameras) or "none",
    }
    cells = "".join(
        f"<tr><td>{name}</td><td>{html.escape(text)}</td></tr>" for name, text in rows.items()
    )
    warnings = "".join(f"<li>{html.escape(text)}</li>" for text in scene.warnings)
    title = html.escape(scene.spec or scene.name or "unnamed scene")
    below = f"<ul>{warnings}</ul>" if warnings else ""
    return f"<div>{shown}<table><caption>{title}</caption>{cells}</table>{below}</div>"


def thumbnail(scene: Scene) -> str:
    """A small picture in direct light, or of the normals where that is black."""
    view = find_camera(scene, None)
    scale = EDGE_PX / max(view.width, view.height)
    size = (max(1, round(view.width * scale)), max(1, round(view.height * scale)))
    frame = render(scene, QUICK, size=size)
    if frame.image.any():
        return picture(frame.image, "thumbnail")
    seen = frame.layers["normal"].any(axis=2, keepdims=True)
    return picture(np.where(seen, 0.5 + 0.5 * frame.layers["normal"], 0), "normals")


def _corner(corner: np.ndarray[tuple[int, ...], np.dtype[np.float32]]) -> str:
    return f"({', '.join(f'{value:.4g}' for value in corner)})"
