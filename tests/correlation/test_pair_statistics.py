"""Tiles, threads, tables: the same bytes however the pairs are split."""

import numpy as np
import pytest

from correlation.points import SUMS, random_points
from reference.isas import AVAILABLE
from viscache.correlation import pairs
from viscache.correlation.pair_table import MAX_PAIRS

D_EDGES = np.linspace(0, 1.3, 14)
ANGLES = np.arange(0, 181, 10.0)


def table_of(points, **options):
    return pairs.pair_statistics(*points.arguments, D_EDGES, ANGLES, **options)


def assert_same(a, b):
    for name in (*SUMS, "sum_q2_high", "sum_q2_low"):
        assert getattr(a, name).tobytes() == getattr(b, name).tobytes(), name


@pytest.fixture(scope="module")
def points():
    return random_points(n=700, groups=4)


@pytest.mark.parametrize("isa", AVAILABLE)
@pytest.mark.parametrize("threads", [1, 2, 8])
def test_threads_and_instruction_sets_give_the_same_bytes(points, isa, threads):
    assert_same(table_of(points, isa=isa, threads=threads, tile=100), table_of(points))


@pytest.mark.parametrize("tile", [1, 3, 16, 50, 2048])
@pytest.mark.parametrize("skip_dead", [True, False])
def test_tiles_of_any_size_give_the_same_bytes(points, tile, skip_dead):
    assert_same(table_of(points, tile=tile, skip_dead=skip_dead), table_of(points))


def test_parts_in_any_order_add_up_to_the_whole(points):
    tiles = pairs.tile_list(points.group, 60)
    shuffled = np.random.default_rng(0).permutation(len(tiles))
    parts = [table_of(points, tile=60, tiles=part) for part in np.array_split(shuffled, 5)]
    first = parts[0] + parts[1] + parts[2] + parts[3] + parts[4]
    last = parts[3] + (parts[4] + (parts[1] + parts[0]) + parts[2])
    assert_same(first, last)
    assert_same(first, table_of(points))


def test_sums_of_squares_carry(points):
    table = table_of(points)
    double = table
    for _ in range(12):
        double = double + double
    assert (double.sum_q2() == 4096 * table.sum_q2()).all()
    assert double.sum_q2_low.max() < 2**32 and double.sum_q2_low.min() >= 0


def test_every_pair_lies_in_one_tile(points):
    tiles = pairs.tile_list(points.group, 64)
    seen = np.zeros((700, 700), np.int64)
    for t in tiles:
        assert (points.group[t["i0"] : t["i1"]] == t["a"]).all()
        assert (points.group[t["j0"] : t["j1"]] == t["b"]).all()
        assert 0 < t["i1"] - t["i0"] <= 64 and 0 < t["j1"] - t["j0"] <= 64
        block = np.ones((t["i1"] - t["i0"], t["j1"] - t["j0"]), np.int64)
        if t["i0"] == t["j0"]:
            block = np.triu(block, 1)
        assert block.sum() == t["pairs"]
        seen[t["i0"] : t["i1"], t["j0"] : t["j1"]] += block
    np.testing.assert_array_equal(seen, np.triu(np.ones((700, 700), np.int64), 1))


def test_tiles_are_counted_in_their_pair_of_groups(points):
    tiles = pairs.tile_list(points.group, 64)
    k = int(np.flatnonzero((tiles["a"] == 1) & (tiles["b"] == 2))[0])
    table = table_of(points, tile=64, tiles=[k])
    inside = table.n.sum(axis=(1, 2)) + table.n_undefined.sum(axis=(1, 2))
    # (0, 0) (0, 1) (0, 2) (0, 3) (1, 1) (1, 2)
    assert inside[5] > 0 and inside.sum() == inside[5]


