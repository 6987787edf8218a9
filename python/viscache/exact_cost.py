"""Tells from a frame's counters where exact visibility would have been cheaper than the cache."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

__all__ = ["OWN_SAMPLES", "SHARED_LIGHTS", "Cost", "cost_warnings"]

#: Fewer queries take less than some hundredths of a second either way.
LEAST_QUERIES = 1 << 18


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
#: A ray costs 2.1 exact ones with many virtual lights, and less with few lamps.
SHARED_LIGHTS = Cost(0.01, 1.9)
#: Samples of each eye point's own are sorted to rows of light cells first.
OWN_SAMPLES = Cost(0.6, 1.2)


def cost_warnings(parameters: Mapping[str, Any], counters: Mapping[str, Any]) -> list[str]:
    """A warning for each light group whose queries cost more than exact ones.

    Parameters
    ----------
    parameters, counters
        Of a frame of the quantized cache, in its default form; others have no warning.
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
        cost = OWN_SAMPLES if own else SHARED_LIGHTS
        if queries < LEAST_QUERIES or cost.of(rays / queries) <= 1:
            continue
        texts.append(
            f"light group {group!r}: exact visibility is cheaper than the cache. It traced"
            f" {rays / queries:.2f} rays per query ({rays} for {queries}) and pays below"
            f" {cost.limit:.2f}: use vc.Exact(), or a larger {'c_e or c_l' if own else 'c_e'}"
        )
    return texts
