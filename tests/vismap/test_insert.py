"""Records at points of any source: all are served, by the test of pixels, in any order."""

import numpy as np
import pytest

import viscache as vc
from render.test_interrupt import LIMIT, quickest_stop
from viscache.vismap import points as module
from viscache.vismap.points import make_cloud
from vismap.scenes import SIZE, clutter, made, pixels, same, view

SERVED, SUPPRESSED, DUPLICATE, NO_CANDIDATE = 0, 1, 2, 3  # from the last on a record is wanted


def cloud(scene, count=3000):
    """Points uniform over the area of a scene."""
    found = vc.correlation.surface_points(scene, count, points="area")
    return found.positions, found.normals


def fresh(scene=None, **settings):
    return vc.VisibilityMapCache(scene or clutter(), vc.MapSettings(**({"d_max": 0.1} | settings)))


def verdicts(cache, *points):
    """The insertion test at points, with what `insert` chooses where it is not given."""
    given = (*points, None, None)[:4]
    asked = cache._cloud(*given).take(slice(None))
    return np.asarray(cache._core.select(asked)["verdict"])


@pytest.mark.parametrize("criterion", ["visibility", "ambient"])
def test_points_that_a_camera_leaves_unserved_are_served(criterion):
    scene = vc.scenes.window_room()
    cache = fresh(scene, d_max=0.05, criterion=criterion, n_startup=200)
    cache.update(size=(96, 60))
    x, n = cloud(scene, 4000)
    before, records = verdicts(cache, x, n), len(cache)
    assert 0.2 < (before >= NO_CANDIDATE).mean() < 0.8
    report = cache.insert(x, n)
    after = verdicts(cache, x, n)
    assert (after <= DUPLICATE).all()
    assert (after == SUPPRESSED).sum() == report.suppressed
    assert len(cache) == records + report.inserted > records
    assert (report.pixels, report.startup, report.misses, report.refused) == (4000, 0, 0, 0)
    assert report.inserted == report.no_candidate + report.weight + report.difference
    assert (
        report.inserted < (before >= NO_CANDIDATE).sum() / 2
    )  # new records serve each other's points
    again = cache.insert(x, n)
    assert (again.inserted, again.rays, again.passes) == (0, 0, 1)


def test_questions_about_the_points_are_answered_by_the_new_records():
    scene = vc.scenes.cube_on_plane()
    cache = fresh(scene, d_max=0.05, n_startup=200)
    cache.update(size=(96, 60))
    x, n = cloud(scene)
    unserved, first_new = cache.lookup(x, n).candidates == 0, len(cache)
    assert unserved.sum() > 300
    cache.insert(x, n)
    found = cache.lookup(x, n)
    assert (found.candidates > 0).all()
    assert (found.ids[unserved, 0] >= first_new).all()
    np.testing.assert_allclose(found.beta[unserved].sum(axis=1), 1, atol=1e-5)
    # What the blend says agrees with exact rays, within what maps of 32 × 32 cells leave
    r = np.random.default_rng(0)
    to = r.normal(size=(64, 3))
    to /= np.linalg.norm(to, axis=1, keepdims=True)
    rows = np.flatnonzero(unserved)[:300]
    said = cache.visibility(found, to)[rows]
    i, k = np.nonzero(n[rows] @ to.T > 0.1)
    exact = ~scene.occluded(x[rows][i] + 1e-3 * n[rows][i], to[k])
    error = np.abs(said[i, k] - exact).mean()
    negative_control = np.abs(said[i, k] - r.permutation(exact)).mean()
    assert error < 0.05 and error < 0.2 * negative_control


def test_an_inserted_pixel_is_what_an_update_makes_of_it():
    updated, _ = made(n_startup=1, w_min=0.3, delta_max=0.06)
    points = pixels(updated)
    given = (points.positions, points.normals, points.d_max, points.footprint)
    cache = vc.VisibilityMapCache(clutter(), updated.settings)
    report = cache.insert(*given)
    assert (verdicts(cache, *given) <= DUPLICATE).all()
    # Another order and no start-up: other places, about as many
    assert 0.8 < len(cache) / len(updated) < 1.25
    assert report.misses == (points.d_max == 0).sum()
    assert updated.insert(*given).inserted == 0
    assert cache.update(view(), size=SIZE).inserted <= 1  # the start-up record


