"""The visibility cache in an animation: records, misses and variance (not in the paper).

The paper shows this in a video. A camera swings through the garage while a crate slides across the
floor, into the light and out again.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

import viscache as vc
from viscache.base.progress import step_bar
from viscache.plots import COLORS
from viscache.scenes import SCENES
from viscache.scenes.shapes import place, soft_box
from viscache_lab.cases.light_product import (
    LUMINANCE,
    drawn_texels,
    environment_texels,
    first_hits,
    reflected,
)
from viscache_lab.cases.map_renders import variance_left
from viscache_lab.cases.simulation import Way, simulate
from viscache_lab.experiment import FIGURES, Row, Trial
from viscache_lab.experiment.drawing import Panel, Series
from viscache_lab.figures.bands import vismap as bands

#: Frames, size of the pictures, and numbers of pixels estimated and compared with exact rays.
FRAMES, SIZE, PIXELS, COMPARED = 60, (320, 240), 64, 256
QUICK_FRAMES, QUICK_SIZE, QUICK_PIXELS, QUICK_COMPARED = 20, (80, 60), 12, 64
TRIANGLES = 60_000
#: Light-product rays per compared pixel.
RAYS = 64
PRODUCT, PAPER = Way(), Way(alpha=1.0)


@dataclass(frozen=True, kw_only=True, slots=True)
class Frame:
    """Results of one frame."""

    records: int
    inserted: int
    wrong: int
    """Records removed for their errors."""
    unused: int
    miss_share: float
    ratio: float


@FIGURES.add("vismap-temporal", "records and misses over the frames of a moving scene")
def temporal(trial: Trial) -> None:
    """Records, misses and variance ratio per frame."""
    size, n_frames = (QUICK_SIZE, QUICK_FRAMES) if trial.quick else (SIZE, FRAMES)
    pixels = (QUICK_PIXELS, QUICK_COMPARED) if trial.quick else (PIXELS, COMPARED)
    trial.row(
        "records inserted in a second frame in which nothing moves",
        _inserted_again(size),
        band=bands.NOTHING_NEW,
    )
    frames: list[Frame] = []
    cache = vc.VisibilityMapCache(crate_and_garage(0.0), vc.MapSettings())
    with step_bar(trial.progress, n_frames, unit="frame") as step:
        for k in range(n_frames):
            frames.append(_frame(cache, k / n_frames, size, *pixels))
            step()
    trial.rows += _rows(frames)
    trial.draw("vismap-temporal.png", [_panels(frames)], (12.0, 3.4), dpi=150)


def crate_and_garage(t: float) -> vc.Scene:
    """The garage with a crate that slides from the camera's left to its right, t in [0, 1]."""
    b = SCENES["garage"].builder(triangles=TRIANGLES)
    vertices, triangles = soft_box((0.9, 0.9, 0.9), (6, 6, 6), power=14, bulge=0.05).mesh(1.0)
    at = place([9.6, 0.46, 6.6 - 5.0 * t], yaw=60.0 * t)
    b.add_mesh(vertices @ at[:3, :3].T + at[:3, 3], triangles, b.diffuse("crate", (0.6, 0.5, 0.3)))
    return vc.Scene.from_description(b.description)


def swinging_camera(t: float) -> vc.Camera:
    """One swing to and fro before the gate."""
    swing = math.sin(2 * math.pi * t)
    return vc.look_at((11.7, 1.85, 4.2 + 1.4 * swing), (4.0, 0.4, 3.6 - 0.5 * swing), fov_deg=54.0)


def _inserted_again(size: tuple[int, int]) -> int:
    cache = vc.VisibilityMapCache(crate_and_garage(0.0), vc.MapSettings())
    cache.update(swinging_camera(0.0), size=size)
    return cache.update(swinging_camera(0.0), size=size).inserted


def _frame(
    cache: vc.VisibilityMapCache, t: float, size: tuple[int, int], pixels: int, compared: int
) -> Frame:
    """Update, estimate, compare the records with exact rays, remove."""
    view, scene = swinging_camera(t), crate_and_garage(t)
    report = cache.update(view, size=size, scene=scene)
    made = simulate(
        cache,
        [PRODUCT, PAPER],
        [10],
        camera=view,
        size=size,
        n_pixels=pixels,
        replicates=32,
        seed=cache.frame,
    )
    rays, misses = _compare(cache, view, size, compared)
    removed = cache.end_frame()
    return Frame(
        records=len(cache),
        inserted=report.inserted,
        wrong=removed["wrong"],
        unused=removed["unused"],
        miss_share=misses / max(rays, 1),
        ratio=variance_left(made, PAPER, PRODUCT, 10).ratio,
    )


def _compare(
    cache: vc.VisibilityMapCache, view: vc.Camera, size: tuple[int, int], pixels: int
) -> tuple[int, int]:
    """Count how often records contradict exact light-product rays of random pixels."""
    scene = cache.scene
    directions, texels = environment_texels(scene)
    radiance = texels.reshape(-1, 3).astype(float)
    hits = first_hits(scene, view, size)
    positions, normals, d_max = cache.asking_points(view, size)
    rng = np.random.Generator(np.random.PCG64(cache.frame))
    there = np.flatnonzero((d_max > 0) & (hits.materials >= 0))
    chosen, drawn = [], []
    for pixel in rng.permutation(there)[:pixels]:
        product = (reflected(scene, hits, pixel, directions) * radiance) @ LUMINANCE
        if product.sum() > 0:
            chosen.append(pixel)
            drawn.append(directions[drawn_texels(product, RAYS, rng)])
    towards = np.stack(drawn)
    starts = np.repeat(hits.starts[chosen][:, None], RAYS, axis=1)
    visible = ~scene.occluded(starts.reshape(-1, 3), towards.reshape(-1, 3))
    lookup = cache.lookup(positions[chosen], normals[chosen], d_max[chosen])
    return cache.compare(lookup, towards, visible.reshape(len(chosen), RAYS))


def _rows(frames: list[Frame]) -> Iterator[Row]:
    ratios = np.array([f.ratio for f in frames])
    first = ratios[:10].mean()
    later = np.convolve(ratios[10:], np.full(10, 0.1), mode="valid")
    removed = sum(f.wrong + f.unused for f in frames)
    yield Row(
        "largest mean variance ratio of ten frames over that of the first ten",
        float(later.max() / first),
        band=bands.RATIO_STAYS,
        note=f"first ten frames {first:.3f}, product sampling 1",
    )
    yield Row(
        "records at the end",
        frames[-1].records,
        note=f"{sum(f.inserted for f in frames)} inserted, {removed} removed",
    )
    yield Row(
        "share of wrong answers, mean of the last ten frames",
        float(np.mean([f.miss_share for f in frames[-10:]])),
    )


def _panels(frames: list[Frame]) -> list[Panel]:
    drawn: dict[str, dict[str, list[float]]] = {
        "records": {
            "there": [f.records for f in frames],
            "new": [f.inserted for f in frames],
            "removed": [f.wrong + f.unused for f in frames],
        },
        "wrong answers [%]": {"": [100 * f.miss_share for f in frames]},
        "variance left, 10 samples": {"": [f.ratio for f in frames]},
    }

    def more(axes: Any) -> None:
        axes.set_yscale("symlog" if axes.get_ylabel() == "records" else "linear")
        axes.set_ylim(bottom=0)

    return [
        Panel(
            series=[
                Series(name, range(len(y)), y, "-", COLORS[k])
                for k, (name, y) in enumerate(named.items())
            ],
            x="frame",
            y=label,
            more=more,
        )
        for label, named in drawn.items()
    ]
