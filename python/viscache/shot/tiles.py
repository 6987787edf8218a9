"""One frame rendered in parts, by this process or by an executor's workers.

A tile depends only on itself and on the frame's shared lights, so a frame in parts has the same
bytes as a frame in one piece. The cost of a part is that it traces the shared lights again.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, as_completed
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from viscache.base import workers
from viscache.frame import Frame
from viscache.frame.frame import Layer
from viscache.scene import Scene
from viscache.settings.audit import Audit
from viscache.settings.checks import is_whole, require
from viscache.settings.spelling import spelled
from viscache.shot.audited import audit_record, error_warnings, joined
from viscache.shot.exact_cost import cost_warnings
from viscache.shot.render import render_part
from viscache.shot.shot import BareShot, ShotArguments, lit_here, of_shot, require_same

if TYPE_CHECKING:
    from typing_extensions import Unpack

__all__ = ["Part", "cut", "merge", "render", "tile_boxes"]

#: Parts of a frame without an executor: the number of live views.
PARTS_HERE = 16


@dataclass(frozen=True, kw_only=True, slots=True)
class Part:
    """Tiles `number`, `number + parts`, `number + 2 parts`, ... of a frame.

    Attributes
    ----------
    cuts : list of dict of str to (H, W, C) float32
        The layers of each tile.
    frame : Frame
        Without pixels.
    shows : dict
        `Shot.parts`; empty for parts that are not merged.
    """

    number: int
    parts: int
    size: tuple[int, int]
    cuts: list[dict[str, Layer]]
    frame: Frame
    shows: dict[str, Any] = field(default_factory=dict)

    @property
    def boxes(self) -> list[tuple[int, int, int, int]]:
        """(x0, y0, x1, y1) of each tile, in pixels."""
        edge = int(self.frame.parameters["tile_edge_px"])
        return tile_boxes(self.size, edge, self.number, self.parts)


@spelled
@of_shot()
def render(
    scene: Scene | str | os.PathLike[str],
    integrator: Any = None,
    *,
    executor: Executor | None = None,
    parts: int | None = None,
    show: Callable[[Frame, int, int], None] | None = None,
    audit: Audit | Literal["pixels", "queries"] | None = None,
    **shot: Unpack[ShotArguments],
) -> Frame:
    """Render a frame in parts; the same bytes as `viscache.render`.

    Parameters
    ----------
    scene : Scene, path or str
        With an executor, every worker loads a scene that has a spec once. Other scenes are sent
        with their arrays.
    integrator : Direct, Whitted or AmbientOcclusion (its directions not shared)
    executor : concurrent.futures.Executor, optional
        Renders the parts; this process by default.
    parts : int >= 1, optional
        Twice as many as workers by default.
    show : callable, optional
        Called after each part with the unfinished frame, the number of finished parts and the
        number of parts: a live view.
    audit : AuditPixels, AuditQueries, "pixels" or "queries", optional
        As `viscache.render` takes it.
    visibility : Exact, Aqvc or another one whose tiles are independent
    use, rays, size, spp, seed, threads, camera, env
        See `viscache.Shot`.

    Returns
    -------
    Frame
        Counters are the same as of a frame in one piece, but every part draws audited pixels of its
        own. Timings are sums over parts.

    Raises
    ------
    ValueError
        As `viscache.render`; or tiles depend on each other, or on a cache of several frames.
    """
    n = parts or (PARTS_HERE if executor is None else workers.window(executor))
    require(is_whole(n) and 1 <= n <= 1 << 16, "parts must be in [1, 65536]", n)
    tasks = [(number, int(n)) for number in range(int(n))]
    done: list[Part | None] = [None] * int(n)
    wanted = BareShot(scene, integrator, **shot)
    if executor is None:
        source = _parts_here(wanted, tasks, audit)
    else:
        source = _parts_there(executor, wanted, tasks, audit)
    for finished, part in enumerate(source, 1):
        done[part.number] = part
        if show is not None:
            show(merge([p for p in done if p is not None], partial=True), finished, int(n))
    return merge([p for p in done if p is not None])


def merge(parts: list[Part], *, partial: bool = False) -> Frame:
    """Join parts to a frame. Their order does not matter.

    Raises
    ------
    ValueError
        A part is missing (unless `partial`), was given twice, or is of another picture.
    """
    require(bool(parts), "parts must hold at least one", parts)
    ordered = sorted(parts, key=lambda part: part.number)
    numbers = [part.number for part in ordered]
    wanted = list(range(ordered[0].parts))
    whole = numbers == wanted or (partial and len(set(numbers)) == len(numbers))
    require(whole, f"parts must be all of {len(wanted)}, each once", numbers)
    first = ordered[0]
    for part in ordered:
        require_same(first.shows, part.shows, "in all parts")
    width, height = first.size
    layers = {
        name: np.zeros((height, width, pixels.shape[2]), np.float32)
        for name, pixels in first.frame.layers.items()
    }
    for part in ordered:
        for (x0, y0, x1, y1), pieces in zip(part.boxes, part.cuts, strict=True):
            for name, pixels in pieces.items():
                layers[name][y0:y1, x0:x1] = pixels
    return _joined(ordered, layers)


def tile_boxes(
    size: tuple[int, int], edge: int, number: int, parts: int
) -> list[tuple[int, int, int, int]]:
    """(x0, y0, x1, y1) of the tiles of a part, in pixels (`tiles_of_part` of the core)."""
    width, height = size
    columns = math.ceil(width / edge)
    total = columns * math.ceil(height / edge)
    return [
        (x, y, min(x + edge, width), min(y + edge, height))
        for i in range(number, total, parts)
        for x, y in [(i % columns * edge, i // columns * edge)]
    ]


def _parts_here(shot: BareShot, tasks: list[tuple[int, int]], audit: Any) -> Iterator[Part]:
    here = lit_here(shot, shot.opened)
    for number, parts in tasks:
        yield cut(render_part(here, (number, parts), audit=audit), number, parts, shot.parts)


def _parts_there(
    executor: Executor, shot: BareShot, tasks: list[tuple[int, int]], audit: Any
) -> Iterator[Part]:
    flying: list[Future[Part]] = []
    try:
        for task in tasks:
            flying.append(executor.submit(render_in_worker, shot, task, audit))
        for future in as_completed(flying):
            yield future.result()
    finally:
        for future in flying:
            future.cancel()


def render_in_worker(shot: BareShot, task: tuple[int, int], audit: Any = None) -> Part:
    """Render one part."""
    return cut(render_part(lit_here(shot), task, audit=audit), *task, shot.parts)


def cut(frame: Frame, number: int, parts: int, shows: dict[str, Any] | None = None) -> Part:
    """The tiles of a part, cut out of a frame that shows this."""
    size = frame.size
    boxes = tile_boxes(size, int(frame.parameters["tile_edge_px"]), number, parts)
    cuts = [
        {n: np.ascontiguousarray(p[y0:y1, x0:x1]) for n, p in frame.layers.items()}
        for x0, y0, x1, y1 in boxes
    ]
    frame.layers = {n: np.zeros((1, 1, p.shape[2]), np.float32) for n, p in frame.layers.items()}
    return Part(number=number, parts=parts, size=size, cuts=cuts, frame=frame, shows=shows or {})


def _joined(parts: list[Part], layers: dict[str, Layer]) -> Frame:
    first = parts[0].frame
    counters: dict[str, Any] = {}
    for part in parts:
        _add(counters, {n: c for n, c in part.frame.counters.items() if n != "audit_found"})
    numbered = [
        (part.number + i * part.parts, tile)
        for part in parts
        for i, tile in enumerate(part.frame.counters.get("tile_sums", []))
    ]
    sums = [tile for _, tile in sorted(numbered, key=lambda pair: pair[0])]
    counters.pop("tile_sums", None)
    counters["vpls"] = first.counters["vpls"]
    rays = counters["rays"]
    counters["ray_reduction"] = counters["queries"] / rays if rays else 0.0
    if sums:  # tile by tile, in the order of a frame in one piece
        width, height = parts[0].size
        total: dict[str, Any] = {}
        for of_tile in sums:
            _add(total, of_tile)
        samples = float(width) * height * first.parameters["spp"]
        counters |= {
            "lost_throughput": total["lost_throughput"] / samples,
            "expected_false_hits": total["expected_false_hits"],
        }
    timings: dict[str, float] = {}
    for part in parts:
        for name, seconds in part.frame.timings.items():
            timings[name] = timings.get(name, 0.0) + seconds
    parameters = {k: v for k, v in first.parameters.items() if k != "part"}
    # A process whose scene has the tree of shafts may use it where another has none
    engines = [p.frame.parameters["engine"] for p in parts if "engine" in p.frame.parameters]
    if engines:
        work: dict[str, Any] = {}
        for engine in engines:
            _add(work, engine)
        parameters["engine"] = engines[0] | work
    made = Frame(
        layers=layers,
        counters=counters,
        timings=timings,
        parameters=parameters,
        provenance=first.provenance,
        warnings=first.warnings,
    )
    found = [p.frame.counters["audit_found"] for p in parts if "audit_found" in p.frame.counters]
    if found and len(parts) == parts[0].parts:
        made.counters["audit"] = audit_record(joined(found), made)
    made.warnings = made.warnings + cost_warnings(parameters, counters) + error_warnings(made)
    made.counters["sha256"] = made.sha256
    return made


def _add(total: dict[str, Any], more: dict[str, Any]) -> None:
    """Add counters, group by group and level by level."""
    for name, value in more.items():
        if isinstance(value, dict):
            _add(total.setdefault(name, {}), value)
        elif isinstance(value, list) and name != "tile_sums":
            known = total.setdefault(name, [])
            known += [0] * (len(value) - len(known))
            for i, count in enumerate(value):
                known[i] += count
        elif isinstance(value, (int, float)):
            total[name] = total.get(name, 0) + value
