"""Parameters from a target: pilots, checked on pixels that they did not see."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

from viscache.base.progress import Progress, progress_bar
from viscache.oracles.correct import Correct
from viscache.scene import Scene
from viscache.scene.cameras import find_camera, frame_size
from viscache.scenes import sources
from viscache.settings import combinations
from viscache.settings.checks import is_whole, require
from viscache.settings.integrators import AmbientOcclusion, Direct, Whitted
from viscache.settings.spelling import spelled
from viscache.settings.visibility import Exact, VisMaps
from viscache.shot.frame_plan import check_settings
from viscache.shot.shot import BareShot, ShotArguments, of_shot
from viscache.sweeps.jointly import MOST_MORE, MOST_TRIALS, families, jointly, with_light_cells
from viscache.sweeps.samples import METRICS, ErrorMetric, Sample, samples
from viscache.sweeps.search import MOST_PILOTS, best, search
from viscache.sweeps.searched import Searched, searched
from viscache.sweeps.tuned import OWN_SAMPLES, Pilot, Tuned
from viscache.sweeps.tuned_passes import tuned_passes

if TYPE_CHECKING:
    from typing_extensions import Unpack

__all__ = ["Pilot", "Tuned", "tune"]

#: Pilots aim at this share of an error, since other pixels have a little more or less.
BELOW = 0.95

T = TypeVar("T")


@spelled
@of_shot(visibility="aqvc")
def tune(
    scene: Scene | str | os.PathLike[str],
    integrator: Any = None,
    *,
    rel_l1_reflected: float | None = None,
    rel_l1: float | None = None,
    flip: float | None = None,
    seconds: float | None = None,
    parameter: str | Mapping[str, tuple[float, float]] | None = None,
    passes: bool = False,
    progress: Progress = False,
    **shot: Unpack[ShotArguments],
) -> Tuned:
    """Settings with a wanted error against exact visibility, or the least error in some time.

    Of the quantized cache these are C_E, `c_finest` and `bright`: of all that reach the target,
    those with the fewest rays. If pixels have samples of their own (of a sky, of area lights, of
    ambient light), C_L is chosen too: it is halved until the error that no C_E lowers is at most
    half of the target. Of other caches it is one parameter.

    Parameters
    ----------
    scene, use, rays, size, spp, seed, threads, camera, env
        The frame that will be rendered: see `viscache.Shot`.
    integrator : Direct, Whitted or AmbientOcclusion
        Or its name. Its directions not shared.
    visibility : Aqvc, ShadowMap, NeePlusPlus, VisMaps or your own, optional
        The cache with its other parameters; `Aqvc()` by default. A C_E per light group stays, and
        `c_l`, `c_finest` and `bright` that are given.
    rel_l1_reflected : float, optional
        The wanted error, a relative L1 of the light on surfaces; in (0, 1). 0.01 by default, if no
        other target is given.
    rel_l1 : float, optional
        Or of all light of the picture, as in the paper. Lamps and a sky in the picture make this
        error smaller, but not the errors that one sees.
    flip : float, optional
        Or the wanted mean HDR-FLIP, in (0, 1). It looks at whole frames, so large ones take longer.
    seconds : float, optional
        Or the seconds of the clock that a frame may take, whose error should be small. If an exact
        frame fits, it is chosen. Times vary, so two calls may choose differently; with another
        target the choice is always the same.
    parameter : str or {name: (low, high)}, optional
        The number to search, and where; the range is needed but for C_E. It is a parameter of the
        cache, or "use.share" with `use=vc.Correct(...)`.
        With "c_e", C_E alone is searched.
        The error may rise or fall with it. Steps have equal ratios if `low` is positive. Whole
        numbers stay whole.
    passes : bool
        Choose passes of `vc.Progressive` instead of one frame: exact ones, those of the cache with
        corrections, or exact ones with `pick=16` or 64 (of an integrator that picks none),
        whichever are cheaper, and how many. The error is then the noise of the picture, not the
        difference to an exact one of the same samples. `Tuned.integrator` has the picks.
    progress : bool or callable
        True shows a bar; a callable gets (done, total) renderings. The total may shrink.

    Returns
    -------
    Tuned
        `outcome` says whether pixels that no pilot saw confirm the error. If no value reaches the
        target, the value with the smallest error is returned, and `message` says which light group
        limits it. If every value has a smaller error, the value with the largest is returned.
        `exact_is_cheaper` says whether an exact frame takes less time, and `message` has both
        times.

    Raises
    ------
    ValueError
        Two targets, a parameter out of range or one that is not there, or a picture without light.

    Notes
    -----
    A 16th of a large frame's tiles, at least 24, serves for the pilots, and as many others for the
    check; of smaller frames one half and the other. Of frames of less than eight tiles, for FLIP,
    and for caches that do not work in parts of frames (docs/limits.md), the pilots see a frame of
    the same lights and other eye samples, and the frame itself checks the result. Pilots aim a
    little below the target.

    Examples
    --------
    >>> import viscache as vc
    >>> room = vc.scenes.room(triangles=2000)
    >>> vc.tune(room, vc.Direct(), rel_l1_reflected=0.02, size=(64, 40)).outcome
    'within noise'
    >>> maps = vc.ShadowMap()
    >>> found = vc.tune(
    ...     room, vc.Direct(), rel_l1_reflected=0.02, visibility=maps, size=(64, 40),
    ...     parameter={"resolution": (16, 1024)},
    ... )
    >>> found.outcome != "missed", found.visibility.resolution == found.value
    (True, True)
    """
    judged, target = _target(
        rel_l1_reflected=rel_l1_reflected, rel_l1=rel_l1, flip=flip, seconds=seconds
    )
    given = BareShot(scene, integrator, **shot)
    integrator, cache, use = given.setting("integrator"), given.setting("visibility"), given.use
    known = "vc.Direct(...), vc.Whitted(...) or vc.AmbientOcclusion(...)"
    fits = isinstance(integrator, Direct | Whitted | AmbientOcclusion)
    require(fits, f"integrator must be {known}", integrator)
    fits = is_whole(given.seed) and 0 <= given.seed < 1 << 62
    require(fits, "seed must be in [0, 2^62)", given.seed)
    require(isinstance(passes, bool), "passes must be True or False", passes)
    lit, rays = sources.opened(given.opened), given.setting("rays")
    check_settings(lit, integrator, rays, cache, use, None)
    given = given.with_(scene=lit, seed=int(given.seed))
    if use == "correct" and not isinstance(cache, VisMaps):
        use = Correct()
    if passes:
        alone = parameter is None and use in (None, Correct())
        require(alone, "parameter and use must be left out with passes", parameter or use)
        require(judged == "rel_l1_reflected", "passes are tuned by rel_l1_reflected", judged)
        return tuned_passes(given, cache, target, seconds is not None, progress)
    wanted = searched(cache, use, parameter)
    in_parts = _works_in_parts(integrator, rays, cache, use)
    size = frame_size(given.size, find_camera(lit, given.camera))
    if given.env is not None:
        lit = lit.with_environment(given.env, threads=given.threads)
    make_pilot, make_check = samples(
        given.with_(scene=lit, env=None, size=size), in_parts=in_parts, metric=judged
    )
    with _steps(progress, wanted) as step:
        pilot = step(make_pilot)
        if seconds is not None and pilot.wall_exact_s <= target:
            return _exact(step(make_check), wanted, target, judged)
        if wanted.is_c_e and not pilot.groups.isdisjoint(OWN_SAMPLES):
            # A time has no error to leave half of: light cells stay as they are
            chosen = wanted.visibility
            if seconds is None:
                chosen = with_light_cells(
                    lambda tried: step(lambda: pilot.measured((tried, use))).groups,
                    wanted.visibility,
                    target,
                )
            wanted = replace(wanted, visibility=chosen)

        def measure(value: float, also: Mapping[str, float] | None = None) -> Pilot:
            found = step(lambda: pilot.measured(wanted.at(value, also)))
            error, rays = found.errors[judged], found.ray_reduction
            return Pilot(value, error, rays, wanted.parameter, dict(also or {}), found.wall_s)

        aim = _Aim(target, seconds is not None)
        pilots, one = aim.searched(measure, wanted)
        check = step(make_check)
        return step(lambda: _checked(check, wanted, pilots, one, aim, judged))


def _target(**targets: float | None) -> tuple[ErrorMetric, float]:
    """The metric that is judged, and the one target that is given."""
    given = {name: value for name, value in targets.items() if value is not None}
    require(len(given) <= 1, f"one target must be given: {' or '.join(targets)}", list(given))
    name, value = next(iter(given.items()), ("rel_l1_reflected", 0.01))
    number = isinstance(value, (int, float)) and not isinstance(value, bool)
    if name == "seconds":
        require(number and 0 < value < float("inf"), "seconds must be > 0 and finite", value)
    else:
        require(number and 0 < value < 1, f"{name} must lie in (0, 1)", value)
    judged = next((metric for metric in METRICS if metric == name), METRICS[0])
    return judged, float(value)


class _Aim:
    """What a search aims at: an error with few rays, or a time with a small error."""

    def __init__(self, target: float, by_time: bool) -> None:
        self.target, self.by_time = target, by_time

    def searched(
        self, measure: Callable[..., Pilot], wanted: Searched
    ) -> tuple[list[Pilot], Pilot]:
        """All pilots and the best one."""
        made: dict[int, Pilot] = {}
        goal = self.target * (1.0 if self.by_time else BELOW)

        def goals(value: float, also: Mapping[str, float] | None = None) -> Pilot:
            pilot = measure(value, also)
            shown = replace(pilot, error=pilot.wall_s) if self.by_time else pilot
            made[id(shown)] = pilot
            kept.append(shown)
            return shown

        def price(pilot: Pilot) -> float:
            if self.by_time:
                return made[id(pilot)].error
            return 1 / max(pilot.ray_reduction, 1e-12)

        kept: list[Pilot] = []
        span = wanted.span
        if self.by_time and span.rises is not None:
            span = replace(span, rises=not span.rises)
        tried = search(goals, goal, span)
        if wanted.is_joint:
            others = partial(families, wanted.visibility)
            finest = float(wanted.visibility.c_finest)
            tried, one = jointly(goals, tried, goal, span, others, price, finest)
        else:
            one = best(tried, goal, whole=span.whole)
        return [made[id(p)] for p in tried], made[id(one)]


def _exact(check: Sample, wanted: Searched, target: float, metric: ErrorMetric) -> Tuned:
    """An exact frame, whose time fits."""
    return Tuned(
        target=target,
        parameter=wanted.parameter,
        value=0.0,
        visibility=Exact(),
        metric=metric,
        rel_l1=0.0,
        rel_l1_reflected=0.0,
        flip=0.0 if metric == "flip" else None,
        interval=(0.0, 0.0),
        ray_reduction=1.0,
        pilots=(),
        samples=check.count,
        groups={},
        seconds=check.seconds_exact,
        seconds_exact=check.seconds_exact,
        wall_s=check.wall_exact_s,
        wanted="seconds",
    )


class _Step(Protocol):
    """Calls a function that renders."""

    def __call__(self, call: Callable[[], T]) -> T: ...


@contextmanager
def _steps(progress: Progress, wanted: Searched) -> Iterator[_Step]:
    """A function that calls its argument and reports that one more rendering is done."""
    total = 3 + MOST_PILOTS + (MOST_TRIALS if wanted.is_c_e else 0)
    total += MOST_MORE if wanted.is_joint else 0
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


def _works_in_parts(integrator: Any, rays: Any, visibility: Any, use: Any) -> bool:
    """Whether parts of a frame can be rendered; ValueError if not even the frame can be."""
    request = combinations.Request(integrator=integrator, rays=rays, visibility=visibility, use=use)
    combinations.check(request)
    try:
        combinations.check(replace(request, parts=2))
    except ValueError:
        return False
    return True


def _checked(
    check: Sample, wanted: Searched, pilots: list[Pilot], one: Pilot, aim: _Aim, metric: ErrorMetric
) -> Tuned:
    """The best pilot's values, measured on pixels that no pilot saw."""
    visibility, use = wanted.at(one.value, one.also)
    found = check.measured((visibility, use))
    return Tuned(
        target=aim.target,
        parameter=wanted.parameter,
        value=one.value,
        also=one.also,
        visibility=visibility,
        use=use,
        metric=metric,
        rel_l1=found.errors["rel_l1"],
        rel_l1_reflected=found.errors["rel_l1_reflected"],
        flip=found.errors.get("flip"),
        interval=found.interval,
        ray_reduction=found.ray_reduction,
        pilots=tuple(sorted(pilots, key=lambda p: (p.value, tuple(p.also.items())))),
        samples=check.count,
        groups=found.groups,
        seconds=found.seconds,
        seconds_exact=check.seconds_exact,
        wall_s=found.wall_s,
        wanted="seconds" if aim.by_time else "error",
    )
