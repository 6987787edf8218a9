"""Figure 10 of the visibility-map paper: ambient occlusion from rays and from records."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

import viscache as vc
from viscache.scenes import build
from viscache_lab.experiment import FIGURES, Row, Trial
from viscache_lab.experiment.drawing import Panel, images
from viscache_lab.figures import vismap_printed as printed
from viscache_lab.figures.bands import vismap as bands

#: An outdoor scene with the triangle count of the paper's; its pictures take minutes.
SCENE, QUICK_SCENE = f"courtyard?triangles={printed.AO_TRIANGLES}", "courtyard?triangles=30000"
SIZE, QUICK_SIZE = (640, 480), (96, 72)
QUICK_RAYS = 256


@FIGURES.add("vismap-fig10", "ambient occlusion, reference and cached")
def figure10(trial: Trial) -> None:
    """Rays and time of both, and the cached picture's error."""
    scene, size = build(QUICK_SCENE if trial.quick else SCENE), QUICK_SIZE if trial.quick else SIZE
    n_rays = QUICK_RAYS if trial.quick else printed.AO_RAYS
    cached = vc.cached_ambient_occlusion(scene, size=size, spp=printed.AO_SAMPLES)
    unlimited = vc.AmbientOcclusion(n_samples=n_rays, max_distance=None)
    exact = vc.render(scene, unlimited, size=size, spp=printed.AO_SAMPLES, progress=trial.progress)
    trial.rows += _rows(exact, cached, n_rays, trial.quick)
    trial.draw("vismap-fig10.png", [_panels(exact, cached)], (13.0, 3.6), dpi=150)


def _rows(exact: vc.Frame, cached: vc.Frame, n_rays: int, quick: bool) -> Iterator[Row]:
    """A quick picture has too few pixels to share its records: its gains have no bands."""
    error = np.abs(_visible(cached) - _visible(exact))
    per_point = cached.counters["rays_per_point"]
    times = [frame.timings["total_s"] for frame in (exact, cached)]
    yield Row("mean of the reference", float(_visible(exact).mean()), band=bands.AO_MEAN)
    yield Row(
        "rays per shading point with the cache",
        per_point,
        printed=printed.AO_CACHE_RAYS,
        note=f"{cached.counters['records']} records",
    )
    yield Row(
        "rays per shading point, reference over cache",
        n_rays / per_point,
        printed=printed.AO_RAYS / printed.AO_CACHE_RAYS,
        band=None if quick else bands.AO_RAYS,
    )
    yield Row("time of the reference [s]", times[0], printed=printed.AO_SECONDS)
    yield Row("time with the cache [s]", times[1], printed=printed.AO_CACHE_SECONDS)
    yield Row(
        "time, reference over cache",
        times[0] / times[1],
        printed=printed.AO_SECONDS / printed.AO_CACHE_SECONDS,
        band=None if quick else bands.AO_TIME,
    )
    yield Row(
        "root mean squared error",
        float(np.sqrt((error**2).mean())),
        band=None if quick else bands.AO_RMSE,
    )
    yield Row("95th percentile of the error", float(np.quantile(error, 0.95)))
    yield Row(
        "points without a record in reach",
        float(cached.counters["without_record"]),
        note="they are black",
    )


def _visible(frame: vc.Frame) -> Any:
    """(H, W) ambient visibility; samples of a pixel without a surface count as 0 in both."""
    over_hits = "ambient" not in frame.layers  # a cached picture's mean covers surfaces only
    return (frame.image * (frame.layers["coverage"] if over_hits else 1.0))[:, :, 0].astype(float)


def _panels(exact: vc.Frame, cached: vc.Frame) -> list[Panel]:
    def difference(axes: Any) -> None:
        error = _visible(cached) - _visible(exact)
        shown = axes.imshow(error, cmap="RdBu", vmin=-0.1, vmax=0.1)
        axes.set_title("difference", fontsize=9)
        axes.set_axis_off()
        axes.figure.colorbar(shown, ax=axes, shrink=0.8)

    return [*images({"by rays": exact, "from records": cached}, 1.0), Panel(more=difference)]
