"""`measure` and `correlate` against brute force; any split, executor or restart: same bytes."""

import multiprocessing
import signal
import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

import viscache as vc
from correlation.points import bumpy
from reference import pair_tables
from viscache.correlation import correlate, measure, run, tasks, work

SCENE = "bumpy_spheres?triangles=3000"
SMALL = {
    "n_points": 300,
    "map_size": 16,
    "d_edges": 16,
    "theta_edges_deg": 18,
    "threads": 2,
}


def assert_same(a, b):
    """Equal bytes of every variable and coordinate."""
    assert set(a.variables) == set(b.variables)
    for name in a.variables:
        left, right = np.asarray(a[name].values), np.asarray(b[name].values)
        assert left.dtype == right.dtype and left.tobytes() == right.tobytes(), name


@pytest.fixture(scope="module")
def problem():
    return bumpy(260)


@pytest.fixture(scope="module")
def measured():
    return measure(SCENE, **SMALL)


def of(problem, **settings):
    return correlate(problem.bits, problem.positions, problem.normals, n_directions=500, **settings)


def test_slices_have_their_own_bins_from_their_own_pairs(problem):
    ds = of(problem, d_edges=50, theta_edges_deg=7, slice_d=0.7, slice_theta_deg=11.0)
    pairs = pair_tables.all_pairs(problem.visible, problem.positions, problem.normals)
    over_theta = pair_tables.binned(pairs, np.array([0, 0.7]), np.linspace(0, 180, 65))
    d_edges = np.append(ds["d_aligned_low"].values, np.inf)
    over_d = pair_tables.binned(pairs, d_edges, np.array([0, 11.0]))
    corner = pair_tables.binned(pairs, np.array([0, 0.7]), np.array([0, 11.0]))
    for prefix, expected in (
        ("near_", {k: v[0] for k, v in over_theta.items()}),
        ("aligned_", {k: v[:, 0] for k, v in over_d.items()}),
    ):
        assert expected["n"].sum() > 500 and ds.sizes[ds[f"{prefix}n"].dims[0]] == 64
        for name in ("n", "n_undefined", "mean", "sigma"):
            assert np.allclose(ds[prefix + name], expected[name], atol=1e-6, equal_nan=True), name
    assert float(ds["corner"]) == pytest.approx(corner["mean"].item(), abs=1e-6)
    assert int(ds["corner_n"]) == corner["n"].item()


def test_a_convex_scene_measured_end_to_end_falls_as_a_straight_line():
    """Rays, rows, pairs and bins together."""
    sphere = convex_sphere()
    d_edges = [0, 0.5, 1, 1.5, np.inf]
    ds = measure(sphere, n_points=1500, points="area", d_edges=d_edges, theta_edges_deg=45)
    normals = ds["normal"].values.astype(float)
    p = ds["position"].values.astype(float)
    i, j = np.triu_indices(len(p), 1)
    theta = np.degrees(
        2
        * np.arctan2(
            np.linalg.norm(normals[i] - normals[j], axis=1),
            np.linalg.norm(normals[i] + normals[j], axis=1),
        )
    )
    d = np.linalg.norm(p[i] - p[j], axis=1)
    line = pair_tables.binned(
        pair_tables.Pairs(i=i, j=j, rho=1 - theta / 90, d=d, theta_deg=theta),
        np.append(ds["d_low"].values, np.inf),
        np.append(ds["theta_low"].values, 180.0),
    )
    enough = ds["n"].values >= 500
    assert enough.sum() > 20 and enough.any(axis=1).all()
    assert np.abs(ds["mean"].values - line["mean"])[enough].max() < 5e-4
    assert ds["n_undefined"].sum() == 0


