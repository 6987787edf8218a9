"""Tells from a frame's counters where the cache costs more than exact visibility, or as much."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

#: Fewer queries take less than some hundredths of a second either way.
LEAST_QUERIES = 1 << 18
#: Samples of each pixel's own that cost more than this share of exact ones are not worth their
#: errors, which show as squares.
LITTLE_GAIN = 2 / 3
#: What serves groups of such samples better than a cache.
BETTER = {
    "area": "vc.Exact()",
    "environment": 'vc.Exact(), or environment="shared" with the cache',
    "ambient": 'vc.Exact(), or directions="shared" with it',
}


@dataclass(frozen=True, slots=True)
class Cost:
    """The cost of a query through the cache, in queries of exact visibility.

    It is `fixed + per_ray · rays / queries`. Seconds depend on the machine and its load; these
    ratios hardly do (docs/aqvc.md).
    """

    fixed: float
    per_ray: float

    def of(self, rays_per_query: float) -> float:
        """The cost at so many rays per query; above 1 exact visibility is cheaper."""
        return self.fixed + self.per_ray * rays_per_query

    @property
    def limit(self) -> float:
        """Rays per query at which both cost the same."""
        return (1 - self.fixed) / self.per_ray


#: Lights that all eye points share are looked up by rows of bits: nearly all of the cost is rays.
SHARED_LIGHTS = Cost(0.1, 1.5)
#: Samples of each eye point's own are sorted to rows of light cells first.
OWN_SAMPLES = Cost(0.6, 1.2)


def cost_warnings(parameters: Mapping[str, Any], counters: Mapping[str, Any]) -> list[str]:
    """A warning for each light group whose queries cost more than exact ones, or hardly less.

    Of frames of the quantized cache in its default form. Groups that exact rays answered have none.
    """
    visibility, integrator = parameters["visibility"], parameters["integrator"]
    if visibility["name"] != "Aqvc" or visibility["form"] != "waves" or "keep" in parameters:
        return []
    if integrator["name"] == "Bdpt":
        return []
    texts = []
    for group, count in counters["groups"].items():
        queries, rays = count["queries"], count["rays"]
        own = group in ("area", "ambient")
        own = own or (group == "environment" and integrator["environment"] != "shared")
        if queries >= LEAST_QUERIES and not _is_exact(count, counters):
            texts += _warning(group, rays / queries, OWN_SAMPLES if own else SHARED_LIGHTS)
    return texts


def _is_exact(count: Mapping[str, Any], counters: Mapping[str, Any]) -> bool:
    """Whether rays outside of the cache answered all queries of a group."""
    of_cache = sum(counters.get("rays_per_level", ())) + counters.get("leftover_rays", 0)
    outside = counters.get("rays", of_cache) - of_cache
    return bool(count["rays"] == count["queries"] <= outside)


def _warning(group: str, rays_per_query: float, model: Cost) -> list[str]:
    cost, better = model.of(rays_per_query), BETTER.get(group, "vc.Exact(), or a larger c_e")
    if cost > 1:
        return [
            f"light group {group!r}: exact visibility is cheaper than the cache. It traced"
            f" {rays_per_query:.2f} rays per query and pays below {model.limit:.2f}: use {better}"
        ]
    if model is OWN_SAMPLES and cost > LITTLE_GAIN:
        return [
            f"light group {group!r}: the cache saves about {1 - cost:.0%} of the cost of exact"
            f" visibility ({rays_per_query:.2f} rays per query) and may leave squares, because"
            f" these samples are each pixel's own: use {better}"
        ]
    return []
