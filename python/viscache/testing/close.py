"""A picture is close to the exact one."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from viscache import metrics
from viscache.metrics import Comparable, Metrics
from viscache.settings.spelling import spelled
from viscache.testing.advice import unlike, what_to_try
from viscache.testing.failure import PictureError, lines, told
from viscache.testing.limits import Limit, checked

#: Where no limit is given.
DEFAULT_LIMITS: dict[str, float | None] = {"rel_l1": 0.02, "energy": 0.01}


@spelled
def assert_close(
    frame: Comparable | Sequence[Comparable],
    exact: Comparable | Sequence[Comparable],
    *,
    rel_l1: float | None = None,
    rel_l1_reflected: float | None = None,
    energy: float | None = None,
    rmse: float | None = None,
    rel_mse: float | None = None,
    flip: float | None = None,
    ssim: float | None = None,
    max_abs: float | None = None,
) -> Metrics:
    """Raise an AssertionError unless a picture is close to the exact one.

    Parameters
    ----------
    frame, exact : Frame or (H, W, C) array, or a sequence of them
        Scene-linear pictures of one size: the one to test, and its reference. Of repeats (pairs of
        frames with different seeds), the whole 95 % interval of the mean must be within the limit.
    rel_l1, rel_l1_reflected, rmse, rel_mse, flip, max_abs : float >= 0, optional
        The most that this metric may be (`viscache.metrics`).
    energy : float >= 0, optional
        The most that it may be, both ways.
    ssim : float in [0, 1], optional
        The least that it may be.

    Returns
    -------
    Metrics
        The metrics that have limits.

    Raises
    ------
    PictureError
        An AssertionError: a limit is not met, a metric is undefined (as with a black reference),
        sizes differ, or pixels are not finite. The message has the numbers and what to try.
    ValueError
        A limit is no number >= 0.

    Notes
    -----
    Without any limit, `rel_l1=0.02` and `energy=0.01` hold. Compare frames of equal seed and
    samples: only then is the difference the error of the cache.

    Examples
    --------
    >>> import viscache as vc
    >>> scene = vc.scenes.cube_on_plane()
    >>> exact = vc.render(scene, vc.Direct(), size=(64, 40))
    >>> frame = vc.render(scene, vc.Direct(), size=(64, 40), visibility=vc.Aqvc(c_e=1))
    >>> sorted(vc.testing.assert_close(frame, exact, rel_l1=0.02, energy=0.01))
    ['energy', 'rel_l1']
    """
    __tracebackhide__ = True
    given = {
        "rel_l1": rel_l1,
        "rel_l1_reflected": rel_l1_reflected,
        "energy": energy,
        "rmse": rmse,
        "rel_mse": rel_mse,
        "flip": flip,
        "ssim": ssim,
        "max_abs": max_abs,
    }
    limits = checked(given if any(v is not None for v in given.values()) else DEFAULT_LIMITS)
    try:
        measured = metrics.compare(frame, exact, metrics=[limit.metric for limit in limits])
    except ValueError as error:  # sizes differ, or pixels are not finite
        raise PictureError(f"the pictures cannot be compared: {error}") from None
    missed = [limit for limit in limits if not limit.holds(measured)]
    if missed:
        raise _error(frame, exact, limits, missed, measured)
    return measured


def _error(
    frame: Any, exact: Any, limits: list[Limit], missed: list[Limit], measured: Metrics
) -> PictureError:
    """The error, with the worst pair of repeats."""
    pictures = list(frame) if isinstance(frame, (list, tuple)) else [frame]
    references = list(exact) if isinstance(exact, (list, tuple)) else [exact] * len(pictures)
    samples = [v if v is not None else np.inf for v in measured.samples[missed[0].metric]]
    lowest = missed[0].metric == "ssim"
    worst = int(np.argmin(samples) if lowest else np.argmax(np.abs(samples)))
    a, b = pictures[worst], references[worst]
    numbers = {limit.metric: limit.told(measured) for limit in limits}
    rows = {**numbers, **_largest(a, b), "picture": told(a), "exact": told(b)}
    what = " and ".join(f"{limit.metric} must be {limit}" for limit in missed)
    repeats = f" (means of {measured.repeats} pairs; the worst is shown)"
    head = f"not close to the exact picture: {what}{repeats * (measured.repeats > 1)}"
    advice = unlike(a, b) or what_to_try(a, b, missed)
    return PictureError(lines(head, rows, advice), a, b, numbers)


def _largest(frame: Comparable, exact: Comparable) -> dict[str, str]:
    """Where the largest difference is, and how many pixels differ."""
    a, b = (np.asarray(getattr(p, "image", p), np.float64) for p in (frame, exact))
    a, b = (p.reshape(*p.shape[:2], -1)[:, :, :3] for p in (a, b))
    off = np.abs(a - b).sum(axis=2)
    row, column = (int(i) for i in np.unravel_index(np.argmax(off), off.shape))
    values = [np.array2string(p[row, column], precision=4, separator=", ") for p in (a, b)]
    count = int((off > 0).sum())
    return {
        "largest at": f"row {row}, column {column}: {values[0]}, exact {values[1]}",
        "pixels": f"{count} of {off.size} differ ({count / off.size:.1%})",
    }
