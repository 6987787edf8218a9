"""Settings of rendering with visibility maps."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from numbers import Real
from typing import Any, Literal, Protocol, TypeAlias

from viscache import _core
from viscache.settings.checks import require
from viscache.settings.maps import MapSettings
from viscache.settings.source_context import SourceContext
from viscache.settings.spelling import setting

__all__ = ["VisMaps"]

#: A word of `ALPHAS`, or a number.
Alpha: TypeAlias = str | float
ALPHAS = ("previous_pass", "loo", "one", "zero")


class RecordCache(Protocol):
    """What `VisMaps` asks of a `VisibilityMapCache`, which is built over a scene, far above."""

    @property
    def settings(self) -> MapSettings:
        """How its records are made."""


@setting
@dataclass(frozen=True, kw_only=True, slots=True)
class VisMaps(MapSettings):
    """Visibility maps for the environment's light (Clarberg, Akenine-Möller 2008).

    Directions are sampled by light × reflection (as with `Direct(environment="product")`). With
    `use="correct"`, the default of `render`, every direction is traced and the maps of nearby
    records are a control variate: less noise, no bias. With `render(…, use="replace")` their
    integral J is the result, without rays: biased, but without noise. Other lights are traced
    exactly.

    Parameters
    ----------
    cache : VisibilityMapCache, optional
        A cache of the scene. Its own settings then apply instead of those given here under the same
        names. None: a new cache for every frame.
    update : bool, optional
        Insert records where the pixels of this image need them, before it is rendered. By default a
        new cache gets them, and a given cache stays as it is: rendering changes it only if
        `update=True` or `count_misses=True` asks for that.
    count_misses : bool
        Count in the cache how often its records disagreed with the rays of the frame.
        `VisibilityMapCache.end_frame` removes records by these counts. Rays sampled with guided
        densities are weighted to product sampling, so `eps_max` is the error rate under product
        sampling in both cases.
    alpha : {"previous_pass", "loo", "one", "zero"} or float
        Coefficient of the control variate. "previous_pass": by regression on the samples of all
        earlier passes of the pixel; in the first pass by `first_alpha`. "loo": by regression on the
        other samples of the pass, only for `Direct(points="independent")`. "one": 1 as in the
        paper. "zero": product sampling alone.
    first_alpha : {"pilot", "one"}
        α of the first pass with "previous_pass": by regression on the samples of a pilot on some
        pixels, or 1 as in the paper.
    sampling : {"auto", "product", "guided"}
        "guided": the dilated maps also shape the density. "product": as in the paper. "auto":
        guided if a pilot on some pixels predicts at least a tenth less variance.
    eta : float in (0, 1]
        Minimum of guided densities relative to product sampling; 1 is product sampling.
    preset, m, n_startup, d_max, ...
        Settings of the records: see `MapSettings`.
    """

    cache: RecordCache | None = None
    update: bool | None = None
    count_misses: bool = False
    alpha: Alpha = "previous_pass"
    first_alpha: Literal["pilot", "one"] = "pilot"
    sampling: Literal["auto", "product", "guided"] = "auto"
    eta: float = 0.25

    def __post_init__(self) -> None:
        MapSettings.__post_init__(self)
        own = self.cache is None or isinstance(getattr(self.cache, "settings", None), MapSettings)
        require(own, "cache must be a VisibilityMapCache", self.cache)
        require(
            self.alpha != "oracle",
            'alpha must not be "oracle": it sums over the true '
            "visibility, which viscache.vismap.simulation alone has",
            self.alpha,
        )
        if isinstance(self.alpha, str):
            fits = self.alpha in ALPHAS
        else:
            number = isinstance(self.alpha, Real) and not isinstance(self.alpha, bool)
            fits = number and math.isfinite(self.alpha)
        require(fits, f"alpha must be one of {ALPHAS} or a finite number", self.alpha)
        first = self.first_alpha in ("pilot", "one")
        require(first, 'first_alpha must be "pilot" or "one"', self.first_alpha)
        require(0 < self.eta <= 1, "eta must be in (0, 1]", self.eta)
        require(self.criterion == "visibility", 'criterion must be "visibility"', self.criterion)

    @property
    def updates(self) -> bool:
        """Whether a frame adds records to its cache."""
        return self.cache is None if self.update is None else self.update

    def source(self, context: SourceContext) -> _core.OracleSource:
        """The source of one frame's oracles: rays are exact beside the maps."""
        return _core.ExactSource(context.scene, context.caster)

    def map_settings(self) -> MapSettings:
        """The settings of the records."""
        return MapSettings(**{f.name: getattr(self, f.name) for f in fields(MapSettings)})

    def estimate(self, replace: bool, points: _core.PointSet) -> _core.VisMapSettings:
        """The C++ settings of the estimator.

        Raises
        ------
        ValueError
            alpha="loo" is combined with dependent points.
        """
        even = points == _core.PointSet.ZERO_TWO
        fits = not (self.alpha == "loo" and even)
        require(fits, 'points must be "independent" with alpha="loo"', "even")
        modes = {
            "previous_pass": _core.AlphaMode.PREVIOUS_PASS,
            "loo": _core.AlphaMode.LEAVE_ONE_OUT,
        }
        word = self.alpha if isinstance(self.alpha, str) else ""
        value = {"zero": 0.0}.get(word, 1.0) if word else float(self.alpha)
        return _core.VisMapSettings(
            alpha=modes.get(word, _core.AlphaMode.FIXED),
            alpha_value=value,
            pilot_alpha=self.first_alpha == "pilot",
            sampling=self.sampling,
            eta=self.eta,
            replace=replace,
            points=points,
        )

    def parameters(self) -> dict[str, Any]:
        """Names and values for JSON; with a cache, its own settings."""
        made = self.map_settings() if self.cache is None else self.cache.settings
        return made.parameters() | {
            "cache": self.cache is not None,
            "update": self.updates,
            "count_misses": self.count_misses,
            "alpha": self.alpha,
            "first_alpha": self.first_alpha,
            "sampling": self.sampling,
            "eta": self.eta,
        }