def convex_sphere():
    """A sphere of triangles with all corners on it, which no point of it shades."""
    u, v = np.meshgrid(np.linspace(0, 2 * np.pi, 129), np.linspace(0, np.pi, 65))
    grid = np.stack([np.sin(v) * np.cos(u), np.sin(v) * np.sin(u), np.cos(v)], axis=-1)
    at = np.arange(grid[..., 0].size).reshape(u.shape)
    a, b, c, e = at[:-1, :-1], at[:-1, 1:], at[1:, 1:], at[1:, :-1]
    upper, lower = np.stack([a, e, c], -1)[:], np.stack([a, c, b], -1)
    faces = np.concatenate([upper[:-1].reshape(-1, 3), lower[1:].reshape(-1, 3)])
    # Turned, so that it has no symmetry in common with the map of directions
    turn = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]
    return vc.Scene.from_arrays(grid.reshape(-1, 3) @ (turn * np.linalg.det(turn)).T, faces)


def test_threads_and_blocks_change_no_byte(measured, monkeypatch):
    assert_same(measured, measure(SCENE, **SMALL | {"threads": 1}))
    monkeypatch.setattr(work, "ROWS_PER_BLOCK", 37)
    monkeypatch.setattr(work, "PAIRS_PER_BLOCK", 1000)
    blocks = work.pair_blocks(np.sort(np.arange(300, dtype=np.int32) % 16))
    assert 20 < len(blocks) <= 136
    assert_same(measured, measure(SCENE, **SMALL | {"threads": 8}))


@pytest.mark.slow
def test_a_pool_of_processes_gives_the_same_bytes(measured, tmp_path, monkeypatch):
    monkeypatch.setattr(work, "ROWS_PER_BLOCK", 100)
    monkeypatch.setattr(work, "PAIRS_PER_BLOCK", 8000)
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(2, mp_context=context) as pool:
        found = measure(SCENE, **SMALL | {"threads": 1}, executor=pool)
        assert_same(measured, found)
        travelled = measure(convex_sphere(), **SMALL | {"threads": 1}, executor=pool)
    assert_same(measure(convex_sphere(), **SMALL), travelled)
    with ThreadPoolExecutor(2) as pool:
        assert_same(measured, measure(SCENE, **SMALL | {"threads": 1}, executor=pool))


def test_random_pairs_have_the_mean_of_all_pairs_and_near_ones_are_exhaustive(monkeypatch):
    monkeypatch.setattr(run, "NEAR_PAIRS", 40_000)
    problem = bumpy(1200, seed=3)
    edges = {"d_edges": 64, "theta_edges_deg": 6, "d_max": 6.4}
    whole = of(problem, **edges)
    few = of(problem, **edges, pairs=150_000, seed=4)
    assert few.attrs["far_share"] == pytest.approx(150_000 / (1200 * 1199 / 2), rel=0.15)
    assert few.attrs["n_pairs"] < 200_000 and whole.attrs["far_share"] == 1.0
    assert few.attrs["d_near"] > 0.2 and few.attrs["near_slice_exhaustive"] == 1
    near = few["pair_share"].values == 1.0
    assert 1 < near.sum() < 64 and not near[-1]
    assert (few["n"].values[near] == whole["n"].values[near]).all()
    assert (few["mean"].values[near] == whole["mean"].values[near])[
        whole["n"].values[near] > 0
    ].all()
    share = few["n"].values[~near].sum() / whole["n"].values[~near].sum()
    assert share == pytest.approx(few.attrs["far_share"], rel=0.1)
    for name in ("near_n", "near_mean", "corner"):
        assert np.array_equal(few[name], whole[name], equal_nan=True)
    far = ~near[:, None] & (few["n"].values >= 300)
    z = (few["mean"] - whole["mean"]).values[far] / few["se"].values[far]
    assert far.sum() > 20 and np.abs(z).max() < 5


def test_a_near_pass_that_costs_too_much_is_left_out(monkeypatch):
    problem = bumpy(1200, seed=3)
    monkeypatch.setattr(run, "NEAR_PAIRS", 100.0)
    monkeypatch.setattr(run, "NEAR_SHARE", 0.0)
    ds = of(problem, d_edges=64, d_max=6.4, pairs=150_000)
    assert ds.attrs["d_near"] == 0 and ds.attrs["near_slice_exhaustive"] == 0
    assert (ds["pair_share"].values == ds.attrs["far_share"]).all()


