"""The view of a scene in notebooks: a thumbnail, its size, lights and warnings."""

from __future__ import annotations

import html
from collections import Counter
from collections.abc import Callable
from typing import Any


def scene_html(scene: Any, picture: Callable[[Any], str] | None) -> str:
    """The thumbnail and a table; without a thumbnail, the reason."""
    try:
        shown = picture(scene) if picture else ""
    except (ValueError, MemoryError, RuntimeError) as error:  # show the rest anyway
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


def _corner(corner: Any) -> str:
    return f"({', '.join(f'{value:.4g}' for value in corner)})"
