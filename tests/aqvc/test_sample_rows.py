"""Samples per eye point, through rows of bits by light cell."""

import numpy as np
import pytest

from aqvc import tiles
from aqvc.test_pairs import area_queries, ask
from aqvc.test_waves import grid_of
from reference import aqvc_samples
from reference.aqvc import place_all
from viscache import _core

KINDS = ("area", "environment")
OPTIONS = [
    {"c_e": 6},
    {"c_e": 10, "refinement": "on"},
    {"c_e": 16, "refinement": "on", "level_step": 2, "c_finest": 1, "batch": 50},
    {"c_e": 12, "refinement": "on", "tangent_neighbours": False, "normal_mode": "floor"},
    {"c_e": 2000, "refinement": "on", "batch": 7},
    {"c_e": 10, "refinement": "on", "grid_seed": 3},
    {"c_e": 0.02},
    {"c_e": 10, "refinement": "on", "c_l": 0.4},
    {"c_e": 6, "c_l": 3},
]


def ordered(run, queries):
    """Queries in the order of samples, and that order."""
    order, ends = run.order(queries["group"])
    rank = np.empty(len(order), int)
    rank[order] = np.arange(len(order))
    at = np.argsort(rank[queries["eye"]], kind="stable")
    taken = {k: v[at] if isinstance(v, np.ndarray) else v for k, v in queries.items()}
    return taken, order, ends


def ask_samples(run, queries, order, ends):
    """Answers run by run, and the counters added up."""
    rank = np.empty(len(order), int)
    rank[order] = np.arange(len(order))
    visible, total = [], {}
    for first, last in zip([0, *ends[:-1]], ends, strict=True):
        inside = (rank[queries["eye"]] >= first) & (rank[queries["eye"]] < last)
        part = {k: v[inside] if isinstance(v, np.ndarray) else v for k, v in queries.items()}
        part["eye"] = part["eye"].tolist()
        part["density"] = part["light_density"] = part["density"].tolist()
        bits, counters = run.samples(part.pop("eye"), **part)
        visible += bits
        for name, value in counters.items():
            if isinstance(value, int):
                total[name] = total.get(name, 0) + value
            elif name == "rays_per_level":
                total[name] = np.add(total.get(name, 0), value)
    return np.array(visible, bool), total


def exact_of(run, queries):
    """Answers by a ray each."""
    return ask(run, queries, exact=True)[0]


def light_keys(grid, queries, c_l=1.0):
    """Keys of the far ends by the transcription."""
    ends = zip(queries["far"], queries["normal"], queries["density"], strict=True)
    if queries["semantic"] == tiles.SURFACE:
        return [aqvc_samples.surface_key(grid, *e, c_l=c_l) for e in ends]
    return [aqvc_samples.direction_key(w, d, c_l=c_l) for w, _, d in ends]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("options", OPTIONS, ids=str)
def test_samples_equal_their_transcription(kind, options):
    eyes, grid = tiles.eye_points(24, 24), grid_of(options)
    run = tiles.tile_run(eyes, **options)
    queries, order, ends = ordered(run, area_queries(eyes, per_eye=12, kind=kind))
    parameters = _core.aqvc.AqvcParameters(**options)
    levels = parameters.level_list(queries["group"])
    assert (len(levels) > 1) == ("refinement" in options)
    placed = place_all(grid, eyes, levels)
    assert (order, ends) == aqvc_samples.outward_order(placed, options.get("batch", 1024))
    column = aqvc_samples.columns(light_keys(grid, queries, options.get("c_l", 1)))
    exact = exact_of(run, queries)
    want = aqvc_samples.own_samples(grid, placed, order, ends, queries["eye"], column, exact)
    visible, counters = ask_samples(run, queries, order, ends)
    np.testing.assert_array_equal(visible, want.visible)
    assert counters["rays_per_level"][: len(levels)].tolist() == want.rays_per_level
    assert counters["rays"] == want.rays and counters["leftover_rays"] == 0
    assert want.rays < len(visible)
    assert counters["queries"] == len(visible) and counters["bypassed"] == 0


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("refinement", ["off", "on"])
def test_samples_equal_single_queries_against_full_keys(kind, refinement):
    """The same order and batches through a map of full keys: the same bits and rays.

    With hardly any room for columns, the table answers for all light cells past the first 512.
    """
    eyes = tiles.eye_points()
    options = {"c_e": 10, "refinement": refinement, "storage": "exact"}
    rows = tiles.tile_run(eyes, table_bytes=4 << 20, **options)
    queries, order, ends = ordered(rows, area_queries(eyes, per_eye=20, kind=kind))
    queries["density"] *= 60
    light = light_keys(grid_of(options), queries)
    assert len(set(light)) > 700
    if refinement == "off":
        # Batches have no influence: single queries in the same order
        visible, counters = ask(tiles.tile_run(eyes, form="pairs", batch=1, **options), queries)
        rays = counters["rays"]
    else:
        levels = _core.aqvc.AqvcParameters(**options).level_list(queries["group"])
        grid = grid_of(options)
        asked = order, ends, queries["eye"], aqvc_samples.columns(light), exact_of(rows, queries)
        want = aqvc_samples.own_samples(grid, place_all(grid, eyes, levels), *asked)
        visible, rays = want.visible, want.rays
    for table_bytes in (4 << 20, 4):
        rows = tiles.tile_run(eyes, table_bytes=table_bytes, **options)
        assert rows.order(queries["group"]) == (order, ends)
        found, counters = ask_samples(rows, queries, order, ends)
        np.testing.assert_array_equal(found, visible)
        assert counters["rays"] == rays
        assert (counters["table_writes"] > 0) == (table_bytes == 4)