def test_a_pair_or_two_are_enough(problem, monkeypatch):
    monkeypatch.setattr(run, "NEAR_PAIRS", 0.0)
    ds = of(problem, pairs=1)
    assert ds.attrs["n_pairs"] < 2000 and ds["n"].sum() <= ds.attrs["n_pairs"]
    two = correlate(problem.bits[1:3], problem.positions[1:3], problem.normals[1:3])
    assert two["n"].sum() == 1 and np.isnan(two["se"].values).all()


def test_local_means_are_those_of_the_box(monkeypatch):
    from viscache.correlation import local_means

    settings = SMALL | {"n_points": 600}
    ds = measure("cube_on_plane", **settings)
    p, m = ds["position"].values.astype(float), ds["normal"].values.astype(float)
    d = np.linalg.norm(p[:, None] - p, axis=2)
    apart, together = (np.linalg.norm(m[:, None] + s * m, axis=2) for s in (-1, 1))
    theta = np.degrees(2 * np.arctan2(apart, together))
    near = (d < ds.attrs["box_d_max"]) & (theta < ds.attrs["box_theta_max_deg"])
    np.fill_diagonal(near, False)
    known = np.isfinite(ds["local_mean"].values)
    assert ds.attrs["local_share"] == 1 and known.sum() > 100
    assert (known <= near.any(axis=1)).all()
    pairs = np.triu(near).sum()
    weighted = np.nansum(ds["local_mean"].values * near.sum(axis=1)) / (2 * pairs)
    assert weighted == pytest.approx(ds.attrs["box_mean"], abs=0.1)
    # Dealt into parts, means are over fewer neighbours
    monkeypatch.setattr(local_means, "NEIGHBOURS", near.sum() / 600 / 2.5)
    dealt = measure("cube_on_plane", **settings)
    assert dealt.attrs["local_share"] == pytest.approx(1 / 3)
    both = known & np.isfinite(dealt["local_mean"].values) & (near.sum(axis=1) > 30)
    off = (dealt["local_mean"] - ds["local_mean"]).values[both]
    assert both.sum() > 20 and 0 < np.abs(off).max() < 0.5 and np.abs(off.mean()) < 0.05


def test_groups_may_be_given_and_points_come_in_any_order(problem):
    order = np.random.default_rng(0).permutation(260)
    mixed = replace(
        problem, **{n: getattr(problem, n)[order] for n in ("visible", "positions", "normals")}
    )
    edges = {"d_edges": [0, 2, 4, 6], "theta_edges_deg": 9}
    assert_same(of(problem, **edges), of(mixed, **edges))
    two = of(problem, **edges, group=np.arange(260) % 2 * 7)
    assert two.attrs["n_groups"] == 2 and np.array_equal(two["n"], of(problem, **edges)["n"])


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"pairs": 0}, 'pairs must be "all" or a whole number >= 1, got 0'),
        ({"pairs": "some"}, "pairs must be"),
        ({"min_bits": 0}, "min_bits must be a whole number >= 1, got 0"),
        ({"undefined": "drop"}, "undefined must be one of"),
        ({"seed": -1}, r"seed must be in \[0, 2\^63\), got -1"),
        ({"d_edges": 0}, "number of d bins"),
        ({"d_edges": [0, 1], "d_max": 2.0}, "d_max must be left out"),
        ({"d_max": np.nan}, "d_max must be finite"),
        ({"group": [0, 1]}, "group must be 260 whole numbers"),
        ({"n_directions": 7}, "bits from n_directions = 7 on must be 0"),
        ({"n_directions": 513}, r"n_directions must be a whole number in \[1, 512\], got 513"),
    ],
)
def test_bad_arguments_are_refused(problem, change, says):
    with pytest.raises(ValueError, match=says):
        correlate(
            problem.bits, problem.positions, problem.normals, **{"n_directions": 500} | change
        )


