"""How far an image is from its reference, in numbers with confidence intervals.

Over linear RGB; sums run over pixels and channels; a = image, b = reference:

================  =============================================================================
rmse              sqrt(mean((a - b)²))
rel_l1            Σ|a - b| / Σb: L̂_INF of the AQVC paper
rel_l1_reflected  the same of the light on surfaces: a and b without the emitted light that the
                  camera sees, directly or through mirrors and glass
energy            Σ(a - b) / Σb, signed
rel_mse           mean((a - b)² / (b² + (0.01·mean b)²))
ssim              scikit-image's on luminance: exposure (99th percentile of b → 1), clip, sRGB curve
flip              mean HDR-FLIP at 67 pixels per degree [Andersson et al. 2021], flip-evaluator's
max_abs           max|a - b|
================  =============================================================================

A cache cannot err in light that comes straight from an emitter. If lamps or a sky are in the
picture, they make rel_l1 smaller, but not the error that is seen; rel_l1_reflected leaves them out.
It takes frames with a layer of that light (`viscache.frame.emitted_light.seen_emitters`). Of
arrays, and of files of other programs, it is undefined.
"""

from __future__ import annotations

import html
import importlib
import math
import os
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import numpy.typing as npt

from viscache.base import tonemap
from viscache.base.progress import Progress, step_bar
from viscache.frame.emitted_light import light_on_surfaces
from viscache.settings.checks import checked_floats, require
from viscache.settings.spelling import nearest

if TYPE_CHECKING:
    from viscache.frame import Frame

Image = npt.NDArray[np.float64]
Comparable: TypeAlias = "Frame | npt.NDArray[np.floating[Any]]"

#: FLIP's viewing condition: a 0.7 m wide 3840-pixel monitor seen from 0.7 m.
FLIP_PIXELS_PER_DEGREE = 67.0
#: scikit-image's Gaussian window: 2·round(3.5·1.5) + 1 pixels.
SSIM_WINDOW_PX = 11


class Metrics(Mapping[str, "float | None"]):
    """The requested metrics, as a mapping and as attributes.

    A value is None if the metric is undefined: rel_l1, energy, rel_mse and flip with a black
    reference, ssim of images smaller than its window, rel_l1_reflected if no light falls on a
    surface, or if a side has no layer of emitted light.

    Attributes
    ----------
    intervals : dict of str to (low, high)
        95 % confidence interval of the mean over repeats (Student's t); empty without repeats.
    repeats : int
        Number of image pairs.
    samples : dict of str to list
        The value of every repeat.
    """

    __slots__ = ("intervals", "repeats", "samples", "values_by_name")

    def __init__(self, samples: Mapping[str, Sequence[float | None]]) -> None:
        self.samples = {name: list(values) for name, values in samples.items()}
        self.repeats = max((len(v) for v in self.samples.values()), default=0)
        self.values_by_name: dict[str, float | None] = {}
        self.intervals: dict[str, tuple[float, float]] = {}
        for name, values in self.samples.items():
            known = [v for v in values if v is not None]
            whole = len(known) == len(values) and known
            self.values_by_name[name] = math.fsum(known) / len(known) if whole else None
            if whole and len(known) > 1:
                self.intervals[name] = confidence_interval(known)

    def __getitem__(self, name: str) -> float | None:
        return self.values_by_name[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.values_by_name)

    def __len__(self) -> int:
        return len(self.values_by_name)

    def __getattr__(self, name: str) -> float | None:
        if name in METRICS:
            if name in self.values_by_name:
                return self.values_by_name[name]
            raise AttributeError(f"{name} was not asked for; there are {list(self)}")
        raise AttributeError(name)

    def as_dict(self) -> dict[str, float | None]:
        """A plain dict, as `viscache diff --json` prints it."""
        return dict(self.values_by_name)

    def __repr__(self) -> str:
        return f"Metrics({', '.join(f'{k}={self._text(k)}' for k in self)})"

    def _repr_html_(self) -> str:
        rows = "".join(
            f"<tr><td>{name}</td><td style='text-align:right'>"
            f"{html.escape(self._text(name))}</td></tr>"
            for name in self
        )
        return f"<table><caption>{self.repeats} image pair(s)</caption>{rows}</table>"

    def _text(self, name: str) -> str:
        value = self.values_by_name[name]
        if value is None:
            return "undefined"
        if name in self.intervals:
            low, high = self.intervals[name]
            return f"{value:.4g} [{low:.4g}, {high:.4g}]"
        return f"{value:.4g}"


