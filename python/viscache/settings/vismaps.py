"""Settings of rendering with visibility maps."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from numbers import Real
from typing import Any, Literal, Protocol, TypeAlias

from viscache import _core
from viscache.settings.checks import require
from viscache.settings.maps import MapSettings
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

    Directions are drawn by light × reflection (`Direct(environment="product")` does that alone).
    With `use="correct"`, the default, every one is traced and the maps of nearby records are a
    control variate: less noise, no bias. With `use="replace"` their integral J is the answer,
    without rays: biased, free of noise. Other lights are traced exactly.

    Parameters
    ----------
    cache : VisibilityMapCache, optional
        A cache of the scene, whose own settings hold then, those here of the same names do not.
        None: a new one for every frame.
    update : bool, optional
        Give records to pixels of this image that want one before it is rendered. By default a new
        cache gets them and a cache that is given stays as it is: rendering changes it only where
        `update=True` or `count_misses=True` asks for that.
    count_misses : bool
        Count in the cache how often its records were wrong about the frame's rays, which
        `VisibilityMapCache.end_frame` removes them by. Rays of guided densities count in proportion
        to product sampling, whose share of wrong answers `eps_max` thus means either way.
    alpha : {"previous_pass", "loo", "one", "zero"} or float
        The control variate's coefficient. "previous_pass": by regression on the samples of all
        earlier passes of the pixel, in the first pass by `first_alpha`. "loo":
        on the other samples of the pass, for `Direct(points="independent")` only. "one": the paper.
        "zero": product sampling alone.
    first_alpha : {"pilot", "one"}
        α of the first pass with "previous_pass": regressed on the samples of a trial on some
        pixels, or the paper's.
    sampling : {"auto", "product", "guided"}
        "guided": the maps, dilated, shape the density too. "product": the paper. "auto": guided
        where a trial on some pixels promises a tenth less variance.
    eta : float in (0, 1]
        Floor of guided densities, relative to product sampling; 1 is product sampling.
    preset, m, n_startup, d_max, ...
        How records are made: see `MapSettings`.
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
        require(self.alpha != "oracle", 'alpha must not be "oracle": it sums over the true '
                "visibility, which viscache.vismap.simulation alone has", self.alpha)  # fmt: skip
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

    def map_settings(self) -> MapSettings:
        """The part that makes records."""
        return MapSettings(**{f.name: getattr(self, f.name) for f in fields(MapSettings)})

    def estimate(self, replace: bool, points: _core.PointSet) -> _core.VisMapSettings:
        """The C++ settings of the estimator.

        Raises
        ------
        ValueError
            alpha="loo" with points that depend on each other.
        """
        even = points == _core.PointSet.ZERO_TWO
        require(not (self.alpha == "loo" and even),
                'points must be "independent" with alpha="loo"', "even")  # fmt: skip
        modes = {"previous_pass": _core.AlphaMode.PREVIOUS_PASS,
                 "loo": _core.AlphaMode.LEAVE_ONE_OUT}  # fmt: skip
        word = self.alpha if isinstance(self.alpha, str) else ""
        value = {"zero": 0.0}.get(word, 1.0) if word else float(self.alpha)
        return _core.VisMapSettings(
            alpha=modes.get(word, _core.AlphaMode.FIXED), alpha_value=value,
            pilot_alpha=self.first_alpha == "pilot", sampling=self.sampling, eta=self.eta,
            replace=replace, points=points,
        )  # fmt: skip

    def parameters(self) -> dict[str, Any]:
        """Names and values, JSON-able: of the cache's own settings where one is given."""
        made = self.cache.settings if self.cache else self.map_settings()
        return made.parameters() | {
            "cache": self.cache is not None, "update": self.updates,
            "count_misses": self.count_misses, "alpha": self.alpha,
            "first_alpha": self.first_alpha, "sampling": self.sampling, "eta": self.eta,
        }  # fmt: skip
