"""Settings of rendering with visibility maps."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any, Literal, Protocol

from viscache import _core
from viscache.settings.checks import require
from viscache.settings.maps import MapSettings
from viscache.settings.parameter_rows import ParameterRows, RowSettings
from viscache.settings.registry import registered
from viscache.settings.source_context import SourceContext

ESTIMATE = ParameterRows(_core.VisMapSettings)
FIELDS = tuple(f.name for f in fields(MapSettings))


class RecordCache(Protocol):
    """What `VisMaps` asks of a `VisibilityMapCache`, which is built over a scene, far above."""

    @property
    def settings(self) -> MapSettings:
        """How its records are made."""


@registered("visibility", "vismap", product=True, bdpt=False, audit=False)
@ESTIMATE.documented
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
    {parameters}
    preset, m, n_startup, d_max, ...
        Settings of the records: see `MapSettings`.
    """

    cache: RecordCache | None = None
    update: bool | None = None
    count_misses: bool = False
    alpha: float | Literal["previous_pass", "loo", "one", "zero"] = ESTIMATE.default("alpha")
    first_alpha: Literal["pilot", "one"] = ESTIMATE.default("first_alpha")
    sampling: Literal["auto", "product", "guided"] = ESTIMATE.default("sampling")
    eta: float = ESTIMATE.default("eta")

    def __post_init__(self) -> None:
        require(
            str(self.alpha) != "oracle",
            'alpha must not be "oracle": it sums over the true '
            "visibility, which viscache_lab.cases.simulation alone has",
            self.alpha,
        )
        RowSettings.__post_init__(self)
        own = self.cache is None or isinstance(getattr(self.cache, "settings", None), MapSettings)
        require(own, "cache must be a VisibilityMapCache", self.cache)
        require(self.criterion == "visibility", 'criterion must be "visibility"', self.criterion)
        self.estimate()

    @property
    def updates(self) -> bool:
        """Whether a frame adds records to its cache."""
        return self.cache is None if self.update is None else self.update

    def source(self, context: SourceContext) -> _core.OracleSource:
        """The source of one frame's oracles: rays are exact beside the maps."""
        return _core.ExactSource(context.scene, context.caster)

    def map_settings(self) -> MapSettings:
        """The settings of the records."""
        return MapSettings(**{name: getattr(self, name) for name in FIELDS})

    def estimate(self) -> _core.VisMapSettings:
        """The C++ settings of the estimator."""
        made: _core.VisMapSettings = ESTIMATE.core(self)
        return made

    def parameters(self) -> dict[str, Any]:
        """Names and values for JSON; with a cache, its own settings."""
        records = self.map_settings() if self.cache is None else self.cache.settings
        own = {n: v for n, v in RowSettings.parameters(self).items() if n not in FIELDS}
        return (
            records.parameters() | own | {"cache": self.cache is not None, "update": self.updates}
        )
