"""Error over time: pictures that converge pass by pass, one beside the other."""

from __future__ import annotations

import json
import math
import os
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import numpy.typing as npt

from viscache.base.progress import Progress, step_bar
from viscache.base.provenance import provenance
from viscache.frame import Frame
from viscache.frame.emitted_light import light_on_surfaces
from viscache.oracles.correct import in_words
from viscache.passes.progressive import Progressive
from viscache.scene import Scene
from viscache.scenes import sources
from viscache.settings.checks import is_whole, require
from viscache.settings.spelling import spelled
from viscache.shot.shot import BareShot, ShotArguments, of_shot

if TYPE_CHECKING:
    import xarray
    from typing_extensions import Unpack

__all__ = ["ERRORS", "METHODS", "gain", "passes_over_time"]

Floats: TypeAlias = npt.NDArray[np.float64]

#: Passes of the two references begin here: other blocks of samples than those of the settings.
FIRST_OF_REFERENCES = (1 << 20, 1 << 21)
#: Floor of the relative error of a pixel, as a share of the picture's mean.
DARK = 0.05
#: The picture is cut into so many blocks per edge for intervals.
BLOCKS = 4
#: What is measured after each pass, and its words.
ERRORS = {
    "nmse": "mean squared error over squared mean",
    "rel_mse": "mean squared error relative to each pixel",
    "rel_l1_reflected": "rel_l1 of light on surfaces",
}
#: Exact, biased and corrected visibility, by the quantized cache at its defaults.
METHODS: dict[str, dict[str, Any]] = {
    "exact": {"visibility": "exact"},
    "biased": {"visibility": "aqvc", "use": "replace"},
    "corrected": {"visibility": "aqvc", "use": "correct"},
}


@spelled
@of_shot("visibility", "use", "rays")
def passes_over_time(
    scene: Scene | str | os.PathLike[str],
    integrator: Any = None,
    settings: Mapping[str, Any] | None = None,
    *,
    passes: int = 16,
    reference: Frame | npt.NDArray[Any] | int | None = None,
    progress: Progress = False,
    **shot: Unpack[ShotArguments],
) -> xarray.Dataset:
    """Error and time of several settings after each pass of `vc.Progressive`.

    The settings take turns pass by pass, so what else the machine does meets all of them alike.
    Structures that a scene keeps, like the tree of shafts, are built before.

    Parameters
    ----------
    scene : Scene, path or str
    integrator : Direct, Whitted, AmbientOcclusion, Bdpt or str
        Of the references, and of settings without one of their own.
    settings : mapping of str to settings, optional
        By name: a visibility, or a mapping with "visibility" and, if wanted, "use", "rays" and
        "integrator", as `vc.Progressive` takes them. Exact, biased and corrected by default.
    passes : int >= 1
    reference : Frame, (H, W, 3) array or int >= 1, optional
        The picture that errors are against. Or how many exact passes each of two pictures has, of
        other eye samples and the same lights, whose own noise cancels in `nmse` and `rel_mse`;
        `passes` by default.
    size, spp, seed, threads, camera, env
        See `viscache.Shot`. Visibility, use and rays belong to the settings.
    progress : bool or callable
        True shows a bar; a callable gets (done, total) in passes.

    Returns
    -------
    xarray.Dataset
        Dimensions "setting" and "pass" (from 1). Variables, all of the mean of the passes so far:

        ================  =========================================================================
        nmse              mean(d²) / mean(b)²; d is the difference to the reference b
        nmse_low, _high   its 95 % interval: jackknife over blocks of the picture
        rel_mse           mean(d² / (b² + (0.05·mean b)²))
        rel_l1_reflected  Σ|d| / Σb; it contains the noise of the reference
        wall_s, cpu_s     seconds of all passes so far
        rays, queries     counted over all passes so far
        energy            Σ of this pass alone / Σ of the reference - 1
        ================  =========================================================================

        Beside them "picture" (setting, row, column, channel), the mean of all passes, and
        "reference" (row, column, channel), both with all light.

        Errors are of light on surfaces: emitted light that the camera sees is left out where
        frames have a layer of it. With two references, d² is the product of the differences to
        both, so an error far below their noise may come out negative.

    Raises
    ------
    ValueError
        No setting, an unknown key of one, a reference of another size, or a value out of range.

    Examples
    --------
    >>> import viscache as vc
    >>> ds = vc.passes_over_time(
    ...     "room?triangles=3000", vc.Whitted(n_vpls=64), passes=4, size=(48, 32)
    ... )
    >>> ds["setting"].values.tolist(), ds.sizes["pass"]
    (['exact', 'biased', 'corrected'], 4)
    >>> bool((ds["cpu_s"].diff("pass") > 0).all())
    True
    """
    import xarray

    require(is_whole(passes) and passes >= 1, "passes must be a whole number >= 1", passes)
    of_reference: Any = 0
    if reference is None or np.isscalar(reference):
        of_reference = passes if reference is None else reference
        fits = is_whole(of_reference) and of_reference >= 1
        require(fits, "reference must be a picture or a whole number of passes >= 1", reference)
    base = BareShot(scene, integrator, **shot)
    base = base.with_(scene=sources.opened(base.opened))
    chosen = {name: _setting(name, one, base) for name, one in _named(settings).items()}
    runs = {name: _Run(Progressive(**one.arguments)) for name, one in chosen.items()}
    total = passes * len(runs) + 2 * of_reference
    with step_bar(progress, total, unit="pass") as step:
        others: list[Any] = [reference]
        if of_reference:
            others = [_exact(base, n, of_reference, step) for n in FIRST_OF_REFERENCES]
        truth = _Truth(others)
        for i in range(passes):
            for run in list(runs.values())[:: 1 if i % 2 == 0 else -1]:
                run.add_pass(truth)
                step()
    names = list(next(iter(runs.values())).rows[0])
    measured = {
        n: (("setting", "pass"), [[row[n] for row in run.rows] for run in runs.values()])
        for n in names
    }
    space = ("row", "column", "channel")
    pictures = np.stack([run.picture.frame.image for run in runs.values()])
    return xarray.Dataset(
        measured | {"picture": (("setting", *space), pictures), "reference": (space, truth.image)},
        coords={"setting": list(runs), "pass": np.arange(1, passes + 1)},
        attrs={
            "scene": base.scene.name,
            "scene_hash": base.scene.content_hash,
            "integrator": repr(base.integrator),
            "settings": json.dumps({n: _words(one) for n, one in chosen.items()}),
            "size": json.dumps(truth.size),
            "spp": base.spp,
            "seed": base.seed,
            "reference_passes": of_reference,
            "provenance": json.dumps(provenance()),
        },
    )