@pytest.mark.stat
def test_tiles_are_chosen_in_proportion(points):
    tiles = pairs.tile_list(points.group, 20)
    total = int(tiles["pairs"].sum())
    chosen = pairs.choose_tiles(points.group, total // 5, seed=1, tile=20)
    assert len(set(chosen)) == len(chosen) and (np.diff(chosen) > 0).all()
    assert abs(tiles["pairs"][chosen].sum() / (total / 5) - 1) < 0.1
    for a, b in {(t["a"], t["b"]) for t in tiles}:
        own = np.flatnonzero((tiles["a"] == a) & (tiles["b"] == b))
        assert abs(len(set(own) & set(chosen)) - len(own) / 5) <= 1
    # Every tile as likely as any other: 400 draws, 5 standard deviations
    draws = np.zeros(len(tiles))
    for seed in range(400):
        draws[pairs.choose_tiles(points.group, total // 5, seed=seed, tile=20)] += 1
    assert abs(draws / 400 - 0.2).max() < 5 * np.sqrt(0.2 * 0.8 / 400)


def test_all_tiles_are_chosen_where_there_are_fewer_pairs(points):
    chosen = pairs.choose_tiles(points.group, 10**9, tile=20)
    np.testing.assert_array_equal(chosen, np.arange(len(pairs.tile_list(points.group, 20))))


def test_near_and_far_pass_add_up_to_all_pairs(points):
    d_near = D_EDGES[3]
    far = table_of(points, d_near=d_near)
    near = pairs.near_pairs(*points.arguments, D_EDGES, ANGLES, d_near=d_near)
    assert far.n[:, :3].sum() == 0 and near.n[:, 3:].sum() == 0 and near.n.sum() > 1000
    assert_same(near + far, table_of(points))


def test_tables_of_other_bins_do_not_add(points):
    table = table_of(points)
    other = pairs.pair_statistics(*points.arguments, D_EDGES + 0.1, ANGLES)
    with pytest.raises(ValueError, match="d_edges must be the same"):
        table + other
    with pytest.raises(ValueError, match="groups must be the same"):
        table + table_of(points, n_groups=5)
    full = np.full_like(table.n, MAX_PAIRS)
    sums = {name: getattr(table, name) for name in ("sum_q", "sum_q2_high", "sum_q2_low")}
    crowded = pairs.PairTable(
        n=full, n_undefined=table.n, d_edges=D_EDGES, theta_edges_deg=ANGLES, **sums
    )
    with pytest.raises(ValueError, match="a cell must hold at most"):
        crowded + crowded


def test_no_points_have_no_pairs():
    none = np.zeros((0, 3), np.float32)
    empty = (np.zeros((0, 2), np.uint64), 100, none, none, np.zeros(0, np.int32))
    assert pairs.pair_statistics(*empty, [0, 1], [0, 180]).n.sum() == 0
    assert pairs.near_pairs(*empty, [0, 1], [0, 180], d_near=1).n.sum() == 0
    assert pairs.spatial_map(empty[0], none, none, 1, 30).shape == (0,)
    assert len(pairs.tile_list(np.zeros(0, np.int32))) == 0
    assert len(pairs.choose_tiles(np.zeros(0, np.int32), 10)) == 0


def wrong(points):
    """Keyword: its wrong value, and what the error says."""
    bits = points.bits.copy()
    bits[5, -1] |= np.uint64(1) << np.uint64(63)
    far = points.positions.copy()
    far[7, 1] = np.nan
    # fmt: off
    return {
        "bits past the end": ({"bits": bits}, "bits past n_directions must be 0, row 5"),
        "bits": ({"bits": points.bits[0]}, r"bits must have shape \(N, words\), got \(8,\)"),
        "float bits": ({"bits": points.visible * 1.0}, "bits must be uint64"),
        "n_directions": ({"n_directions": 0}, r"n_directions must lie in \[1, 46340\], got 0"),
        "too many directions": ({"n_directions": 600}, "bits must have 10 words or more a row"),
        "positions": ({"positions": far}, "positions must be finite, row 7"),
        "few positions": ({"positions": far[:9]}, "positions must have one row per row of bits"),
        "normals": ({"normals": 2 * points.normals}, "normals must be unit vectors, row 0"),
        "unordered": ({"group": points.group[::-1]}, "points must be ordered by group"),
        "negative group": ({"group": points.group - 1}, r"group must lie in \[0, 2\), got -1"),
        "n_groups": ({"n_groups": 2}, r"group must lie in \[0, 2\), got 2"),
        "d_edges": ({"d_edges": [1, 0]}, "d_edges must increase"),
        "no d_edges": ({"d_edges": []}, "d_edges must"),
        "NaN edge": ({"d_edges": [0, np.nan]}, "d_edges must lie in"),
        "angles": ({"theta_edges_deg": [0, 181]}, r"theta_edges_deg must lie in \[0, 180"),
        "bins": ({"d_edges": np.linspace(0, 2, 1500), "theta_edges_deg": np.linspace(0, 180, 1501)},
                 "must make at most 2097152 bins, got 2248500"),
        "tiles": ({"tiles": [6]}, r"tiles must lie in \[0, 6\), got 6"),
        "negative tile": ({"tiles": [-1]}, "tiles must be >= 0"),
        "tile": ({"tile": 0}, "tile must be a whole number >= 1, got 0"),
        "d_near": ({"d_near": 0.123}, "d_near must be one of d_edges, got 0.123"),
        "domain": ({"domain": "cone", "directions": far}, "domain must be sphere, joint or union"),
        "no directions": ({"domain": "joint"}, "directions must be given"),
        "directions": ({"domain": "joint", "directions": far[:4]}, "one row per bit, 500, got 4"),
        "min_bits": ({"min_bits": 0}, "min_bits must be >= 1, got 0"),
        "undefined": ({"undefined": "nan"}, "undefined must be skip or one_if_both, got 'nan'"),
        "threads": ({"threads": 0}, r"threads must be a whole number in \[1, 1024\], got 0"),
        "isa": ({"isa": "sse9"}, "isa must be portable, avx2 or avx512"),
    }
    # fmt: on


@pytest.mark.parametrize("case", wrong(random_points(n=50)).keys())
def test_wrong_arguments_are_refused(case):
    points = random_points(n=700)
    good = dict(
        bits=points.bits,
        n_directions=500,
        positions=points.positions,
        normals=points.normals,
        group=points.group,
        d_edges=D_EDGES,
        theta_edges_deg=ANGLES,
    )
    bad, message = wrong(points)[case]
    with pytest.raises(ValueError, match=message):
        pairs.pair_statistics(**(good | bad))


def test_progress_counts_pairs_and_may_stop_the_call():
    points = random_points(n=2000, n_directions=9000, groups=1)
    calls = []
    some = {"tile": 100, "tiles": np.arange(20), "threads": 1, "isa": "portable"}
    some["progress"] = lambda *c: calls.append(c)
    pairs.pair_statistics(*points.arguments, D_EDGES, ANGLES, **some)
    tiles = pairs.tile_list(points.group, 100)
    assert calls[-1] == (tiles["pairs"][:20].sum(),) * 2

    def stop(done, total):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        pairs.pair_statistics(*points.arguments, D_EDGES, ANGLES, isa="portable", progress=stop)
