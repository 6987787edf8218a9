"""Blank pictures for the visibility field's figures, and lines over one parameter."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

__all__ = ["draw_lines", "new_figure", "save_figure"]


def new_figure(size: tuple[float, float]) -> Any:
    """An empty picture; inches."""
    from matplotlib.figure import Figure

    return Figure(figsize=size, layout="constrained")


def save_figure(figure: Any, path: Path) -> Path:
    """Write it; returns the path."""
    figure.savefig(path, dpi=120)
    return path


def draw_lines(
    lines: Mapping[str, tuple[Sequence[float], Sequence[float]]],
    path: Path,
    *,
    x: str,
    y: str,
    logarithmic: str = "xy",
) -> Path:
    """One line per name through its points (x, y)."""
    figure = new_figure((6.0, 4.0))
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