def gain(
    ds: xarray.Dataset,
    setting: str,
    over: str = "exact",
    error: str = "nmse",
    at: int | None = None,
) -> float:
    """Error · CPU time of one setting over that of another: above 1 the second is worse.

    For unbiased settings it hardly depends on the number of passes: it is how much longer the other
    takes to the same error.

    Parameters
    ----------
    ds : Dataset of `passes_over_time`
    setting, over : str
    error : {"nmse", "rel_mse"}
    at : int, optional
        The pass; the last by default.
    """
    known = [str(n) for n in ds["setting"].values]
    for name in (setting, over):
        require(name in known, f"setting must be one of {known}", name)
    squared = ("nmse", "rel_mse")
    require(error in squared, f"error must be one of {squared}", error)
    last = ds.sizes["pass"] if at is None else at
    fits = is_whole(last) and 1 <= last <= ds.sizes["pass"]
    require(fits, f"at must be a pass in [1, {ds.sizes['pass']}]", at)
    here = ds.isel({"pass": last - 1})
    mine, other = (
        float(here[error].sel(setting=n)) * float(here["cpu_s"].sel(setting=n))
        for n in (setting, over)
    )
    return other / mine if mine > 0 else math.inf


def _named(settings: Mapping[str, Any] | None) -> Mapping[str, Any]:
    if settings is None:
        return METHODS
    fits = isinstance(settings, Mapping) and len(settings) > 0
    require(fits, "settings must be a mapping of names to settings", settings)
    return settings


def _setting(name: str, one: Any, base: BareShot) -> BareShot:
    given = dict(one) if isinstance(one, Mapping) else {"visibility": one}
    known = ("visibility", "use", "rays", "integrator")
    for key in given:
        require(key in known, f"settings[{name!r}] must have keys of {known}", key)
    require("visibility" in given, f"settings[{name!r}] must have a visibility", one)
    return base.with_(**given)


