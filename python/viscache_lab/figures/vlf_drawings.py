"""Figures 1 to 3 of the visibility field's paper: tiles of edges; tiles and leaves of rays."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

import viscache as vc
from viscache.plots.drawing import new_figure
from viscache.vlf.tiles import cover_tiles, walk_leaves, walk_tiles
from viscache_lab.experiment import FIGURES, Row, Trial
from viscache_lab.figures.bands import vlf as bands

Array = npt.NDArray[Any]
TILES = 16
EDGES, QUICK_EDGES = 2000, 300
CHORDS, QUICK_CHORDS = 2000, 300
#: Largest distance of a listed tile from its edge: twice the growth of the coverage.
NEAR = 2e-5


@FIGURES.add("vlf-fig1", "tiles of an edge: supercover against DDA")
def figure1(trial: Trial) -> None:
    """Tiles of an edge: supercover against DDA."""
    rng = np.random.default_rng(1)
    edges = rng.uniform(-1, 1, (QUICK_EDGES if trial.quick else EDGES, 2, 2)).astype(np.float32)
    missed = extra = 0
    shares = []
    for a, b in edges:
        touched, listed = touched_tiles(a, b), supercover(a, b)
        missed += len(touched - listed)
        extra += sum(not _near(a, b, tile) for tile in listed - touched)
        shares.append(len(touched - dda(a, b)) / len(touched))
    rows = [
        Row(
            "share of touched tiles a DDA misses",
            float(np.mean(shares)),
            band=bands.DDA_MISSES,
            note=f"{len(edges)} random edges, {TILES}x{TILES} tiles",
        ),
        Row("edges with missed tiles, DDA", float(np.mean(np.array(shares) > 0))),
        Row("touched tiles the supercover misses", missed, band=bands.SUPERCOVER_ERRORS),
        Row("tiles it lists that the edge does not touch", extra, band=bands.SUPERCOVER_ERRORS),
    ]
    trial.rows += rows
    trial.save(_draw_edges(), "vlf-fig1.png")


def supercover(a: Array, b: Array) -> set[tuple[int, int]]:
    """The tiles that the field lists for an edge."""
    corners = np.zeros((1, 3, 3), np.float32)
    corners[0, 0, :2], corners[0, 1:, :2] = a, b
    return {(int(x), int(y)) for _, x, y in cover_tiles(corners, TILES)[0]}


def dda(a: Array, b: Array) -> set[tuple[int, int]]:
    """The tiles of a digital differential analyser: one per step along the longer axis."""
    p, q = (np.asarray(v, float) * TILES / 2 + TILES / 2 for v in (a, b))
    steps = max(1, int(np.ceil(np.abs(q - p).max())))
    at = p + (q - p) * (np.arange(steps + 1) / steps)[:, None]
    return {(int(x), int(y)) for x, y in np.clip(at, 0, TILES - 1)}


def touched_tiles(a: Array, b: Array) -> set[tuple[int, int]]:
    """The tiles whose interior the edge crosses, from its crossings with tile borders."""
    p, q = np.asarray(a, float), np.asarray(b, float)
    borders = np.linspace(-1, 1, TILES + 1)
    with np.errstate(divide="ignore", invalid="ignore"):
        t = np.concatenate([(borders - p[k]) / (q - p)[k] for k in range(2)])
    t = np.unique(np.concatenate([[0, 1], t[(t > 0) & (t < 1)]]))
    middle = p + (t[1:] + t[:-1])[:, None] / 2 * (q - p)
    keep = np.diff(t) * np.linalg.norm(q - p) > 1e-6  # shorter: a corner, within rounding
    return {(int(x), int(y)) for x, y in ((middle[keep] + 1) * TILES / 2).astype(int)}


def _near(a: Array, b: Array, tile: tuple[int, int]) -> bool:
    """Whether the edge intersects the tile grown by NEAR."""
    p, d = np.asarray(a, float), np.asarray(b, float) - np.asarray(a, float)
    low, high = 0.0, 1.0
    for k in range(2):
        near, far = 2 * tile[k] / TILES - 1 - NEAR, 2 * (tile[k] + 1) / TILES - 1 + NEAR
        if d[k] == 0:
            if not near <= p[k] <= far:
                return False
            continue
        s, e = sorted(((near - p[k]) / d[k], (far - p[k]) / d[k]))
        low, high = max(low, s), min(high, e)
    return low <= high


def _draw_edges() -> Any:
    corners = np.array([[-0.82, -0.55], [0.75, -0.2], [-0.1, 0.83]])
    figure = new_figure(8.0, 4.2)
    for column, (title, cover) in enumerate((("DDA", dda), ("every tile touched", supercover))):
        axes = figure.add_subplot(1, 2, column + 1)
        shown: set[tuple[int, int]] = set()
        touched: set[tuple[int, int]] = set()
        for k in range(3):
            shown |= cover(corners[k], corners[(k + 1) % 3])
            touched |= touched_tiles(corners[k], corners[(k + 1) % 3])
        for tiles, color in ((shown, "0.75"), (touched - shown, "tab:red")):
            for x, y in tiles:
                square = ((2 * x / TILES - 1, 2 * y / TILES - 1), 2 / TILES, 2 / TILES)
                axes.add_patch(_rectangle(*square, color))
        axes.plot(*np.concatenate([corners, corners[:1]]).T, "k-", lw=1)
        axes.set_xticks(np.linspace(-1, 1, TILES + 1), labels=[])
        axes.set_yticks(np.linspace(-1, 1, TILES + 1), labels=[])
        axes.grid(lw=0.4)
        axes.set(xlim=(-1, 1), ylim=(-1, 1), aspect="equal", title=title)
    return figure


def _rectangle(corner: tuple[float, float], width: float, height: float, color: str) -> Any:
    from matplotlib.patches import Rectangle

    return Rectangle(corner, width, height, facecolor=color, edgecolor="none")


@FIGURES.add("vlf-fig2", "rays over one and several tiles")
def figure2(trial: Trial) -> None:
    """Rays that cross one tile, and several."""
    n = QUICK_CHORDS if trial.quick else CHORDS
    rng = np.random.default_rng(2)
    rows = [Row("tiles of a ray along the axis", _aligned_tiles(rng, n), band=bands.ALIGNED_TILES)]
    for count, band in bands.CHORD_TILES.items():
        rows.append(
            Row(
                f"tiles of a random chord, {count} directions",
                _chord_tiles(rng, n, count),
                band=band,
                note="128 tiles, the whole chord",
            )
        )
    trial.rows += rows
    trial.save(_draw_rays(leaves=1), "vlf-fig2.png")


def _aligned_tiles(rng: np.random.Generator, n: int) -> float:
    starts = rng.uniform(-0.99, 0.99, (n, 3))
    most = [len(walk_tiles(tuple(p), (0.0, 0.0, 1.0), 128)[0]) for p in starts.tolist()]
    return float(max(most))


def _chord_tiles(rng: np.random.Generator, n: int, count: int) -> float:
    ends = rng.normal(size=(2, n, 3))
    o, e = ends / np.linalg.norm(ends, axis=2, keepdims=True)
    axis = vc.vlf.nearest_direction((e - o).astype(np.float32), count)
    frames = vc.vlf.direction_frames(count)[axis].astype(float)
    q, g = (np.einsum("nij,nj->ni", frames, v) for v in (o, e - o))
    walks = zip(q.tolist(), g.tolist(), strict=True)
    return float(np.mean([len(walk_tiles(tuple(p), tuple(d), 128, 0.0, 1.0)[0]) for p, d in walks]))


@FIGURES.add("vlf-fig3", "linear traversal of a tile's leaves")
def figure3(trial: Trial) -> None:
    """Leaves of the tiles that a ray crosses, by the linear walk and the walk with a stack."""
    rng = np.random.default_rng(3)
    n = QUICK_CHORDS if trial.quick else CHORDS
    differ, visited, there = 0, 0, 0
    for _ in range(n):
        o, e = rng.uniform(-0.9, 0.9, (2, 3)).tolist()
        d = (np.array(e) - o).tolist()
        _, spans = walk_tiles(tuple(o), tuple(d), TILES, 0.0, 1.0)
        for t_in, t_out in spans:
            depths = o[2] + np.array([t_in, t_out]) * d[2]
            ways = [
                _leaves(float(depths.min()), float(depths.max()), d[2] > 0, how)
                for how in ("linear", "stack")
            ]
            differ += ways[0] != ways[1]
            visited, there = visited + len(ways[0]), there + 8
    rows = [
        Row(
            "tiles whose leaves the two walks visit differently",
            differ,
            band=bands.WALKS_DIFFER,
            note=f"{n} rays, 8 leaves a tile",
        ),
        Row("share of the leaves that are visited", visited / there, band=bands.GREY_LEAVES),
    ]
    trial.rows += rows
    trial.save(_draw_rays(leaves=8), "vlf-fig3.png")


def _leaves(low: float, high: float, upwards: bool, how: str) -> list[int]:
    return list(walk_leaves(-1.0, 1.0, 8, [], low, high, upwards, how))


#: Rays of the drawings, in x and z.
SHOWN = {
    "A": ((-0.7, -0.6), (0.35, 0.75)),
    "B": ((-0.25, 0.7), (0.1, -0.8)),
    "C": ((0.7, -0.75), (0.7, 0.6)),
}


def _draw_rays(leaves: int) -> Any:
    """Draw each ray with the tiles, or the leaves, that it visits."""
    n = 5
    figure = new_figure(9.0, 3.4)
    for column, (name, (o, e)) in enumerate(SHOWN.items()):
        axes = figure.add_subplot(1, len(SHOWN), column + 1)
        for x in np.linspace(-1, 1, n + 1):
            axes.plot([x, x], [-1, 1], color="0.5", lw=0.8)
        for z in np.linspace(-1, 1, leaves + 1)[1:-1]:
            axes.plot([-1, 1], [z, z], color="0.8", lw=0.6)
        d = np.subtract(e, o)
        tiles, spans = walk_tiles((o[0], 0.0, o[1]), (d[0], 0.0, d[1]), n, 0.0, 1.0)
        for (tile, _), (t_in, t_out) in zip(tiles, spans, strict=True):
            for low, height in _visited(o[1] + np.array([t_in, t_out]) * d[1], d[1] > 0, leaves):
                axes.add_patch(_rectangle((2 * tile / n - 1, low), 2 / n, height, "0.8"))
        axes.annotate("", xy=e, xytext=o, arrowprops={"arrowstyle": "->", "lw": 1.4})
        axes.set(
            xlim=(-1, 1),
            ylim=(-1, 1),
            aspect="equal",
            title=f"ray {name}",
            xlabel="tiles 1 to 5",
            ylabel="along the beams",
        )
        axes.set_xticks([]), axes.set_yticks([])
    return figure


def _visited(depths: Array, upwards: bool, leaves: int) -> list[tuple[float, float]]:
    """Lower ends and heights of a tile's leaves at the given depths."""
    if leaves == 1:
        return [(-1.0, 2.0)]
    found = _leaves(float(depths.min()), float(depths.max()), upwards, "linear")
    return [(2 * leaf / leaves - 1, 2 / leaves) for leaf in found]
