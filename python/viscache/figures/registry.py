"""Which figures and tables there are, and reproducing one of them."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

from viscache.figures import (
    aqvc_claims,
    aqvc_clusters,
    aqvc_edges,
    aqvc_hairball,
    aqvc_maps,
    aqvc_nee,
    aqvc_pictures,
    aqvc_quality,
    aqvc_sweeps,
    aqvc_temporal,
    references,
    vlf_axes,
    vlf_drawings,
    vlf_frames,
    vlf_objects,
    vlf_occlusion,
    vlf_sweeps,
)
from viscache.figures.code import code_hash
from viscache.figures.outcome import Outcome, text
from viscache.figures.vismap_ambient import figure10
from viscache.figures.vismap_animation import temporal
from viscache.figures.vismap_correlation import figure3, figure4
from viscache.figures.vismap_equal_time import figure1, figure13
from viscache.figures.vismap_preview import figure11
from viscache.figures.vismap_records import figure8, figure12, table2
from viscache.figures.vismap_sweep import sweep
from viscache.figures.vismap_table3 import table3
from viscache.figures.vismap_weights import figure5
from viscache.json_values import finite
from viscache.provenance import provenance
from viscache.settings.by_name import nearest

__all__ = ["FIGURES", "FigureInfo", "reproduce"]

#: Takes the folder to write to, `quick`, whether to show progress, and `size=` where sized.
Figure: TypeAlias = Callable[..., Outcome]


@dataclass(frozen=True, kw_only=True, slots=True)
class FigureInfo:
    """One figure or table of the papers, or one of ours beside them."""

    description: str
    function: Figure
    sized: bool = False
    """Whether its pictures can be rendered at another size."""


#: Name to figure, in the order of the papers.
FIGURES: dict[str, FigureInfo] = {
    "aqvc-fig2": FigureInfo(
        description="cells that follow normals and footprints",
        function=aqvc_clusters.figure2,
        sized=True,
    ),
    "aqvc-fig3": FigureInfo(
        description="shadow edges with and without refinement",
        function=aqvc_edges.figure3,
        sized=True,
    ),
    "aqvc-fig4": FigureInfo(
        description="scan order shifts shadows", function=aqvc_edges.figure4, sized=True
    ),
    "aqvc-fig5": FigureInfo(
        description="exact and cached images, amplified difference",
        function=aqvc_pictures.figure5,
        sized=True,
    ),
    "aqvc-fig6": FigureInfo(
        description="fine geometry", function=aqvc_hairball.figure6, sized=True
    ),
    "aqvc-fig7": FigureInfo(
        description="ray reduction, speed-up and quality over C_E",
        function=aqvc_sweeps.figure7,
        sized=True,
    ),
    "aqvc-fig8": FigureInfo(
        description="comparison with shadow maps", function=aqvc_maps.figure8, sized=True
    ),
    "aqvc-claims": FigureInfo(
        description="numbers in the text of the quantized cache's paper",
        function=aqvc_claims.claims,
        sized=True,
    ),
    "aqvc-quality": FigureInfo(
        description="quality choices of the quantized cache: normals, grids, refinement",
        function=aqvc_quality.quality,
        sized=True,
    ),
    "aqvc-nee": FigureInfo(
        description="rays and error beside Next Event Estimation++",
        function=aqvc_nee.comparison,
        sized=True,
    ),
    "aqvc-temporal": FigureInfo(
        description="tables kept over frames or dropped: rays, flicker and stale bits",
        function=aqvc_temporal.temporal,
        sized=True,
    ),
    "vlf-fig1": FigureInfo(
        description="tiles of an edge: supercover against DDA", function=vlf_drawings.figure1
    ),
    "vlf-fig2": FigureInfo(
        description="rays over one and several tiles", function=vlf_drawings.figure2
    ),
    "vlf-fig3": FigureInfo(
        description="linear traversal of a tile's leaves", function=vlf_drawings.figure3
    ),
    "vlf-fig4": FigureInfo(
        description="the scenes of random triangles", function=vlf_frames.figure4
    ),
    "vlf-fig5": FigureInfo(
        description="frame time over the number of triangles", function=vlf_frames.figure5
    ),
    "vlf-fig6": FigureInfo(
        description="frame times of a walk through a classroom", function=vlf_frames.figure6
    ),
    "vlf-fig7": FigureInfo(description="the classroom", function=vlf_frames.figure7),
    "vlf-fig8": FigureInfo(
        description="images with ambient occlusion", function=vlf_occlusion.figure8
    ),
    "vlf-tab1": FigureInfo(
        description="ambient occlusion: seconds and speed-up of five scenes",
        function=vlf_occlusion.table1,
    ),
    "vlf-x1": FigureInfo(
        description="speed, tests and memory over directions, tiles and depth",
        function=vlf_sweeps.x1,
    ),
    "vlf-x2": FigureInfo(
        description="error of ambient occlusion over the number of directions",
        function=vlf_axes.x2,
    ),
    "vlf-x3": FigureInfo(
        description="memory of a field, foretold and used", function=vlf_sweeps.x3
    ),
    "vlf-x4": FigureInfo(
        description="the aligned batch against Embree over points per triangle",
        function=vlf_axes.x4,
    ),
    "vlf-x5": FigureInfo(
        description="an object that moves: time of an update against a rebuild",
        function=vlf_objects.x5,
    ),
    "vismap-fig1": FigureInfo(
        description="an occluded glossy surface, with and without the control variate",
        function=figure1,
    ),
    "vismap-fig3": FigureInfo(
        description="correlation over distance and angle in one scene, with slices",
        function=figure3,
    ),
    "vismap-fig4": FigureInfo(
        description="correlation in four scenes, with maps of the scenes", function=figure4
    ),
    "vismap-fig5": FigureInfo(description="the weighting function", function=figure5),
    "vismap-fig8": FigureInfo(description="positions of the records", function=figure8),
    "vismap-fig10": FigureInfo(
        description="ambient occlusion, reference and cached", function=figure10
    ),
    "vismap-fig12": FigureInfo(description="records in the garden scene", function=figure12),
    "vismap-tab2": FigureInfo(
        description="records, resolutions and rays per pixel of three scenes", function=table2
    ),
    "vismap-fig11": FigureInfo(
        description="the control variate's integral as a preview", function=figure11
    ),
    "vismap-fig13": FigureInfo(
        description="equal-time comparison, with the crops of figure 14", function=figure13
    ),
    "vismap-tab3": FigureInfo(
        description="variance ratios and overhead over the number of samples", function=table3
    ),
    "vismap-sweep": FigureInfo(
        description="variance, rays and bytes over the cache's parameters", function=sweep
    ),
    "vismap-temporal": FigureInfo(
        description="records and misses over the frames of a moving scene", function=temporal
    ),
}


def reproduce(
    name: str,
    directory: str | os.PathLike[str],
    *,
    quick: bool = False,
    progress: bool = False,
    size: tuple[int, int] | None = None,
) -> dict[str, Any]:
    """Reproduce one figure or table of the papers.

    Parameters
    ----------
    name : str
        One of `FIGURES`.
    directory : path
        Made where missing. Gets the picture, `NAME.md` with the table and `NAME.json`.
    quick : bool
        Small sizes: seconds instead of minutes.
    progress : bool
        Show a bar.
    size : (width, height), optional
        Of the rendered pictures in pixels, for the figures that allow it.

    Returns
    -------
    dict
        What `viscache reproduce NAME --json` prints: figure, rows (what, printed, measured, ratio,
        band, holds, note), files; beside them holds, skipped, notes, quick, provenance.

    Raises
    ------
    ValueError
        An unknown name, with the nearest known one; a size where it has no effect.
    """
    if name not in FIGURES:
        raise ValueError(f"unknown figure {name!r}{nearest(name, FIGURES)}")
    function = FIGURES[name].function
    if size is not None and not FIGURES[name].sized:
        sized = ", ".join(n for n, info in FIGURES.items() if info.sized)
        raise ValueError(f"size must be left out for {name}; it is for {sized}")
    folder = Path(directory)
    folder.mkdir(parents=True, exist_ok=True)
    given = {} if size is None else {"size": size}
    began, cpu = time.perf_counter(), time.process_time()
    with references.kept_in(folder / "references", code_hash()):
        outcome = function(folder, quick, progress, **given)
    seconds, cpu = time.perf_counter() - began, time.process_time() - cpu
    table, record = folder / f"{name}.md", folder / f"{name}.json"
    table.write_text(text(name, outcome.rows), encoding="utf-8")
    result = {
        "figure": name,
        "rows": [row.as_dict() for row in outcome.rows],
        "files": [str(path) for path in [*outcome.files, table, record]],
        "holds": all(row.holds is not False for row in outcome.rows),
        "skipped": outcome.skipped,
        "notes": outcome.notes,
        "quick": quick,
        "size": None if size is None else list(size),
        "provenance": provenance(),
        "code": code_hash(),
        "seconds": seconds,
        "cpu_s": cpu,
    }
    record.write_text(json.dumps(finite(result), indent=2), encoding="utf-8")
    return result
