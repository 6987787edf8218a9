"""Functions shared by sub-commands: printing, sizes, settings from options."""

from __future__ import annotations

import argparse
import json
import sys
from concurrent.futures import Executor
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

from viscache.base import workers
from viscache.base.files import finite
from viscache.base.provenance import thread_count
from viscache.scene import Scene
from viscache.scenes.sources import open_scene
from viscache.settings import by_name


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


def chosen_settings(arguments: argparse.Namespace) -> dict[by_name.Role, Any]:
    """Integrator, rays and visibility from the options, with `--set` applied."""
    rays, visibility = arguments.rays, arguments.visibility
    if visibility in by_name.RAYS_AS_VISIBILITY:
        if rays not in ("embree", visibility):
            raise ValueError(
                f"--visibility {visibility} is short for --rays, got --rays {rays} too"
            )
        rays, visibility = visibility, "exact"
    chosen: dict[by_name.Role, Any] = {
        "integrator": by_name.make("integrator", arguments.integrator),
        "rays": by_name.make("rays", rays),
        "visibility": by_name.make("visibility", visibility),
    }
    return by_name.assign(chosen, arguments.set)


def add_scene(parser: argparse.ArgumentParser) -> None:
    """`SCENE`, `--missing` and `--allow-outside`."""
    parser.add_argument("scene", metavar="SCENE", help="a file, or a built-in name with parameters")
    add_loading(parser)


def add_loading(parser: argparse.ArgumentParser) -> None:
    """`--missing` and `--allow-outside`: how a scene file is read."""
    parser.add_argument(
        "--missing",
        choices=("error", "skip"),
        default="error",
        help="skip: leave out shapes whose mesh file is not there (default: error)",
    )
    parser.add_argument(
        "--allow-outside",
        action="store_true",
        help="the scene may read files outside of its folder",
    )


def chosen_scene(arguments: argparse.Namespace) -> Scene:
    """The scene chosen by the options of `add_scene`."""
    return open_scene(
        arguments.scene,
        missing=arguments.missing,
        allow_outside=arguments.allow_outside,
        progress=sys.stderr.isatty(),
    )


def add_shot(parser: argparse._ActionsContainer) -> None:
    """What calls have in common beside the scene and the settings' names; see `viscache.Shot`."""
    parser.add_argument(
        "--use", choices=["replace", "correct"], help="how an approximation is used"
    )
    parser.add_argument(
        "--set",
        metavar="NAME=VALUE",
        action="append",
        default=[],
        help="a parameter by its symbol: c_e=8, integrator.n_vpls=256",
    )
    parser.add_argument("--size", type=size, metavar="WxH", help="pixels; the camera's by default")
    parser.add_argument("--spp", type=at_least_one, help="samples per pixel (1)")
    parser.add_argument("--seed", type=int, help="of the samples (0)")
    parser.add_argument("--threads", type=at_least_one)
    parser.add_argument("--camera", metavar="NAME", help="name or index")
    parser.add_argument(
        "--env", type=_environment, metavar="FILE", help="environment light; a number: constant"
    )


def chosen_shot(arguments: argparse.Namespace) -> dict[str, Any]:
    """Those of the options of `add_shot` that were given, but `--set`; by the calls' names."""
    names = ("use", "size", "spp", "seed", "threads", "camera", "env")
    given = {name: getattr(arguments, name) for name in names}
    return {name: value for name, value in given.items() if value is not None}


def _environment(text: str) -> str | float:
    """A file, or constant radiance."""
    try:
        return text if Path(text).exists() else float(text)
    except ValueError:
        return text


def add_workers(parser: argparse.ArgumentParser) -> None:
    """`--workers N` and `--dask ADDRESS`."""
    which = parser.add_mutually_exclusive_group()
    which.add_argument(
        "--workers",
        type=at_least_one,
        default=1,
        metavar="N",
        help="processes; they disturb each other's timings",
    )
    which.add_argument("--dask", metavar="ADDRESS", help="the workers of a dask scheduler")


def chosen_executor(arguments: argparse.Namespace) -> AbstractContextManager[Executor | None]:
    """The executor chosen by the options of `add_workers`; None: this process."""
    if arguments.dask is not None:
        return workers.dask_executor(arguments.dask)
    return workers.process_pool(arguments.workers)


def threads_of_a_worker(arguments: argparse.Namespace) -> int | None:
    """Threads per worker process on this machine; None for a single or a remote worker."""
    if arguments.workers == 1:
        return None
    return max(1, thread_count() // int(arguments.workers))
