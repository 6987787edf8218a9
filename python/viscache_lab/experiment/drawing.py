"""Pictures from panels: images, dots on images, series over a parameter."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

import viscache as vc
from viscache.base import tonemap
from viscache.plots.drawing import new_figure

Floats = npt.NDArray[np.floating[Any]]


class Series(NamedTuple):
    """A line or points of a panel; the style is Matplotlib's."""

    name: str
    x: Sequence[float]
    y: Sequence[float]
    style: str = "o-"
    color: str | None = None

    @classmethod
    def through(cls, name: str, points: Iterable[tuple[float, float]], *more: Any) -> Series:
        """The series of points (x, y)."""
        x, y = zip(*points, strict=True)
        return cls(name, x, y, *more)


@dataclass(frozen=True, kw_only=True, slots=True)
class Panel:
    """Axes of a picture: a linear image (H, W, C), or series.

    `logarithmic` has the letters of such axes, `legend` shows the names of the series, and `more`
    draws onto the axes what a panel has beside these.
    """

    title: str = ""
    image: Floats | None = None
    exposure: float | None = None
    series: Sequence[Series] = ()
    x: str = ""
    y: str = ""
    logarithmic: str = ""
    legend: bool = True
    more: Callable[[Any], object] | None = None

    def draw(self, axes: Any) -> None:
        """Draw onto axes."""
        if self.image is not None:
            draw_image(axes, self.image, self.title, exposure=self.exposure)
        for s in self.series:
            given = {} if s.color is None else {"color": s.color}
            axes.plot(s.x, s.y, s.style, ms=3, lw=1.2, label=s.name or None, **given)
        if self.series:
            scales = {f"{axis}scale": "log" for axis in self.logarithmic}
            axes.set(xlabel=self.x, ylabel=self.y, **scales)
            axes.set_title(self.title, fontsize=9)
            axes.grid(lw=0.3)
        if self.legend and any(s.name for s in self.series):
            axes.legend(fontsize=8)
        if self.more is not None:
            self.more(axes)


Panels = Sequence[Sequence[Panel | None]]


def images(shown: Mapping[str, Any], exposure: float | None = None) -> list[Panel]:
    """A panel for each image or frame, by its title."""
    return [
        Panel(title=title, image=getattr(one, "image", one), exposure=exposure)
        for title, one in shown.items()
    ]


def lines(
    drawn: Mapping[str, tuple[Sequence[float], Sequence[float]]],
    *,
    x: str,
    y: str,
    logarithmic: str = "xy",
) -> Panels:
    """One panel with a line per name."""
    series = [Series(name, *points) for name, points in drawn.items()]
    return [[Panel(series=series, x=x, y=y, logarithmic=logarithmic)]]


def draw(panels: Panels, inches: tuple[float, float]) -> Any:
    """The picture of rows of panels; None leaves a place empty."""
    figure = new_figure(*inches)
    columns = max(len(row) for row in panels)
    for i, row in enumerate(panels):
        for k, panel in enumerate(row):
            if panel is not None:
                panel.draw(figure.add_subplot(len(panels), columns, i * columns + k + 1))
    return figure


def described(figure: Any) -> list[dict[str, Any]]:
    """What the axes of a picture show: title, labels, names of series, and number of images."""
    return [
        {
            "title": axes.get_title(),
            "x": axes.get_xlabel(),
            "y": axes.get_ylabel(),
            "series": list(axes.get_legend_handles_labels()[1]),
            "images": len(axes.images),
        }
        for axes in figure.axes
    ]


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
