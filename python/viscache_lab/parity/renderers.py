"""Both renderers on one file: viscache's loader and frames, Mitsuba 3's loader and frames."""

from __future__ import annotations

import importlib
import importlib.util
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

import viscache as vc

FloatImage = npt.NDArray[np.float32]

#: Samples of lights per eye point. More samples per pixel serve edges as well as lights.
SAMPLES = vc.Direct(n_area=2, n_environment=2, n_brdf=2)


@dataclass(kw_only=True, slots=True)
class Loaded:
    """A file in one of the renderers: the picture of a number of samples and a seed, or None if it
    was refused; and what the loader said.
    """

    render: Callable[[int, int], FloatImage] | None = None
    warnings: list[str] = field(default_factory=list)


def missing() -> str | None:
    """Why Mitsuba 3 cannot be asked; None if it can."""
    if importlib.util.find_spec("mitsuba") is None:
        return "Mitsuba 3 is not installed: pip install mitsuba"
    return None


@contextmanager
def mitsuba(threads: int | None = None) -> Iterator[Any]:
    """Mitsuba 3 in its scalar variant.

    That variant is in every wheel, needs no LLVM, and has the colours of RGB files as they are.
    """
    mi: Any = importlib.import_module("mitsuba")
    dr: Any = importlib.import_module("drjit")
    before, threads_before = mi.variant(), dr.thread_count()
    mi.set_variant("scalar_rgb")
    if threads is not None:
        # Mitsuba reads EXR files in threads beside its own: with one thread it would wait for ever
        dr.set_thread_count(max(2, threads))
    try:
        yield mi
    finally:
        dr.set_thread_count(threads_before)
        if before is not None:
            mi.set_variant(before)


def load_viscache(path: Path, threads: int | None = None) -> Loaded:
    """The file by viscache: direct light by exact rays."""
    try:
        # The prepared copy of a shared scene names files of the scene itself
        scene = vc.load_scene(path, allow_outside=True)
    except (ValueError, OSError, MemoryError) as error:
        return Loaded(warnings=[brief(str(error), path)])

    def picture(spp: int, seed: int) -> FloatImage:
        return vc.render(scene, SAMPLES, spp=spp, seed=seed, threads=threads).image

    return Loaded(render=picture, warnings=[brief(text, path) for text in scene.warnings])


def load_mitsuba(mi: Any, path: Path) -> Loaded:
    """The file by Mitsuba 3's own loader, with its integrator of direct light."""
    with _kept_log(mi) as log:
        try:
            scene = mi.load_file(str(path), parallel=False)
        except (RuntimeError, ValueError, TypeError, KeyError) as error:
            return Loaded(warnings=[brief(str(error), path)])
    integrator = mi.load_dict(_integrator(path))

    def picture(spp: int, seed: int) -> FloatImage:
        # Its seeds are apart from ours, and at most one sample of each light per sample
        with _kept_log(mi):
            made = mi.render(scene, integrator=integrator, spp=spp, seed=1000 + seed)
        return np.asarray(made, np.float32)[:, :, :3]

    return Loaded(render=picture, warnings=[brief(text, path) for text in log])


def _integrator(path: Path) -> dict[str, Any]:
    """`direct`, and for masks `volpath`.

    `direct` and `path` take a masked surface for opaque in shadow rays and count it as a bounce.
    `volpath` sees through it; with one scattering it is direct light as well.
    """
    masked = re.search(r'type\s*=\s*"(mask|null)"', path.read_text("utf-8"))
    return {"type": "volpath", "max_depth": 2, "rr_depth": 1000} if masked else {"type": "direct"}


@contextmanager
def _kept_log(mi: Any) -> Iterator[list[str]]:
    """Keeps Mitsuba's warnings instead of printing them."""
    kept: list[str] = []

    def append(_: Any, level: Any, text: str) -> None:
        kept.append(re.sub(r"^[-\d]+ [:\d]+ \w+ +", "", text))

    quiet = type("Kept", (mi.Appender,), {"append": append, "log_progress": lambda *_: None})()
    logger = mi.logger()
    before = [logger.appender(i) for i in range(logger.appender_count())]
    level = logger.log_level()
    logger.clear_appenders()
    logger.add_appender(quiet)
    logger.set_log_level(mi.LogLevel.Warn)
    try:
        yield kept
    finally:
        logger.set_log_level(level)
        logger.clear_appenders()
        for appender in before:
            logger.add_appender(appender)


def brief(text: str, path: Path) -> str:
    """One line without the folder of the file."""
    return " ".join(text.replace(f"{path.parent}/", "").split())
