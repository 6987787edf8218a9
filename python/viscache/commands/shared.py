"""What several sub-commands share: printing, sizes, settings from options."""

from __future__ import annotations

import argparse
import json
import multiprocessing
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import AbstractContextManager, nullcontext
from typing import Any

from viscache import settings
from viscache.json_values import finite


def print_json(value: Any) -> None:
    """One JSON object on standard output; non-finite numbers become null."""
    print(json.dumps(finite(value), indent=2, allow_nan=False))


def print_table(rows: dict[str, Any]) -> None:
    """Names and values in two columns."""
    width = max((len(name) for name in rows), default=0)
    for name, value in rows.items():
        text = "undefined" if value is None else value
        print(
            f"{name:<{width}}  {text:.6g}"
            if isinstance(text, float)
            else f"{name:<{width}}  {text}"
        )


def size(text: str) -> tuple[int, int]:
    """`640x400` → (640, 400)."""
    width, x, height = text.lower().partition("x")
    if not x or not width.isdecimal() or not height.isdecimal() or 0 in (int(width), int(height)):
        raise argparse.ArgumentTypeError(f"size must be WxH, both >= 1, got {text!r}")
    return (int(width), int(height))


def at_least_one(text: str) -> int:
    """A whole number >= 1."""
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"must be a whole number >= 1, got {text!r}")
    return int(text)


def chosen_settings(arguments: argparse.Namespace) -> dict[settings.Role, Any]:
    """Integrator, rays and visibility of the options, with `--set` applied."""
    rays, visibility = arguments.rays, arguments.visibility
    if visibility in settings.RAYS_AS_VISIBILITY:
        if rays not in ("embree", visibility):
            raise ValueError(
                f"--visibility {visibility} is short for --rays, got --rays {rays} too"
            )
        rays, visibility = visibility, "exact"
    chosen: dict[settings.Role, Any] = {
        "integrator": settings.make("integrator", arguments.integrator),
        "rays": settings.make("rays", rays),
        "visibility": settings.make("visibility", visibility),
    }
    return settings.assign(chosen, arguments.set)


def worker_pool(workers: int) -> AbstractContextManager[Executor | None]:
    """A pool of processes; None for one worker, this process itself."""
    if workers == 1:
        return nullcontext()
    # spawn: a forked child would inherit Embree's and our threads in an unknown state
    context = multiprocessing.get_context("spawn")
    return ProcessPoolExecutor(workers, mp_context=context)