@pytest.mark.parametrize("settings", [{}, {"criterion": "ambient"}, {"preset": "auto"}])
def test_the_records_are_the_same_for_any_number_of_threads(settings):
    x, n = cloud(clutter())
    first = None
    for threads in (1, 2, 5):
        cache = fresh(batch=300, **settings)
        report = cache.insert(x, n, threads=threads)
        first = first or (cache, report)
        assert same(cache, first[0]) and report == first[1]
    assert len(cache) > 50


def test_the_order_in_which_points_are_given_does_not_matter():
    x, n = cloud(clutter())
    cells = ((x - x.min(0)) / np.ptp(x, axis=0) * 1024).astype(int)
    alone = np.unique(cells, axis=0, return_index=True)[1]  # ties of the curve keep their order
    caches = [fresh() for _ in range(2)]
    reports = [
        cache.insert(x[rows], n[rows], 0.2, 0.01)
        for cache, rows in zip(caches, (alone, alone[::-1]), strict=True)
    ]
    assert reports[0] == reports[1] and same(*caches)


def test_tiles_of_points_serve_all_points(monkeypatch):
    x, n = cloud(clutter())
    whole = fresh()
    report = whole.insert(x, n)
    monkeypatch.setattr(module, "TILE", 400)
    calls = []
    tiled, threaded = fresh(), fresh()
    of_tiles = tiled.insert(x, n, threads=1, progress=lambda *at: calls.append(at))
    assert (verdicts(tiled, x, n) <= DUPLICATE).all()
    assert len(tiled) == of_tiles.inserted and max(total for _, total in calls) <= 400
    assert tiled.rays == of_tiles.rays > 0 and of_tiles.pixels == 3000
    assert of_tiles.suppressed == (verdicts(tiled, x, n) == SUPPRESSED).sum()
    assert 0.9 < len(tiled) / len(whole) < 1.2 and of_tiles.passes > report.passes
    assert threaded.insert(x, n, threads=3) == of_tiles and same(threaded, tiled)
    once = fresh(repeat_passes=False)
    assert once.insert(x, n).passes == 8


def test_the_first_insertion_finds_automatic_thresholds():
    x, n = cloud(clutter())
    cache = fresh(preset="auto", n_startup=100)
    report = cache.insert(x, n)
    assert cache.started and 90 <= report.startup <= 100
    assert cache.thresholds != vc.MapSettings().thresholds()
    assert len(cache) == report.inserted and (verdicts(cache, x, n) <= DUPLICATE).all()
    assert cache.update(view(), size=SIZE).startup == 0
    assert fresh().insert(x, n).startup == 0


def test_default_radii_are_those_of_a_square_image_of_the_points():
    edge = 50
    grid = np.stack(np.meshgrid(*2 * [np.arange(edge) / edge]), -1).reshape(-1, 2)
    x = np.insert(grid, 1, 0, axis=1)
    made_cloud = make_cloud(x, [[0, 1, 0]] * edge**2, None, None, reach=0.05, extent=10.0)
    inner = np.all((grid > 0.1) & (grid < 0.9), axis=1)
    # The 8th neighbour of a grid point is a diagonal one: 8 / (2π) points per cell instead of 1
    np.testing.assert_allclose(made_cloud.footprint[inner], np.sqrt(np.pi / 4) / edge, rtol=1e-4)
    np.testing.assert_allclose(made_cloud.d_max[inner], 0.05 * np.sqrt(np.pi / 4), rtol=1e-4)
    # A part of the points leaves the radius: the surface is the same
    r = np.random.default_rng(1)
    few = r.choice(edge**2, 600, replace=False)
    part = make_cloud(x[few], [[0, 1, 0]] * 600, None, None, reach=0.05, extent=10.0)
    assert np.median(part.d_max) == pytest.approx(0.05, rel=0.2)
    given = make_cloud(x, [[0, 1, 0]] * edge**2, None, 0.02, reach=0.05, extent=10.0)
    np.testing.assert_allclose(given.d_max, 0.05, rtol=1e-6)
    capped = make_cloud(x, [[0, 1, 0]] * edge**2, None, 9.0, reach=0.05, extent=10.0)
    np.testing.assert_array_equal(capped.d_max, np.float32(1))