def confidence_interval(samples: Sequence[float], level: float = 0.95) -> tuple[float, float]:
    """Interval of the mean of independent, roughly normal samples: mean ± t·s/√n.

    `samples` needs at least two values; `level` lies in (0, 1).
    """
    n = len(samples)
    if n < 2:
        raise ValueError(f"samples must have at least 2 values, got {n}")
    if not 0.0 < level < 1.0:
        raise ValueError(f"level must lie in (0, 1), got {level}")
    from scipy.stats import t  # type: ignore[import-untyped,unused-ignore]

    values = checked_floats(samples, "samples", np.float64)
    half = float(t.ppf(0.5 + level / 2, n - 1)) * float(values.std(ddof=1)) / math.sqrt(n)
    mean = float(values.mean())
    return (mean - half, mean + half)


def rmse(a: Image, b: Image) -> float:
    """sqrt(mean((a - b)²))."""
    return math.sqrt(float(np.mean(np.square(a - b))))


def rel_l1(a: Image, b: Image) -> float | None:
    """Σ|a - b| / Σb, the paper's L̂_INF; None if b is black. Refuses Σb <= 0 of other images."""
    total = _light(b)
    return None if total is None else float(np.abs(a - b).sum()) / total


def rel_l1_reflected(a: Image, b: Image) -> float | None:
    """`rel_l1` of light on surfaces.

    `compare` takes the emitted light that the camera sees out of both images first. None if b is 0.
    """
    return rel_l1(a, b)


def energy(a: Image, b: Image) -> float | None:
    """Σ(a - b) / Σb, signed; None if b is black. Refuses Σb <= 0 of other images."""
    total = _light(b)
    return None if total is None else float((a - b).sum()) / total


def _light(b: Image) -> float | None:
    """Σb, by which errors are divided; None of a black reference.

    ValueError if it is negative, or 0 of an image that is not black: shares of it have no meaning.
    """
    total = float(b.sum())
    fits = total > 0.0 or not b.any()
    require(fits, "the reference must be black, or the sum of its pixels above 0", total)
    return total or None


def rel_mse(a: Image, b: Image) -> float | None:
    """mean((a - b)² / (b² + (0.01·mean b)²)); None if b is black."""
    floor = (0.01 * float(b.mean())) ** 2
    below = np.square(b) + floor
    if not below.all():  # a pixel of 0 and a mean of 0 (or one too small to be squared)
        return None
    return float(np.mean(np.square(a - b) / below))


def ssim(a: Image, b: Image) -> float | None:
    """Mean structural similarity after tone mapping; None if a side has less than 11 pixels."""
    if min(b.shape[:2]) < SSIM_WINDOW_PX:
        return None
    from skimage.metrics import structural_similarity

    exposure = tonemap.auto_exposure(b)
    seen = [tonemap.srgb_curve(tonemap.luminance(image) * exposure) for image in (a, b)]
    value = structural_similarity(  # type: ignore[no-untyped-call,unused-ignore]
        seen[0], seen[1], data_range=1.0, gaussian_weights=True
    )
    return float(value)


def flip(a: Image, b: Image) -> float | None:
    """Mean HDR-FLIP at 67 pixels per degree; None against a black reference."""
    found = flip_map(a, b)
    return None if found is None else found[1]


def flip_map(a: Image, b: Image) -> tuple[npt.NDArray[np.float32], float] | None:
    """HDR-FLIP of every pixel, (H, W) in [0, 1], and its mean; None against a black reference.

    flip-evaluator ends the process if the maximum luminance of the reference is below 1.2e-7. So
    both images are scaled up first if they are darker. This does not change the result, because
    FLIP chooses its exposures by the reference. Negative pixels count as 0.
    """
    flip_evaluator = _flip_evaluator()
    brightest = float(tonemap.luminance(b).max())
    if brightest <= 0.0:
        return None
    scale = 1.0 if brightest > 1e-6 else 1.0 / brightest
    test, reference = (
        np.ascontiguousarray(np.maximum(_three_channels(i) * scale, 0.0), np.float32)
        for i in (a, b)
    )
    errors, mean, _ = flip_evaluator.evaluate(
        reference,
        test,
        "HDR",
        inputsRGB=False,
        applyMagma=False,
        computeMeanError=True,
        parameters={"ppd": FLIP_PIXELS_PER_DEGREE},
    )
    if not math.isfinite(mean):
        return None
    return np.asarray(errors, np.float32).reshape(b.shape[:2]), float(mean)


def _flip_evaluator() -> Any:
    """flip-evaluator, with threads that sleep while they wait for each other.

    OpenMP's threads spin by default. On a busy machine they block the cores that other threads
    need, which doubles the CPU time. The library reads this policy once, when it is loaded.
    """
    if "flip_evaluator" in sys.modules or "OMP_WAIT_POLICY" in os.environ:
        return importlib.import_module("flip_evaluator")
    os.environ["OMP_WAIT_POLICY"] = "passive"
    try:
        return importlib.import_module("flip_evaluator")
    finally:
        del os.environ["OMP_WAIT_POLICY"]


