"""A picture in a notebook that changes while it is rendered."""

from __future__ import annotations

import math
import time
from typing import Any

#: Seconds between two pictures.
SHOW_EVERY_S = 1.0


class LiveView:
    """A picture in a notebook that is replaced from time to time.

    `update` takes anything with `_repr_html_`.
    """

    def __init__(self) -> None:
        from IPython import display

        api: Any = display
        self._html = api.HTML
        self._handle = api.display(api.HTML(""), display_id=True)
        self._shown = -math.inf

    def update(self, picture: Any, *, last: bool) -> None:
        now = time.perf_counter()
        if self._handle is None or not (last or now - self._shown >= SHOW_EVERY_S):
            return
        self._shown = now
        self._handle.update(self._html(picture._repr_html_()))
