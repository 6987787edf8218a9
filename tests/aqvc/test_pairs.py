"""Connections of single eye points against the tile's table."""

import itertools

import numpy as np
import pytest

from aqvc import tiles
from core import testing
from viscache import _core


def area_queries(eyes, per_eye=16, seed=1, kind="area"):
    """Random light samples per eye point, in eye order; facing pairs only."""
    rng = np.random.default_rng(seed)
    n = len(eyes["density"])
    eye = np.repeat(np.arange(n), per_eye)
    if kind == "area":
        far = rng.uniform([-2, 5, -2], [2, 5, 2], (len(eye), 3)).astype(np.float32)
        normal = np.tile(np.float32([0, -1, 0]), (len(eye), 1))
        density = np.full(len(eye), per_eye / 16, np.float32)
        facing = ((far - eyes["position"][eye]) * eyes["normal"][eye]).sum(1) > 0
    else:
        far = rng.normal(size=(len(eye), 3))
        far[:, 1] = np.abs(far[:, 1])
        far = (far / np.linalg.norm(far, axis=1, keepdims=True)).astype(np.float32)
        normal = np.zeros_like(far)
        density = np.full(len(eye), per_eye / (2 * np.pi), np.float32)
        facing = (far * eyes["normal"][eye]).sum(1) > 0
    return {
        "eye": eye[facing],
        "semantic": 2 if kind == "area" else 3,
        "group": tiles.GROUPS[kind],
        "far": far[facing],
        "normal": normal[facing],
        "density": density[facing],
    }


def ordered(run, queries):
    """The queries in the oracle's processing order."""
    order, ends = run.order()
    rank = np.empty(len(order), int)
    rank[order] = np.arange(len(order))
    at = np.argsort(rank[queries["eye"]], kind="stable")
    return {k: v[at] if isinstance(v, np.ndarray) else v for k, v in queries.items()}, rank, ends


def ask(run, queries, exact=False):
    """Answers as an array, and the counters."""
    q = {k: v for k, v in queries.items() if k != "eye"}
    visible, counters = run.pairs(queries["eye"].tolist(), exact=exact, **q)
    return np.array(visible), counters


@pytest.mark.parametrize("kind", ["area", "environment"])
def test_samples_of_many_eye_points_share_rays(kind):
    eyes = tiles.eye_points()
    run = tiles.tile_run(eyes, c_e=6)
    queries, _, _ = ordered(run, area_queries(eyes, kind=kind))
    exact, _ = ask(run, queries, exact=True)
    visible, c = ask(run, queries)
    group = c["groups"][tiles.GROUPS[kind]]
    assert group["queries"] == len(exact) and group["occluded"] == (~visible).sum()
    assert 0.05 * len(exact) < c["rays"] < 0.8 * len(exact)
    assert 0 < (visible != exact).mean() < 0.15
    assert c["lookups"] == len(exact) and c["table_writes"] == c["rays"]
    assert c["table_slots"] == testing.largest_prime(2**20)


@pytest.mark.parametrize("kind", ["area", "environment"])
def test_batches_do_not_depend_on_how_calls_are_cut(kind):
    eyes = tiles.eye_points()
    whole = tiles.tile_run(eyes, c_e=6, batch=100)
    queries, rank, ends = ordered(whole, area_queries(eyes, kind=kind))
    want, counters = ask(whole, queries)
    parts = tiles.tile_run(eyes, c_e=6, batch=100)
    got, rays = [], 0
    for first, last in zip([0, *ends[:-1]], ends, strict=True):
        inside = (rank[queries["eye"]] >= first) & (rank[queries["eye"]] < last)
        part = {k: v[inside] if isinstance(v, np.ndarray) else v for k, v in queries.items()}
        visible, c = ask(parts, part)
        got.append(visible)
        rays += c["rays"]
    np.testing.assert_array_equal(np.concatenate(got), want)
    assert rays == counters["rays"]


def cells_of(eyes):
    """Which cluster of C_E = 10 every eye point lies in."""
    resolution = _core.aqvc.resolution_eye(eyes["density"].astype(np.float64), 10.0, tiles.RADIUS)
    n = len(eyes["density"])
    near = (tiles.CENTER, tiles.RADIUS, eyes["position"], eyes["normal"], resolution)
    far = (0, np.zeros((n, 3)), np.zeros((n, 3)), np.ones(n))
    keys = _core.aqvc.full_keys(_core.aqvc.AqvcParameters(), *near, *far)[0]
    return np.unique(keys, axis=0, return_inverse=True)[1].ravel()


def test_without_refinement_rays_are_distinct_keys_in_every_order():
    eyes, far = tiles.eye_points(), tiles.lights("point", 12)
    wanted = tiles.facing(eyes, far)
    options = {"c_e": 10, "refinement": "off", "storage": "exact", "form": "pairs"}
    rays = set()
    for order in ("hm", "scanline", "random"):
        for batch in (1, 100):
            run = tiles.tile_run(eyes, order=order, batch=batch, **options)
            rays.add(run.block(far, wanted)[1]["rays"])
    cell = cells_of(eyes)
    distinct = {(cell[i], k) for i, k in zip(*np.nonzero(wanted), strict=True)}
    assert rays == {len(distinct)}


def test_a_query_is_wrong_only_in_a_cluster_that_holds_both_values():
    eyes, far = tiles.eye_points(48, 48), tiles.lights("point", 12)
    wanted = tiles.facing(eyes, far)
    run = tiles.tile_run(eyes, c_e=10, refinement="off", storage="exact", form="pairs")
    exact, _ = run.block(far, wanted, exact=True)
    visible, _ = run.block(far, wanted)
    cell = cells_of(eyes)
    ones = np.zeros((cell.max() + 1, 12), int)
    asked = np.zeros_like(ones)
    np.add.at(ones, cell, exact & wanted)
    np.add.at(asked, cell, wanted)
    mixed = (ones > 0) & (ones < asked)
    wrong = (visible != exact) & wanted
    assert wrong.any() and not (wrong & ~mixed[cell]).any()


def test_a_smaller_table_traces_more_rays_and_answers_the_same_at_c_e_near_zero():
    eyes, far = tiles.eye_points(), tiles.lights("point", 12)
    wanted = tiles.facing(eyes, far)
    sizes = [4, 400, 4000, 40000, 4 << 20]
    options = {"c_e": 8, "form": "pairs", "order": "random", "batch": 1}
    runs = [tiles.tile_run(eyes, table_bytes=b, **options) for b in sizes]
    results = [run.block(far, wanted) for run in runs]
    rays = [c["rays"] for _, c in results]
    exact_storage = tiles.tile_run(eyes, storage="exact", **options)
    assert all(b <= 1.05 * a for a, b in itertools.pairwise(rays))
    assert rays[0] > 2 * rays[-1]
    assert rays[-1] == pytest.approx(exact_storage.block(far, wanted)[1]["rays"], rel=0.01)
    assert results[0][1]["evictions"] > 0.9 * results[0][1]["table_writes"]
    one_slot = tiles.tile_run(eyes, c_e=1e-3, form="pairs", table_bytes=4)
    visible, _ = one_slot.block(far, wanted)
    np.testing.assert_array_equal(visible, one_slot.block(far, wanted, exact=True)[0])