def test_bad_arrays_are_refused(problem):
    bits, p, n = problem.bits, problem.positions, problem.normals
    with pytest.raises(ValueError, match=r"bits must be uint64 of shape \(N, W\)"):
        correlate(bits.astype(np.int64), p, n)
    with pytest.raises(ValueError, match="positions must have shape"):
        correlate(bits, p[:5], n)
    broken = p.copy()
    broken[3, 1] = np.nan
    with pytest.raises(ValueError, match="positions must be finite"):
        correlate(bits, broken, n)
    with pytest.raises(ValueError, match="at least 2 rows"):
        correlate(bits[:1], p[:1], n[:1])


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"t_max": 0.0}, "t_max must be > 0"),
        ({"t_max": [1.0]}, "t_max must be > 0"),
        ({"t_max": "far"}, "t_max must be > 0"),
        ({"domain": "half"}, "domain must be one of"),
        ({"domain": "joint", "normals": "shading"}, 'domain must be "sphere" with shading normals'),
        ({"n_points": 0}, "n_points"),
        ({"points": "line"}, "points"),
        ({"map_size": 0}, "map_size"),
        ({"camera": 9}, "camera must be in"),
    ],
)
def test_measurements_that_cannot_be_are_refused(change, says):
    with pytest.raises(ValueError, match=says):
        measure(SCENE, **SMALL | change)


def count_work(monkeypatch):
    done = {"rows": 0, "pairs": 0}

    def traced(*args):
        done["rows"] += 1
        return tasks.trace(*args)

    def counted(*args):
        done["pairs"] += 1
        return tasks.count(*args)

    monkeypatch.setattr(sys.modules[measure.__module__], "trace", traced)
    monkeypatch.setattr(run, "count", counted)
    return done


def blocks_of(folder, pattern):
    return [p for p in folder.rglob(pattern) if not p.name.startswith(".")]


def test_a_store_repeats_nothing_and_takes_over_rows(measured, tmp_path, monkeypatch):
    monkeypatch.setattr(work, "ROWS_PER_BLOCK", 100)
    done = count_work(monkeypatch)
    assert_same(measured, measure(SCENE, **SMALL, directory=tmp_path))
    assert done == {"rows": 3, "pairs": 1}
    again = measure(SCENE, **SMALL, directory=tmp_path)
    assert done == {"rows": 3, "pairs": 1} and again.attrs["n_rays"] == measured.attrs["n_rays"]
    assert_same(measured, again)
    measure(SCENE, **SMALL | {"d_max": 2.0}, directory=tmp_path)
    assert done == {"rows": 3, "pairs": 2}
    measure(SCENE, **SMALL, seed=1, directory=tmp_path)
    assert done == {"rows": 6, "pairs": 3}


KILLED = """
import os, sys
from viscache.correlation import measure, work
work.ROWS_PER_BLOCK, work.PAIRS_PER_BLOCK = 100, 1000
def report(done, total):
    print(done, total, flush=True)
    if done == {stop}:
        {end}
measure({scene!r}, n_points=300, map_size=16, d_edges=16, theta_edges_deg=18, threads=2,
        directory=sys.argv[1], progress=report)
"""


@pytest.mark.parametrize("stop", [2, 9])
def test_a_run_that_was_killed_goes_on_where_it_stopped(measured, stop, tmp_path, monkeypatch):
    code = KILLED.format(stop=stop, end="os.kill(os.getpid(), 9)", scene=SCENE)
    ended = subprocess.run([sys.executable, "-c", code, str(tmp_path)], capture_output=True)
    assert ended.returncode == -signal.SIGKILL, ended.stderr
    rows, pairs = len(blocks_of(tmp_path, "rows-*-*.npz")), len(blocks_of(tmp_path, "pairs-*.npz"))
    assert rows + pairs == stop
    monkeypatch.setattr(work, "ROWS_PER_BLOCK", 100)
    monkeypatch.setattr(work, "PAIRS_PER_BLOCK", 1000)
    total = len(work.pair_blocks(np.sort(np.arange(300, dtype=np.int32) % 16)))
    done = count_work(monkeypatch)
    assert_same(measured, measure(SCENE, **SMALL, directory=tmp_path))
    assert done == {"rows": 3 - rows, "pairs": total - pairs}


