"""Warnings that exact visibility would have been cheaper than the cache, from counters alone."""

import pytest

import viscache as vc
from viscache.shot import exact_cost, tiles
from viscache.shot.exact_cost import LEAST_QUERIES, OWN_SAMPLES, SHARED_LIGHTS, cost_warnings

WAVES = {"visibility": {"name": "Aqvc", "form": "waves"}}
DIRECT = {"integrator": {"name": "Direct", "environment": "mis"}}


def said(group, rays, parameters=None, queries=10**6):
    """Warnings for a group of a million queries with so many rays per query."""
    counters = {"groups": {group: {"queries": queries, "rays": round(rays * queries)}}}
    return cost_warnings(parameters or WAVES | DIRECT, counters)


@pytest.mark.parametrize(
    ("group", "cost"),
    [(group, SHARED_LIGHTS) for group in ("point", "vpl", "directional")]
    + [(group, OWN_SAMPLES) for group in ("area", "ambient", "environment")],
)
def test_a_group_is_named_where_its_rays_cost_more_than_exact_ones(group, cost):
    assert not any("cheaper than the cache" in text for text in said(group, cost.limit * 0.99))
    (text,) = said(group, cost.limit * 1.01)
    assert text.startswith(f"light group {group!r}: exact visibility is cheaper than the cache.")
    assert f"pays below {cost.limit:.2f}" in text and "vc.Exact()" in text


@pytest.mark.parametrize("group", ["area", "ambient", "environment"])
def test_samples_of_each_pixels_own_are_warned_of_where_the_cache_saves_little(group):
    (text,) = said(group, 0.2)  # a cost of .6 + 1.2 · .2
    assert "saves about 16% of the cost" in text and "may leave squares" in text
    assert ('="shared"' in text) == (group != "area")
    assert said(group, 0.02) == [] and said("vpl", 0.2) == []


def test_directions_that_pixels_share_cost_as_shared_lights():
    shared = {"integrator": {"name": "Direct", "environment": "shared"}}
    between = (OWN_SAMPLES.limit + SHARED_LIGHTS.limit) / 2
    assert said("environment", between) != said("environment", between, WAVES | shared)


def test_small_groups_and_other_methods_have_no_warning():
    assert said("point", 1.0, queries=LEAST_QUERIES - 1) == []
    assert said("point", 1.0, queries=LEAST_QUERIES) != []
    for visibility in ({"name": "Exact"}, {"name": "Aqvc", "form": "pairs"}):
        assert said("point", 1.0, DIRECT | {"visibility": visibility}) == []
    assert said("point", 1.0, WAVES | DIRECT | {"keep": {}}) == []
    assert said("point", 1.0, WAVES | {"integrator": {"name": "Bdpt"}}) == []


def test_frames_warn_whole_or_in_parts_and_keep_their_bytes(monkeypatch):
    monkeypatch.setattr(exact_cost, "LEAST_QUERIES", 1)
    scene, direct, size = vc.scenes.room(triangles=2000), vc.Direct(), (64, 40)
    fine, coarse = vc.Aqvc(c_e=0.25), vc.Aqvc(c_e=16)
    whole = vc.render(scene, direct, visibility=fine, size=size)
    assert any("light group 'point'" in text for text in whole.warnings)
    parts = tiles.render(scene, direct, visibility=fine, size=size, parts=2)
    assert parts.warnings == whole.warnings and parts.sha256 == whole.sha256
    assert vc.render(scene, direct, visibility=coarse, size=size).warnings == []
    assert vc.render(scene, direct, size=size).warnings == []