def max_abs(a: Image, b: Image) -> float:
    """max|a - b|."""
    return float(np.abs(a - b).max())


#: Name to function of two (H, W, C) scene-linear images, the image and its reference. Those of
#: `ON_SURFACES` take images without the emitted light that the camera sees.
METRICS: dict[str, Callable[[Image, Image], float | None]] = {
    "rmse": rmse,
    "rel_mse": rel_mse,
    "rel_l1": rel_l1,
    "rel_l1_reflected": rel_l1_reflected,
    "energy": energy,
    "flip": flip,
    "ssim": ssim,
    "max_abs": max_abs,
}


ON_SURFACES = ("rel_l1_reflected",)


def check_names(metrics: Iterable[str] | None) -> list[str]:
    """The names as a list (all of them for None); ValueError names the nearest known one."""
    fits = metrics is None or (isinstance(metrics, Iterable) and not isinstance(metrics, str))
    require(fits, "metrics must be a list of names", metrics)
    names = list(METRICS) if metrics is None else list(metrics)
    for name in names:
        if not isinstance(name, str) or name not in METRICS:
            raise ValueError(f"unknown metric {name!r}{nearest(str(name), METRICS)}")
    return names


def compare(
    a: Comparable | Sequence[Comparable],
    b: Comparable | Sequence[Comparable],
    *,
    metrics: Iterable[str] | None = None,
    progress: Progress = False,
) -> Metrics:
    """Compare an image with its reference, or repeats of one with repeats of the other.

    Parameters
    ----------
    a, b : Frame or (H, W, C) array, or a sequence of them
        Image and reference, scene-linear, C = 1 or 3. Sequences of equal length are compared pair
        by pair; a single `b` serves every repeat of `a`.
    metrics : iterable of str, optional
        Which ones (see the module's table); all by default.
    progress : bool or callable
        True shows a bar. A callable gets (done, total) after each metric of each pair.

    Returns
    -------
    Metrics
        Means over the repeats and their 95 % confidence intervals.

    Raises
    ------
    ValueError
        Different sizes, non-finite pixels, different numbers of repeats, an unknown metric; rel_l1,
        rel_l1_reflected or energy, and a reference whose sum is negative.

    Examples
    --------
    >>> import numpy as np
    >>> compare(np.full((16, 16, 3), 1.5), np.ones((16, 16, 3)), metrics=["rmse"]).as_dict()
    {'rmse': 0.5}
    """
    names = check_names(metrics)
    images: list[Any] = list(a) if isinstance(a, (list, tuple)) else [a]
    references: list[Any] = list(b) if isinstance(b, (list, tuple)) else [b] * len(images)
    if not images or len(images) != len(references):
        raise ValueError(
            f"a and b must have the same number of repeats, got {len(images)} and {len(references)}"
        )
    samples: dict[str, list[float | None]] = {name: [] for name in names}
    with step_bar(progress, len(images) * len(names), unit="metric") as step:
        for image, reference in zip(images, references, strict=True):
            pair = (_linear(image, "a"), _linear(reference, "b"))
            if pair[0].shape != pair[1].shape:
                raise ValueError(
                    f"a and b must have one shape, got {pair[0].shape} and {pair[1].shape}"
                )
            sides = [light_on_surfaces(side) for side in (image, reference)]
            known = [_linear(s, w) for s, w in zip(sides, "ab", strict=True) if s is not None]
            for name in names:
                of = pair if name not in ON_SURFACES else known
                samples[name].append(METRICS[name](of[0], of[1]) if len(of) == 2 else None)
                step()
    return Metrics(samples)


def _linear(image: Comparable, which: str) -> Image:
    """Pixels as finite float64 (H, W, 1 or 3), without alpha."""
    pixels = checked_floats(getattr(image, "image", image), which, np.float64)
    if pixels.ndim == 2:
        pixels = pixels[:, :, None]
    if pixels.ndim != 3 or pixels.shape[2] not in (1, 3, 4) or 0 in pixels.shape:
        raise ValueError(f"{which} must have shape (H, W, 1, 3 or 4), got {pixels.shape}")
    pixels = pixels[:, :, : 1 if pixels.shape[2] == 1 else 3]
    bad = ~np.isfinite(pixels).all(axis=2)
    if bad.any():
        row, column = (int(i) for i in np.argwhere(bad)[0])
        raise ValueError(
            f"{which} must be finite, got {int(bad.sum())} non-finite pixel(s),"
            f" the first at row {row}, column {column}"
        )
    return pixels


def _three_channels(image: Image) -> Image:
    return np.repeat(image, 3, axis=2) if image.shape[2] == 1 else image