def test_progress_counts_every_block_once(monkeypatch):
    monkeypatch.setattr(work, "ROWS_PER_BLOCK", 100)
    seen = []
    measure(SCENE, **SMALL, progress=lambda done, total: seen.append((done, total)))
    assert seen == [(k + 1, 4) for k in range(4)]


def test_a_store_of_other_rows_is_refused(tmp_path):
    measure(SCENE, **SMALL, directory=tmp_path)
    (rows,) = blocks_of(tmp_path, "rows.npy")
    np.save(rows, np.zeros((3, 8), np.uint64))
    with pytest.raises(ValueError, match="must hold rows of shape"):
        measure(SCENE, **SMALL, directory=tmp_path)


def test_local_visibility_sees_more_than_the_whole_scene_leaves_free():
    settings = SMALL | {"points": "camera"}
    near = measure(SCENE, **settings, t_max=0.02)
    far = measure(SCENE, **settings)
    assert near.attrs["t_max"] == 0.02 and near.attrs["n_rays"] == far.attrs["n_rays"]
    # With hardly any occluder left, ρ tends to the straight line of the hemispheres
    theta = np.radians(near["theta_near"].values)
    enough = near["near_n"].values > 50
    line = 1 - 2 * theta / np.pi
    off = [np.abs(ds["near_mean"].values - line)[enough].mean() for ds in (near, far)]
    assert off[0] < off[1]


def test_a_closed_scene_chooses_a_distance_and_reports_it():
    closed = measure("room?triangles=3000", **SMALL)
    assert closed.attrs["t_max_by"] == "closed scene"
    diagonal = np.linalg.norm(np.diff(vc.scenes.room(triangles=3000).bounds, axis=0))
    assert 0.1 * diagonal < closed.attrs["t_max"] < 0.6 * diagonal
    endless = measure("room?triangles=3000", **SMALL, t_max=np.inf)
    assert endless.attrs["t_max_by"] == "caller"
    share = [float(ds["n"].sum() / (ds["n"] + ds["n_undefined"]).sum()) for ds in (closed, endless)]
    assert share[0] > 0.9 and share[1] < 0.5
    given = measure("room?triangles=3000", **SMALL, t_max=closed.attrs["t_max"])
    assert_same(given, closed)


def test_an_open_scene_keeps_rays_without_end(measured):
    assert measured.attrs["t_max"] == np.inf and measured.attrs["t_max_by"] == "open scene"
    assert_same(measured, measure(SCENE, **SMALL, t_max=np.inf))


@pytest.mark.slow
def test_a_scene_measured_by_the_batch_gives_the_same_correlation(tmp_path):
    """Rows within rounding of an edge may differ; the store keeps engines apart."""
    common = {"n_points": 1500, "map_size": 24, "seed": 3, "directory": tmp_path}
    plain = measure("room?triangles=3000", **common)
    batch = measure("room?triangles=3000", engine="batch", **common)
    assert plain.attrs["engine"] == "embree" and plain.attrs["batch_rays"] == 0
    assert batch.attrs["batch_rays"] == batch.attrs["n_rays"] == plain.attrs["n_rays"]
    np.testing.assert_allclose(batch["mean"], plain["mean"], atol=1e-4)
    assert len(list(tmp_path.iterdir())) == 2
    again = measure("room?triangles=3000", engine="batch", **common)
    assert again.attrs["rows_s"] == 0 and again.attrs["batch_rays"] == again.attrs["n_rays"]
    np.testing.assert_array_equal(again["mean"], batch["mean"])
    with pytest.raises(ValueError, match="engine must be"):
        measure("room?triangles=3000", engine="gpu", **common)
