"""Matplotlib figures that a notebook shows by themselves, without pyplot."""

from __future__ import annotations

import io
from functools import cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def new_figure(width: float, height: float) -> Figure:
    """An empty figure; sizes are in inches.

    Jupyter shows figures only after `%matplotlib inline` or an import of pyplot, but always shows
    this one.
    """
    return _shown_class()(figsize=(width, height), layout="constrained")


@cache
def _shown_class() -> type[Figure]:
    from matplotlib.figure import Figure

    class ShownFigure(Figure):
        def _repr_png_(self) -> bytes:
            png = io.BytesIO()
            self.savefig(png, format="png")
            return png.getvalue()

    return ShownFigure
