"""For notebooks: a live view of a frame during rendering, and sliders that render again.

Sliders need `viscache[notebook]`; without ipywidgets there is one picture.
"""

from __future__ import annotations

import html
import importlib
import os
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from viscache.base import tonemap
from viscache.frame import Frame
from viscache.settings.checks import require
from viscache.settings.spelling import spelled

__all__ = ["Film", "Sliders", "is_quick", "sliders"]

#: Seconds between two views of a frame during rendering.
REFRESH_S = 0.2


def is_quick() -> bool:
    """Whether notebooks use small sizes: VISCACHE_QUICK is set."""
    return bool(os.environ.get("VISCACHE_QUICK"))


@spelled
class Film:
    """Shows a frame during rendering: `vc.tiles.render(..., show=vc.notebook.Film())`.

    Parameters
    ----------
    exposure : float, optional
        Linear factor; by the picture's 99th percentile by default.
    refresh_s : float
        Minimum number of seconds between two views. The last view is always shown.
    """

    def __init__(self, exposure: float | None = None, refresh_s: float = REFRESH_S) -> None:
        require(refresh_s >= 0, "refresh_s must be >= 0", refresh_s)
        self.exposure, self.refresh_s = exposure, refresh_s
        #: Views shown so far.
        self.views = 0
        self._handle: Any = None
        self._next = 0.0

    def __call__(self, frame: Frame, done: int, total: int) -> None:
        now = time.perf_counter()
        if done < total and now < self._next:
            return
        self._next = now + self.refresh_s
        self.views += 1
        display: Any = importlib.import_module("IPython.display")
        shown = display.Image(data=png(frame.image, self.exposure))
        if self.views == 1:
            self._handle = display.display(shown, display_id=True)
        else:
            self._handle.update(shown)


def png(image: npt.NDArray[np.floating[Any]], exposure: float | None = None) -> bytes:
    """A scene-linear picture as PNG."""
    pixels = tonemap.to_srgb8(np.asarray(image), exposure)
    # Shown once, so fast to make rather than small
    return tonemap.encode(pixels, max_width=1280, effort=1)


class Sliders:
    """Sliders above a picture; moving one renders again.

    Attributes
    ----------
    widgets : dict of str to the slider
    milliseconds : list of float
        Time per picture, with rendering and encoding.
    text : str
        Text below the picture.
    """

    def __init__(
        self,
        render: Callable[..., tuple[Any, str]],
        values: Mapping[str, Sequence[Any]],
        first: Mapping[str, Any],
        exposure: float | None,
        live: bool = False,
    ) -> None:
        import ipywidgets

        self._render, self.exposure, self._live = render, exposure, live
        self._changed, self._moves, self._drawn = threading.Condition(), 0, 0
        self._follower: threading.Thread | None = None
        self.milliseconds: list[float] = []
        self.text = ""
        self.widgets: dict[str, Any] = {
            name: ipywidgets.SelectionSlider(
                options=list(options),
                value=first.get(name, options[0]),
                description=name,
                continuous_update=live,
            )
            for name, options in values.items()
        }
        self.picture = ipywidgets.Image(format="png")
        self._label = ipywidgets.HTML()
        self.box = ipywidgets.VBox([*self.widgets.values(), self.picture, self._label])
        for widget in self.widgets.values():
            widget.observe(lambda _: self._moved(), names="value")
        self.draw()

    def draw(self) -> None:
        """Render with the current values of the sliders."""
        began = time.perf_counter()
        image, text = self._render(**{n: w.value for n, w in self.widgets.items()})
        self.picture.value = png(getattr(image, "image", image), self.exposure)
        self.milliseconds.append(1000 * (time.perf_counter() - began))
        self.text = text
        self._label.value = f"{text} ({self.milliseconds[-1]:.0f} ms)"

    def settle(self, timeout_s: float | None = None) -> bool:
        """Wait until the picture has the newest values; False if that takes longer."""
        with self._changed:
            return self._changed.wait_for(lambda: self._drawn == self._moves, timeout_s)

    def _moved(self) -> None:
        if not self._live:
            self.draw()
            return
        with self._changed:
            self._moves += 1
            if self._follower is None:
                self._follower = threading.Thread(target=self._follow, daemon=True)
                self._follower.start()

    def _follow(self) -> None:
        """Draw until the newest values are shown. Values in between are skipped."""
        while True:
            with self._changed:
                if self._drawn == self._moves:
                    self._follower = None
                    return
                newest = self._moves
            try:
                self.draw()
            except Exception as error:  # has nowhere else to go
                self._label.value = html.escape(f"{type(error).__name__}: {error}")
            with self._changed:
                self._drawn = newest
                self._changed.notify_all()

    def _ipython_display_(self) -> None:
        importlib.import_module("IPython.display").display(self.box)


def sliders(
    render: Callable[..., tuple[Any, str]],
    *,
    first: Mapping[str, Any] | None = None,
    exposure: float | None = None,
    live: bool = False,
    **values: Sequence[Any],
) -> Sliders:
    """Sliders whose picture `render` makes.

    Parameters
    ----------
    render : callable
        Takes the sliders' values by name; returns a frame (or a scene-linear image) and a line.
    first : mapping, optional
        First values of the sliders.
    exposure : float, optional
        Linear factor. With a fixed one, pictures can be compared.
    live : bool
        Render in a thread while a slider is dragged; outdated values are skipped. For frames that
        take less than half a second.
    **values
        The values of each slider.

    Raises
    ------
    ValueError
        There is no slider, or one has no values, or a first value is not among the values.
    """
    require(bool(values), "there must be a slider", values)
    start = dict(first or {})
    for name, options in values.items():
        require(len(options) > 0, f"{name} must have values", options)
        require(
            start.get(name, options[0]) in list(options),
            f"first of {name} must be one of {list(options)}",
            start.get(name),
        )
    return Sliders(render, values, start, exposure, live)
