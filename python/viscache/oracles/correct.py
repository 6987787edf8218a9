"""Any cache as a control variate."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, ClassVar, Literal

from viscache import _core
from viscache.settings.checks import require
from viscache.settings.parameter_rows import ParameterRows, RowSettings
from viscache.settings.spelling import setting
from viscache.settings.visibility import VisMaps

#: Where the share reaches 1 unless told otherwise; for `NeePlusPlus`, its own setting is.
CERTAIN = 1 / 32
USES = (None, "replace", "correct")
ROWS = ParameterRows(_core.CorrectSettings)


@setting
@ROWS.documented
@dataclass(frozen=True, kw_only=True, slots=True)
class Correct(RowSettings):
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
    {parameters}

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

    ROWS: ClassVar[ParameterRows] = ROWS
    share: float | None = ROWS.default("share")
    certain: float | Literal["auto"] = ROWS.default("certain")
    classes: Literal["learned", "same"] = ROWS.default("classes")


def check_use(use: Any) -> None:
    """Refuse what is no way to use an approximation of single connections."""
    fits = isinstance(use, Correct) or (isinstance(use, str | None) and use in USES)
    require(fits, 'use must be "replace", "correct" or vc.Correct(...)', use)


def in_words(use: Any) -> Any:
    """How an approximation is used, as frames and sweeps record it: JSON-able."""
    return {"name": "correct", **asdict(use)} if isinstance(use, Correct) else use


def use_in_words(use: Any, visibility: Any) -> Any:
    """How the approximation is used, with the default of its method, as frames record it."""
    return in_words(use) or ("correct" if isinstance(visibility, VisMaps) else "replace")