@pytest.mark.parametrize("kind", KINDS)
def test_scale_free_samples_equal_single_queries_against_full_keys(kind):
    """Cells of solid angle have no length: they are those of Eq. 9 either way."""
    eyes = tiles.eye_points()
    options = {"c_e": 10, "refinement": "off", "storage": "exact", "scale_free": True}
    rows = tiles.tile_run(eyes, **options)
    queries, order, ends = ordered(rows, area_queries(eyes, per_eye=20, kind=kind))
    visible, counters = ask_samples(rows, queries, order, ends)
    want, c = ask(tiles.tile_run(eyes, form="pairs", batch=1, **options), queries)
    np.testing.assert_array_equal(visible, want)
    assert counters["rays"] == c["rays"] < len(queries["eye"])


@pytest.mark.parametrize("kind", KINDS)
def test_without_refinement_it_does_not_matter_how_samples_are_cut_into_calls(kind):
    """The first in the order is traced, whatever the calls."""
    eyes = tiles.eye_points()
    run = tiles.tile_run(eyes, c_e=8)
    queries, order, ends = ordered(run, area_queries(eyes, kind=kind))
    whole, counters = ask_samples(run, queries, order, [len(order)])
    for cut in (ends, [*range(37, len(order), 37), len(order)]):
        again = tiles.tile_run(eyes, c_e=8)
        again.order(queries["group"])
        parts, c = ask_samples(again, queries, order, cut)
        np.testing.assert_array_equal(parts, whole)
        assert c["rays"] == counters["rays"]


def test_groups_do_not_share_bits_and_may_alternate():
    eyes = tiles.eye_points()
    alone = {}
    for kind in KINDS:
        run = tiles.tile_run(eyes, c_e=8)
        alone[kind] = ask_samples(run, *ordered(run, area_queries(eyes, kind=kind)))[0]
    run = tiles.tile_run(eyes, c_e=8)
    for kind in ("area", "environment", "area"):
        again = ask_samples(run, *ordered(run, area_queries(eyes, kind=kind)))[0]
        np.testing.assert_array_equal(again, alone[kind])


@pytest.mark.extreme
def test_no_sample_one_sample_and_samples_without_keys():
    eyes = tiles.eye_points()
    run = tiles.tile_run(eyes, c_e=8)
    up = {"semantic": 3, "group": 3, "density": [1.0], "light_density": [1.0]}
    empty = up | {"density": [], "light_density": []}
    none = np.zeros((0, 3), np.float32)
    assert run.samples([], far=none, normal=none, **empty)[0] == []
    one = np.float32([[0, 1, 0]])
    visible, c = run.samples([5], far=one, normal=one, **up)
    assert c["rays"] == c["queries"] == 1 and len(visible) == 1
    again, c = run.samples([5], far=one, normal=one, **up)
    assert c["rays"] == 0 and c["hits"] == 1 and again == visible
    far = np.float32([[0, 1, 0], [0, np.nan, 0], [np.inf, 0, 0], [0, 0, 0], [0, 1, 0]])
    odd = up | {"density": [np.nan] * 5, "light_density": [1.0] * 5}
    visible, c = run.samples([5] * 5, far=far, normal=far, **odd)
    # The zero vector has no cell, and its ray no length: it is traced separately
    assert c["bypassed"] == 3 and c["rays"] == 2 and c["clamped_nan"] == 5
    assert visible[1:3] == [False, False] and visible[0] == visible[4]


@pytest.mark.extreme
def test_eye_points_without_a_normal_trace_their_samples():
    eyes = tiles.eye_points(16, 16)
    eyes["normal"][10:20] = 0
    run = tiles.tile_run(eyes, c_e=50)
    queries, order, ends = ordered(run, area_queries(tiles.eye_points(16, 16)))
    exact = exact_of(run, queries)
    visible, counters = ask_samples(run, queries, order, ends)
    flat = (queries["eye"] >= 10) & (queries["eye"] < 20)
    np.testing.assert_array_equal(visible[flat], exact[flat])
    assert counters["bypassed"] == flat.sum() > 0
    assert counters["rays"] < 0.5 * len(exact) + flat.sum()


def test_the_density_that_cells_follow_can_be_chosen():
    eyes = tiles.eye_points()
    rays = {}
    for which, factor in (("mixture", 1), ("light", 1), ("mixture", 9), ("light", 9)):
        run = tiles.tile_run(eyes, c_e=8, cell_density=which)
        q, _, _ = ordered(run, area_queries(eyes, kind="environment"))
        densities = {"density": q["density"], "light_density": q["density"] * factor}
        args = {k: v for k, v in q.items() if k not in ("eye", "density")} | densities
        rays[which, factor] = run.samples(q["eye"].tolist(), **args)[1]["rays"]
    assert rays["mixture", 1] == rays["light", 1] == rays["mixture", 9] < rays["light", 9]
