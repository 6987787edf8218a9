"""Drawings of the figures: images, dots on images, lines over a parameter."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

import viscache as vc
from viscache.base import tonemap
from viscache.plots.drawing import new_figure

__all__ = ["draw_image", "draw_lines", "draw_records", "new_figure", "project", "save_figure"]

Floats = npt.NDArray[np.floating[Any]]


def save_figure(figure: Any, path: Path, dpi: int = 120) -> Path:
    """Write the figure and return its path."""
    figure.savefig(path, dpi=dpi)
    return path


def draw_lines(
    lines: Mapping[str, tuple[Sequence[float], Sequence[float]]],
    path: Path,
    *,
    x: str,
    y: str,
    logarithmic: str = "xy",
) -> Path:
    """A line per name through its points (x, y)."""
    figure = new_figure(6.0, 4.0)
    axes = figure.add_subplot(1, 1, 1)
    for name, (across, up) in lines.items():
        axes.plot(across, up, "o-", ms=3, lw=1.2, label=name)
    if "x" in logarithmic:
        axes.set_xscale("log")
    if "y" in logarithmic:
        axes.set_yscale("log")
    axes.set(xlabel=x, ylabel=y)
    axes.grid(lw=0.3)
    axes.legend(fontsize=8)
    return save_figure(figure, path)


def project(camera: vc.Camera, size: tuple[int, int], points: Floats) -> Floats:
    """(N, 2) pixel coordinates of (N, 3) points, from the upper left; NaN behind the camera."""
    width, height = size
    offset = np.asarray(points, float) - np.array(camera.origin)
    along, right, up = (offset @ np.array(v) for v in (camera.forward, camera.right, camera.up))
    along = np.where(along > 0, along, np.nan)
    across = camera.view_height or 2 * math.tan(camera.fov_rad / 2)
    scale = (width if camera.fov_is_horizontal else height) / across
    if camera.view_height > 0:
        along = along / along
    return np.stack([width / 2 + scale * right / along, height / 2 - scale * up / along], axis=-1)


def draw_image(axes: Any, image: Floats, title: str = "", *, exposure: float | None = None) -> None:
    """Draw a linear (H, W, C) image in sRGB; by default, white is the 95th percentile."""
    given = tonemap.auto_exposure(image, 95.0) if exposure is None else exposure
    shown = tonemap.srgb_curve(np.asarray(image) * given)
    axes.imshow(np.repeat(shown, 3, axis=2) if shown.shape[2] == 1 else shown[:, :, :3])
    axes.set_title(title, fontsize=9)
    axes.set_axis_off()


def draw_records(
    axes: Any, image: Floats, camera: vc.Camera, positions: Floats, title: str
) -> None:
    """Red dots at the records (N, 3), on the picture they were made for."""
    height, width = image.shape[:2]
    draw_image(axes, image, title)
    x, y = project(camera, (width, height), positions).T
    axes.scatter(x - 0.5, y - 0.5, s=4.0, c="red", lw=0, rasterized=True)
    axes.set(xlim=(-0.5, width - 0.5), ylim=(height - 0.5, -0.5))