def _words(one: BareShot) -> dict[str, Any]:
    given = {n: getattr(one, n) for n in ("visibility", "use", "rays", "integrator")}
    return {n: in_words(v) if n == "use" else repr(v) for n, v in given.items() if v is not None}


def _light(picture: Any) -> Floats:
    """Light on surfaces, where it is known; all light of an array."""
    known = light_on_surfaces(picture) if isinstance(picture, Frame) else None
    pixels = np.asarray(getattr(picture, "image", picture) if known is None else known, np.float64)
    require(
        pixels.ndim == 3 and bool(np.isfinite(pixels).all()),
        "reference must be a frame or finite (H, W, C) pixels",
        pixels.shape,
    )
    return pixels


def _exact(base: BareShot, first: int, passes: int, step: Any) -> Frame:
    picture = Progressive(**base.with_(visibility="exact").arguments, first_pass=first)
    return picture.passes(passes, progress=lambda done, total: step())


class _Truth:
    """One reference, or two whose noise is independent."""

    def __init__(self, references: Sequence[Frame | npt.NDArray[Any]]) -> None:
        lights = [_light(reference) for reference in references]
        self.pictures = (lights[0], lights[-1])
        images = [np.asarray(getattr(r, "image", r), np.float64) for r in references]
        #: All light.
        self.image = np.asarray(np.mean(images, axis=0), np.float32)
        self.mean = (self.pictures[0] + self.pictures[1]) / 2
        require(bool(self.mean.sum() > 0), "the reference must have light on surfaces", "none")
        self.size = [self.mean.shape[1], self.mean.shape[0]]

    def errors(self, picture: Floats) -> dict[str, float]:
        """Of the mean of all passes so far."""
        fits = picture.shape == self.mean.shape
        require(fits, f"reference must have shape {picture.shape}", self.mean.shape)
        squares = (picture - self.pictures[0]) * (picture - self.pictures[1])
        level = float(self.mean.mean())
        relative = squares / (np.square(self.mean) + (DARK * level) ** 2)
        away = float(np.abs(picture - self.mean).sum()) / float(self.mean.sum())
        nmse, half = float(squares.mean()) / level**2, half_width(squares) / level**2
        return {
            "nmse": nmse,
            "nmse_low": nmse - half,
            "nmse_high": nmse + half,
            "rel_mse": float(relative.mean()),
            "rel_l1_reflected": away,
        }


def half_width(values: Floats) -> float:
    """Half of the 95 % interval of a mean over pixels, by blocks of the picture."""
    from scipy.stats import t  # type: ignore[import-untyped,unused-ignore]

    rows = (part for part in np.array_split(values, min(BLOCKS, values.shape[0]), axis=0))
    blocks = [b for row in rows for b in np.array_split(row, min(BLOCKS, row.shape[1]), axis=1)]
    sums, counts = (np.array([f(b) for b in blocks]) for f in (np.sum, np.size))
    n = len(blocks)
    if n < 2:
        return math.inf
    without = (sums.sum() - sums) / (counts.sum() - counts)
    deviation = math.sqrt((n - 1) / n * float(np.square(without - without.mean()).sum()))
    return float(t.ppf(0.975, n - 1)) * deviation


@dataclass
class _Run:
    """A picture, what it took so far, and a row for every pass."""

    picture: Progressive
    wall_s: float = 0.0
    cpu_s: float = 0.0
    light: float = 0.0
    rows: list[dict[str, float]] = field(default_factory=list)

    def add_pass(self, truth: _Truth) -> None:
        wall, cpu = time.perf_counter(), time.process_time()
        frame = self.picture.passes(1)
        self.cpu_s += time.process_time() - cpu
        self.wall_s += time.perf_counter() - wall
        picture = _light(frame)
        light = float(picture.sum()) * self.picture.n_passes
        self.rows.append(
            {
                **truth.errors(picture),
                "wall_s": self.wall_s,
                "cpu_s": self.cpu_s,
                "rays": float(frame.counters["rays"]),
                "queries": float(frame.counters["queries"]),
                "energy": (light - self.light) / float(truth.mean.sum()) - 1,
            }
        )
        self.light = light
