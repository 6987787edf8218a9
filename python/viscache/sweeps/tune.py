"""A parameter from an error target: pilots, checked on pixels that they did not see."""

from __future__ import annotations

import os
from dataclasses import replace
from typing import Any

from viscache import combinations, sources
from viscache.oracles.correct import Correct
from viscache.oracles.written import Written
from viscache.render import check_settings
from viscache.scene import Scene
from viscache.scene.cameras import find_camera, frame_size
from viscache.settings import by_name
from viscache.settings.checks import is_whole, require
from viscache.settings.integrators import AmbientOcclusion, Direct, Whitted
from viscache.settings.rays import Embree
from viscache.settings.spelling import spelled
from viscache.settings.visibility import Visibility, VisMaps
from viscache.sweeps.light_cells import with_light_cells
from viscache.sweeps.samples import Sample, samples
from viscache.sweeps.search import best, search
from viscache.sweeps.searched import Searched, searched
from viscache.sweeps.tuned import OWN_SAMPLES, Pilot, Tuned

__all__ = ["Pilot", "Tuned", "tune"]


@spelled
def tune(
    scene: Scene | str | os.PathLike[str],
    integrator: Any,
    *,
    rel_l1: float = 0.01,
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
        The wanted error, relative L1 of the colour layer; in (0, 1).
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

    Returns
    -------
    Tuned
        `reached` says whether pixels that no pilot saw confirm the error. If no value reaches the
        target, the value with the smallest error is returned, and `message` says which light group
        limits it. If every value has a smaller error, the value with the largest is returned.

    Raises
    ------
    ValueError
        A parameter out of range or one that is not there, or a picture without light.

    Notes
    -----
    A 16th of a large frame's tiles, at least 24, serves for the pilots, and as many others for the
    check. Whole frames of other seeds serve for small frames, and for caches that do not work in
    parts of frames (docs/limits.md): one for the pilots, four for the check.

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
    pilot, check = samples(lit, integrator, given, int(seed), in_parts=in_parts)

    if wanted.is_c_e and not pilot.groups.isdisjoint(OWN_SAMPLES):
        chosen = with_light_cells(
            lambda tried: pilot.measured((tried, use)).groups, wanted.visibility, target
        )
        wanted = replace(wanted, visibility=chosen)

    def measure(value: float) -> Pilot:
        found = pilot.measured(wanted.at(value))
        return Pilot(value, found.rel_l1, found.ray_reduction, wanted.parameter)

    pilots = search(measure, target, wanted.span)
    return _checked(check, wanted, pilots, target)


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


def _checked(check: Sample, wanted: Searched, pilots: list[Pilot], target: float) -> Tuned:
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
        rel_l1=found.rel_l1,
        interval=found.interval,
        ray_reduction=found.ray_reduction,
        pilots=tuple(sorted(pilots, key=lambda p: p.value)),
        samples=check.count,
        groups=found.groups,
    )