@pytest.mark.extreme
def test_lone_and_coincident_points_are_served():
    up = [0.0, 1.0, 0.0]
    for places in ([[0.0, 0, 0]], [[0.0, 0, 0]] * 20, [[0.0, 0, 0], [0.5, 0, 0.5]]):
        cache = fresh()
        report = cache.insert(places, [up] * len(places))
        assert report.inserted == len(cache) >= 1
        assert (cache.lookup(places, [up] * len(places)).candidates > 0).all()
    none = fresh(preset="auto")
    empty = none.insert(np.zeros((0, 3)), np.zeros((0, 3)))
    assert (empty.inserted, empty.pixels, len(none), none.started) == (0, 0, 0, False)


def test_a_full_cache_says_how_many_points_it_refused():
    x, n = cloud(clutter())
    cache = fresh(max_records=40)
    report = cache.insert(x, n)
    assert len(cache) == report.inserted == 40
    assert report.refused == (verdicts(cache, x, n) >= NO_CANDIDATE).sum() > 0


def test_inserted_records_count_as_used_in_their_frame():
    x, n = cloud(clutter())
    cache = fresh(unused_frames=1, removal="none")
    cache.insert(x, n)
    records = len(cache)
    cache.end_frame()
    assert cache.insert(x, n).inserted == 0
    assert cache.end_frame()["unused"] == 0 and len(cache) == records
    cache.end_frame()
    assert len(cache) == 0


BAD = [
    ("positions", [0.0, 0, 0], r"positions must have shape \(N, 3\), got \(3,\)"),
    ("positions", [[0.0, 0]] * 3, r"positions must have shape \(N, 3\), got \(3, 2\)"),
    ("positions", "abc", "positions must be numbers"),
    ("normals", [[0.0, 1, 0]] * 2, "normals must have one row per position, 3, got 2"),
    ("normals", [0.0, 1, 0], r"normals must have shape \(N, 3\)"),
    ("d_max", [0.1, 0.1], "d_max must be one or 3 numbers"),
    ("footprint", [[0.1]] * 3, "footprint must be one or 3 numbers"),
    ("threads", 0, r"threads must be a whole number in \[1, 1024\]"),
]
#: The last of three rows.
BAD_ROWS = [
    *(("positions", [bad, 0, 0], "finite and at most 1e16 in size") for bad in (np.nan, np.inf)),
    ("normals", [0, 0, 0], "normals must be unit vectors, row 2 has length 0"),
    ("normals", [0, 2, 0], "normals must be unit vectors, row 2 has length 2"),
    ("normals", [np.nan, 0, 0], "normals must be unit vectors, row 2 has length nan"),
    ("d_max", -1.0, r"d_max must be in \[0, 1e16\], row 2 has -1"),
    ("d_max", np.nan, r"d_max must be in \[0, 1e16\], row 2 has nan"),
    ("footprint", np.inf, r"footprint must be in \[0, 1e16\], row 2 has inf"),
]


@pytest.mark.extreme
def test_points_that_cannot_be_are_refused_and_nothing_is_lost(monkeypatch):
    monkeypatch.setattr("viscache.vismap.points.TILE", 2)  # rows are counted over tiles
    cache, _ = made(n_startup=20)
    before = cache.records()
    good = {
        "positions": [[0.0, 0, 0], [0.1, 0, 0], [0.2, 0, 0]],
        "normals": [[0.0, 1, 0]] * 3,
        "d_max": [0.2] * 3,
        "footprint": [0.01] * 3,
    }
    rows = [(name, [*good[name][:2], row], message) for name, row, message in BAD_ROWS]
    for name, wrong, message in BAD + rows:
        with pytest.raises(ValueError, match=message):
            cache.insert(**(good | {name: wrong}))
    for name, wrong, message in rows[:5]:  # also before densities are looked for
        with pytest.raises(ValueError, match=message):
            cache.insert(**(good | {name: wrong, "d_max": None, "footprint": None}))
    after = cache.records()
    for field in ("positions", "bits", "last_used"):
        np.testing.assert_array_equal(getattr(after, field), getattr(before, field))
    assert cache.insert(**good).pixels == 3


@pytest.mark.slow
def test_ctrl_c_ends_an_insertion_soon():
    x = "np.random.default_rng(0).uniform(-1, 1, (400000, 3)) * [1, 0, 1]"
    settings = "vc.MapSettings(m=7, delta_max=0.0, r_min_px=0.0)"
    call = (
        "import numpy as np; "
        f"vc.VisibilityMapCache(scene, {settings}).insert({x}, [[0, 1, 0]] * 400000, 0.02)"
    )
    assert quickest_stop(call, 1.5) < LIMIT
