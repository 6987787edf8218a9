"""A parameter from an error target: pilots, checked on pixels that they did not see."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any, Protocol, TypeVar, get_args

from viscache import combinations, sources
from viscache.oracles.correct import Correct
from viscache.oracles.written import Written
from viscache.progress import Progress, progress_bar
from viscache.render import check_settings
from viscache.scene import Scene
from viscache.scene.cameras import find_camera, frame_size
from viscache.settings import by_name
from viscache.settings.checks import is_whole, require
from viscache.settings.integrators import AmbientOcclusion, Direct, Whitted
from viscache.settings.rays import Embree
from viscache.settings.spelling import spelled
from viscache.settings.visibility import Visibility, VisMaps
from viscache.sweeps.light_cells import MOST_TRIALS, with_light_cells
from viscache.sweeps.samples import ErrorMetric, Sample, samples
from viscache.sweeps.search import MOST_PILOTS, best, search
from viscache.sweeps.searched import Searched, searched
from viscache.sweeps.tuned import OWN_SAMPLES, Pilot, Tuned

__all__ = ["Pilot", "Tuned", "tune"]

T = TypeVar("T")


@spelled
def tune(
    scene: Scene | str | os.PathLike[str],
    integrator: Any,
    *,
    rel_l1: float = 0.01,
    metric: ErrorMetric = "rel_l1_reflected",
    visibility: Visibility | Written | str | None = None,
    parameter: str | None = None,
    between: tuple[float, float] | None = None,
    use: str | Correct | None = None,
    size: tuple[int, int] | None = None,
    spp: int = 1,
    seed: int = 0,
    threads: int | None = None,
    camera: Any = None,
    env: Any = None,
    progress: Progress = False,
) -> Tuned:
    """The value of a parameter at which a cache has a wanted error against exact visibility.

    Of the quantized cache this is C_E. If pixels have samples of their own (of a sky, of area
    lights, of ambient light), C_L is chosen too: it is halved until the error that no C_E lowers is
    at most half of the target.

    Parameters
    ----------
    scene : Scene, path or str
    integrator : Direct, Whitted or AmbientOcclusion
        Or its name. Its directions not shared.
    rel_l1 : float
        The wanted error, a relative L1; in (0, 1).
    metric : {"rel_l1_reflected", "rel_l1"}
        Over which light: that on surfaces, or all light of the picture, as in the paper. Lamps and
        a sky in the picture make the second one smaller, but not the errors that one sees.
    visibility : Aqvc, ShadowMap, NeePlusPlus, VisMaps or your own, optional
        The cache with its other parameters; `Aqvc()` by default. A C_E per light group stays, and a
        `c_l` that is given.
    parameter : str, optional
        The number to search: a parameter of the cache, or "use.share" with `use=vc.Correct(...)`.
        "c_e" of Aqvc by default; of other caches their only number.
    between : (low, high), optional
        Where to search; needed but for C_E. The error may rise or fall with the parameter. Steps
        have equal ratios if `low` is positive. Whole numbers stay whole.
    use, size, spp, seed, threads, camera, env
        Of the frame that will be rendered, as `viscache.render` takes them; the size is the
        camera's own by default.
    progress : bool or callable
        True shows a bar; a callable gets (done, total) renderings. The total may shrink.

    Returns
    -------
    Tuned
        `reached` says whether pixels that no pilot saw confirm the error. If no value reaches the
        target, the value with the smallest error is returned, and `message` says which light group
        limits it. If every value has a smaller error, the value with the largest is returned.
        `exact_is_cheaper` says whether an exact frame takes less time, and `message` has both
        times.

    Raises
    ------
    ValueError
        A parameter out of range or one that is not there, or a picture without light.

    Notes
    -----
    A 16th of a large frame's tiles, at least 24, serves for the pilots, and as many others for the
    check; of smaller frames one half and the other. Of frames of less than eight tiles, and for
    caches that do not work in parts of frames (docs/limits.md), the pilots see a frame of another
    seed, and the frame itself checks the result. If an exact frame costs up to seven times the
    frame that is found, all of it costs less than 20 times that frame.

    Examples
    --------
    >>> import viscache as vc
    >>> room = vc.scenes.room(triangles=2000)
    >>> vc.tune(room, vc.Direct(), rel_l1=0.02, size=(64, 40)).reached
    True
    >>> maps = vc.ShadowMap()
    >>> found = vc.tune(
    ...     room, vc.Direct(), rel_l1=0.02, visibility=maps, parameter="resolution",
    ...     between=(16, 1024), size=(64, 40),
    ... )
    >>> found.reached, found.visibility.resolution == found.value
    (True, True)
    """
    number = isinstance(rel_l1, (int, float)) and not isinstance(rel_l1, bool)
    require(number and 0 < rel_l1 < 1, "rel_l1 must lie in (0, 1)", rel_l1)
    target = float(rel_l1)
    known_metrics = get_args(ErrorMetric)
    require(metric in known_metrics, f"metric must be one of {known_metrics}", metric)
    integrator = by_name.setting("integrator", integrator)
    known = "vc.Direct(...), vc.Whitted(...) or vc.AmbientOcclusion(...)"
    fits = isinstance(integrator, Direct | Whitted | AmbientOcclusion)
    require(fits, f"integrator must be {known}", integrator)
    cache = by_name.setting("visibility", visibility, "aqvc")
    require(is_whole(seed) and 0 <= seed < 1 << 62, "seed must be in [0, 2^62)", seed)
    lit = sources.opened(scene)
    check_settings(lit, integrator, Embree(), cache, use, None)
    if use == "correct" and not isinstance(cache, VisMaps):
        use = Correct()
    wanted = searched(cache, use, parameter, between)
    in_parts = _works_in_parts(integrator, cache, use)
    lit = lit if env is None else lit.with_environment(env, threads=threads)
    pixels = frame_size(size, find_camera(lit, camera))
    given = {"size": pixels, "spp": spp, "threads": threads, "camera": camera}
    make_pilot, make_check = samples(
        lit, integrator, given, int(seed), in_parts=in_parts, metric=metric
    )
    with _steps(progress, wanted) as step:
        pilot = step(make_pilot)
        if wanted.is_c_e and not pilot.groups.isdisjoint(OWN_SAMPLES):
            chosen = with_light_cells(
                lambda tried: step(lambda: pilot.measured((tried, use))).groups,
                wanted.visibility,
                target,
            )
            wanted = replace(wanted, visibility=chosen)

        def measure(value: float) -> Pilot:
            found = step(lambda: pilot.measured(wanted.at(value)))
            return Pilot(value, found.errors[metric], found.ray_reduction, wanted.parameter)

        pilots = search(measure, target, wanted.span)
        check = step(make_check)
        return step(lambda: _checked(check, wanted, pilots, target, metric))


class _Step(Protocol):
    """Calls a function that renders."""

    def __call__(self, call: Callable[[], T]) -> T: ...


@contextmanager
def _steps(progress: Progress, wanted: Searched) -> Iterator[_Step]:
    """A function that calls its argument and reports that one more rendering is done."""
    total = 3 + MOST_PILOTS + (MOST_TRIALS if wanted.is_c_e else 0)
    done = 0
    with progress_bar(progress, "rendering") as report:

        def step(call: Callable[[], T]) -> T:
            nonlocal done
            made = call()
            done += 1
            if report is not None:
                report(done, total)
            return made

        yield step
        if report is not None:
            report(done, done)


def _works_in_parts(integrator: Any, visibility: Any, use: Any) -> bool:
    """Whether parts of a frame can be rendered; ValueError if not even the frame can be."""
    request = combinations.Request(
        integrator=integrator, rays=Embree(), visibility=visibility, use=use
    )
    combinations.check(request)
    try:
        combinations.check(replace(request, parts=2))
    except ValueError:
        return False
    return True


def _checked(
    check: Sample, wanted: Searched, pilots: list[Pilot], target: float, metric: ErrorMetric
) -> Tuned:
    """The best pilot's value, measured on pixels that no pilot saw."""
    value = best(pilots, target, whole=wanted.span.whole).value
    visibility, use = wanted.at(value)
    found = check.measured((visibility, use))
    return Tuned(
        target=target,
        parameter=wanted.parameter,
        value=value,
        visibility=visibility,
        use=use,
        metric=metric,
        rel_l1=found.errors["rel_l1"],
        rel_l1_reflected=found.errors["rel_l1_reflected"],
        interval=found.interval,
        ray_reduction=found.ray_reduction,
        pilots=tuple(sorted(pilots, key=lambda p: p.value)),
        samples=check.count,
        groups=found.groups,
        seconds=found.seconds,
        seconds_exact=check.seconds_exact,
    )
