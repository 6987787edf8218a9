"""What an audit of a frame checks by exact rays: whole pixels, or single queries."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, TypeAlias

from viscache import _core
from viscache.settings.checks import check_types, require
from viscache.settings.spelling import nearest, setting

#: Fewer pixels give intervals that hold the error too rarely.
LEAST_PIXELS = 1024
MOST_PIXELS = 1 << 24


@setting
@dataclass(frozen=True, kw_only=True, slots=True)
class AuditPixels:
    """An audit of whole pixels: estimates of the error of a frame, with intervals.

    Exact rays answer all queries of all samples of `n` pixels. These are a random sample of the
    frame, stratified along the Morton curve and drawn by the most light without shadows of a pixel
    within two, with the seed and first sample as key. A frame of `n` pixels or fewer is audited
    whole. There is an interval of rel_l1 if `n` is at most an eighth of the pixels, or all, and if
    50 of them are wrong; of nrmse only if all are audited, because samples tend to lack the few
    pixels that decide it. `Estimate.why` says why there is none. Errors in pixels with less than
    about 3/n of the light without shadows may not be drawn at all.

    Parameters
    ----------
    n : int in [1024, 2^24]
        Number of pixels, an odd one rounded up. Four times as many halve the intervals.

    Examples
    --------
    >>> import viscache as vc
    >>> frame = vc.render(
    ...     "slits",
    ...     vc.Whitted(n_vpls=16),
    ...     visibility=vc.Aqvc(exact_groups=()),
    ...     size=(160, 100),
    ...     audit=vc.AuditPixels(n=2000),
    ... )
    >>> error = frame.audit.rel_l1
    >>> frame.audit.pixels, error.low < error.value < error.high
    (2000, True)
    """

    n: int = 1024

    def __post_init__(self) -> None:
        check_types(self)
        fits = LEAST_PIXELS <= self.n <= MOST_PIXELS
        require(fits, f"n must be in [{LEAST_PIXELS}, 2^24]", self.n)


@setting
@dataclass(frozen=True, kw_only=True, slots=True)
class AuditQueries:
    """An audit of single queries: the bias of a frame and its share of wrong answers.

    Exact rays answer all connections whose contribution exceeds `above` means of their eye point or
    of its tile, and a random share of the others. The sum of wrong answers estimates the bias:
    light too much or too little. It says nothing about rel_l1, because the absolute error of a
    pixel is not a sum over its queries.

    Parameters
    ----------
    share : float in (0, 1]
    above : float >= 0

    Examples
    --------
    >>> import viscache as vc
    >>> frame = vc.render(
    ...     "slits",
    ...     vc.Whitted(n_vpls=16),
    ...     visibility=vc.Aqvc(exact_groups=()),
    ...     size=(80, 50),
    ...     audit=vc.AuditQueries(share=1),
    ... )
    >>> frame.audit.wrong.value > 0, frame.audit.bias.value < 0
    (True, True)
    """

    share: float = 0.01
    above: float = 4.0

    def __post_init__(self) -> None:
        check_types(self)
        require(0 < self.share <= 1, "share must be in (0, 1]", self.share)
        require(0 <= self.above < 1e6, "above must be in [0, 1e6)", self.above)


Audit: TypeAlias = AuditPixels | AuditQueries

NAMES: dict[str, type[AuditPixels] | type[AuditQueries]] = {
    "pixels": AuditPixels,
    "queries": AuditQueries,
}


def checked(audit: Any) -> Audit | None:
    """The settings of an audit, from a name too; ValueError for anything else."""
    if audit is None or isinstance(audit, AuditPixels | AuditQueries):
        return audit
    if isinstance(audit, str) and audit in NAMES:
        return NAMES[audit]()
    near = nearest(audit, NAMES) if isinstance(audit, str) else ""
    must = 'audit must be "pixels", "queries", vc.AuditPixels(...) or vc.AuditQueries(...)'
    raise ValueError(f"{must}, got {audit!r}{near}")


def in_words(audit: Audit) -> dict[str, Any]:
    """The settings as frames record them."""
    return {"name": type(audit).__name__, **asdict(audit)}


def set_audit(frame: _core.FrameSettings, audit: Audit) -> None:
    """Make a frame audit."""
    if isinstance(audit, AuditPixels):
        frame.audit_pixels = audit.n
    else:
        frame.audit_share, frame.audit_above = audit.share, audit.above
