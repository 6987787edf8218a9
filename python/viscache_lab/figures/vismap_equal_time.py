"""Figures 1, 13 and 14 of the visibility-map paper: the visible effect on variance."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

import viscache as vc
from viscache.base.tonemap import auto_exposure, luminance, srgb_curve
from viscache.metrics.variance import variance_ratio
from viscache_lab.cases.light_product import blocked_share, first_hits
from viscache_lab.cases.map_renders import Picture, cpu_median, images, paper_maps, samples_in
from viscache_lab.experiment import FIGURES, Row, Trial
from viscache_lab.experiment.drawing import Panel, Panels
from viscache_lab.experiment.drawing import images as panels_of
from viscache_lab.figures import vismap_printed as printed
from viscache_lab.figures.bands import vismap as bands
from viscache_lab.figures.vismap_records import VIEWS

RENDERS, SIZE = 8, (640, 480)
QUICK_RENDERS, QUICK_SIZE = 3, (64, 48)
#: The share of blocked samples is measured at this many pixels and used for their neighbours.
COARSE = (64, 48)
#: Shares of blocked light-product samples: mostly hidden, mostly lit.
HIDDEN, LIT = 0.9, 0.5

Pixels = npt.NDArray[np.bool_]


@dataclass(frozen=True, kw_only=True, slots=True)
class Rivals:
    """Independent renders of both sides."""

    maps: list[npt.NDArray[np.floating[Any]]]
    product: list[npt.NDArray[np.floating[Any]]]

    @property
    def reference(self) -> npt.NDArray[np.float64]:
        """The mean of all renders."""
        return np.asarray(np.mean([*self.maps, *self.product], axis=0), float)


@FIGURES.add("vismap-fig13", "equal-time comparison, with the crops of figure 14")
def figure13(trial: Trial) -> None:
    """The garage in equal time, with crops (Figure 14)."""
    picture = _garage(trial.quick)
    ours, theirs = printed.EQUAL_TIME_SAMPLES
    renders = QUICK_RENDERS if trial.quick else RENDERS
    seconds = cpu_median([picture.maps(ours, paper_maps(None)) for _ in range(3)])
    equal = samples_in(picture, seconds)
    cache = picture.build_cache()
    rivals = _rivals(picture, paper_maps(cache), ours, equal, renders)
    left = variance_ratio(rivals.maps, rivals.product)
    share = _upsampled(blocked_share(picture.scene, size=COARSE, samples=64), picture.size)
    trial.row(
        "CPU seconds of a picture with the cache, its records included",
        seconds,
        printed=printed.EQUAL_TIME_S,
        note=f"{len(cache)} records",
    )
    trial.row(
        "samples of product sampling in the same time",
        equal,
        printed=theirs,
        note=f"{ours} with the cache",
    )
    trial.row(
        "variance left in equal time",
        left.ratio,
        printed=printed.EQUAL_TIME_RATIO,
        band=None if trial.quick else bands.EQUAL_TIME,
        note=f"{left.low:.3f} to {left.high:.3f}, trimmed {left.trimmed:.3f}",
    )
    trial.rows += _shadow_rows(picture, rivals, ours, share, renders, trial.quick)
    trial.rows += _guided_rows(picture, renders)
    titles = (f"with the cache, {ours} samples", f"product sampling, {equal} samples")
    trial.draw("vismap-fig13.png", _panels(rivals, titles), (12.0, 9.6), dpi=150)


@FIGURES.add("vismap-fig1", "an occluded glossy surface, with and without the control variate")
def figure1(trial: Trial) -> None:
    """Glossy surfaces of the garage that most light does not reach, with 10 samples."""
    picture = _garage(trial.quick)
    renders = QUICK_RENDERS if trial.quick else RENDERS
    rivals = _rivals(picture, paper_maps(picture.build_cache()), 10, 10, renders)
    share = _upsampled(blocked_share(picture.scene, size=COARSE, samples=64), picture.size)
    pixels = _glossy(picture) & (share >= HIDDEN)
    left = variance_ratio(rivals.maps, rivals.product, pixels=pixels)
    trial.row(
        "variance left in hidden glossy pixels, 10 samples",
        left.ratio,
        band=bands.QUICK_OCCLUDED_CROP if trial.quick else bands.OCCLUDED_CROP,
        note=f"{left.low:.3f} to {left.high:.3f}; {int(pixels.sum())} of {pixels.size} pixels",
    )
    titles = ("with the cache, 10 samples", "product sampling, 10 samples")
    trial.draw("vismap-fig1.png", _panels(rivals, titles, where=pixels), (12.0, 9.6), dpi=150)


def _garage(quick: bool) -> Picture:
    return Picture(scene=VIEWS["garage"].open(quick), size=QUICK_SIZE if quick else SIZE)


def _rivals(picture: Picture, maps: vc.VisMaps, ours: int, theirs: int, renders: int) -> Rivals:
    return Rivals(
        maps=images(lambda seed: picture.maps(ours, maps, seed), range(renders)),
        product=images(lambda seed: picture.product(theirs, seed), range(100, 100 + renders)),
    )


def _shadow_rows(
    picture: Picture,
    rivals: Rivals,
    samples: int,
    share: npt.NDArray[np.float64],
    renders: int,
    quick: bool,
) -> Iterator[Row]:
    """Remaining variance at equal samples, where light is hidden and where it is not."""
    product = images(lambda seed: picture.product(samples, seed), range(200, 200 + renders))
    hidden = variance_ratio(rivals.maps, product, pixels=share >= HIDDEN).ratio
    lit = variance_ratio(rivals.maps, product, pixels=share < LIT).ratio
    yield Row(
        f"variance left at {samples} samples",
        variance_ratio(rivals.maps, product).ratio,
        printed=printed.COSTS["garage"][1].variance_ratio,
        band=bands.EQUAL_SAMPLES,
    )
    yield Row(
        "variance left where light is hidden over that where it is not",
        hidden / lit,
        printed="less than 1",
        band=None if quick else bands.SHADOWS_GAIN_MORE,
        note=f"{hidden:.3f} and {lit:.3f}",
    )


def _guided_rows(picture: Picture, renders: int) -> Iterator[Row]:
    """Guided densities, an extension of the paper's method, in equal time."""
    samples = printed.EQUAL_TIME_SAMPLES[0]
    seconds = cpu_median([picture.maps(samples, vc.VisMaps(sampling="guided")) for _ in range(3)])
    equal = samples_in(picture, seconds)
    maps = vc.VisMaps(sampling="guided", cache=picture.build_cache(), update=False)
    rivals = _rivals(picture, maps, samples, equal, renders)
    left = variance_ratio(rivals.maps, rivals.product)
    yield Row(
        "guided: variance left in equal time",
        left.ratio,
        note=f"{left.low:.3f} to {left.high:.3f}; {seconds:.3g} s, {samples} against "
        f"{equal} samples",
    )


