"""Any cache as a control variate."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, Literal

from viscache.settings.checks import check_types, require
from viscache.settings.spelling import setting
from viscache.settings.visibility import VisMaps

__all__ = ["Correct", "in_words", "use_in_words"]


#: Where the share reaches 1 unless told otherwise; for `NeePlusPlus`, its own setting is.
CERTAIN = 1 / 32


@setting
@dataclass(frozen=True, kw_only=True, slots=True)
class Correct:
    """How `use="correct"` draws: Ṽ + (V - Ṽ)/q for a random share q of the queries.

    The cache answers every query. Rays check a random share q of the answers, and weights correct
    the wrong ones. So the frame is right in expectation for any cache, with noise where the cache
    is wrong. At q = 1 it is the exact frame, byte for byte. Lights that the cache answers exactly
    (`Aqvc(exact_groups=...)`) need no corrections and get none. Unless others are named, these are
    own samples of area lights and skies, and up to 32 lights that all eye points share.

    `frame.counters` has "corrections", the checked answers, and "wrong", those of them that the ray
    contradicts; "exact_queries" are those of lights that need no corrections. With a number as
    share, their ratio is an unbiased estimate of the share of wrong answers. "share_by_class" has
    queries, corrections and wrong ones by light group and class: whether the cache's cells agreed
    or the answer is doubted, whether it is visible or blocked, and whether a neighbouring light has
    the other answer. The layer "variance" (H, W, 3) estimates the variance that the corrections add
    to each pixel: Σ (w·c)²·(1 - q) over the wrong answers found, which has the right expectation
    where the samples of a pixel are drawn apart, and errs towards more where they take turns.

    Parameters
    ----------
    share : float in (0, 1], optional
        q, the same for all queries. By default q follows the unoccluded contribution c of a
        connection with shared lights to its pixel: 1 where c is `certain` of a reference, and half
        as much with each halving of c, down to 1/256. The reference is √(a·(b + m/20)), at most m:
        a is the light that the group would bring to the eye point without shadows, b the part of it
        that the cache sees, and m the mean of a over the picture. For picked lights it is a. Then
        few rays remove most of the error: its square counts c², over the picture or relative to
        each pixel. The samples of a pixel take turns, also those of frames that go on from each
        other: a connection with q = 1/16 is drawn in one of sixteen. Samples of single eye points
        and connections of `Bdpt` have q = 0.1.

        The draw depends on the frame's seed and first sample, and on the positions of both ends.

    certain : float > 0 or "auto"
        Without a share: where q reaches 1. Half as much draws up to twice as many rays, and halves
        the noise of corrections. "auto": 1/32. In `vc.Progressive` the first two passes then tell
        by which power of two shares have the least error · cost in later ones, by their noise and
        by counted rays; or that exact visibility has less, which later passes then have, with a
        warning. Where it has far less, the first pass tells.
    classes : {"learned", "same"}
        Without a share, in `vc.Progressive`: "learned": the first two passes tell how often answers
        of a class are wrong (p), and in later ones q follows c·√p, in steps of two. Their draws are
        independent of those of the first two. "same": all classes have the same shares. Single
        frames have learnt nothing.

    Examples
    --------
    >>> import viscache as vc
    >>> scene, cache = vc.scenes.cube_on_plane(), vc.Aqvc(c_e=16, exact_groups=())
    >>> exact = vc.render(scene, vc.Direct(), size=(32, 20))
    >>> frame = vc.render(
    ...     scene, vc.Direct(), visibility=cache, use=vc.Correct(share=1), size=(32, 20)
    ... )
    >>> frame.sha256 == exact.sha256
    True
    """

    share: float | None = None
    certain: float | Literal["auto"] = "auto"
    classes: Literal["learned", "same"] = "learned"

    def __post_init__(self) -> None:
        check_types(self)
        fits = self.share is None or 0 < self.share <= 1
        require(fits, "share must be in (0, 1]", self.share)
        fits = self.certain == "auto" or 0 < self.certain < float("inf")
        require(fits, "certain must be > 0 and finite", self.certain)


def in_words(use: Any) -> Any:
    """How an approximation is used, as frames and sweeps record it: JSON-able."""
    return {"name": "correct", **asdict(use)} if isinstance(use, Correct) else use


def use_in_words(use: Any, visibility: Any) -> Any:
    """How the approximation is used, with the default of its method, as frames record it."""
    return in_words(use) or ("correct" if isinstance(visibility, VisMaps) else "replace")