def _glossy(picture: Picture) -> Pixels:
    hits = first_hits(picture.scene, picture.scene.cameras[picture.camera], picture.size)
    kinds = [material["kind"].name for material in picture.scene.materials]
    glossy = np.array([kind == "GLOSSY" for kind in kinds] + [False])
    return np.asarray(glossy[hits.materials]).reshape(picture.size[1], picture.size[0])


def _upsampled(share: npt.NDArray[np.float64], size: tuple[int, int]) -> npt.NDArray[np.float64]:
    """(H, W): a coarser picture enlarged by nearest pixels; NaN stays."""
    rows = (np.arange(size[1]) * share.shape[0]) // size[1]
    columns = (np.arange(size[0]) * share.shape[1]) // size[0]
    return np.asarray(share[np.ix_(rows, columns)])


def noisiest_windows(
    variance: npt.NDArray[np.float64], edge: int, count: int
) -> list[tuple[int, int]]:
    """Upper left corners (y, x) of the non-overlapping windows with the largest sums."""
    left, found = variance.copy(), []
    for _ in range(count):
        sums = np.cumsum(np.cumsum(np.pad(left, ((1, 0), (1, 0))), axis=0), axis=1)
        windows = (
            sums[edge:, edge:] - sums[:-edge, edge:] - sums[edge:, :-edge] + sums[:-edge, :-edge]
        )
        y, x = (int(v) for v in np.unravel_index(windows.argmax(), windows.shape))
        left[y : y + edge, x : x + edge] = 0
        found.append((y, x))
    return found


def _panels(rivals: Rivals, titles: tuple[str, str], where: Pixels | None = None) -> Panels:
    """The reference and both sides above, two crops of each below."""
    shown = {"reference": rivals.reference, titles[0]: rivals.maps[0], titles[1]: rivals.product[0]}
    exposure = auto_exposure(rivals.reference, 95.0)
    seen = np.stack([srgb_curve(luminance(image) * exposure) for image in rivals.product])
    noise, edge = seen.var(axis=0), seen.shape[1] // 5
    crops = noisiest_windows(noise if where is None else noise * where, edge, 2)

    def frames(axes: Any) -> None:
        for y, x in crops:
            across, down = [x, x + edge, x + edge, x, x], [y, y, y + edge, y + edge, y]
            axes.plot(across, down, color="red", lw=0.8)

    return [
        [replace(panel, more=frames) for panel in panels_of(shown, exposure)],
        *(
            [Panel(image=i[y : y + edge, x : x + edge], exposure=exposure) for i in shown.values()]
            for y, x in crops
        ),
    ]
