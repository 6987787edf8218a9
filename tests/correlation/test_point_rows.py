"""Rows whose columns are points: the bits of single rays, from both engines."""

import numpy as np
import pytest

import viscache as vc
from correlation.scenes import clutter, unpacked
from correlation.test_rows import spawned


def points_of(scene, n, seed=1):
    return vc.correlation.surface_points(scene, n, points="area", seed=seed)


def lamps(scene, n):
    return np.random.default_rng(4).uniform(*scene.bounds, (n, 3)).astype(np.float32)


def lie_above(points, targets):
    d = targets[None] - points.positions[:, None]
    n = points.normals[:, None]
    # In the order of the core, so that planes through a target are no matter
    return np.asarray(d[..., 0] * n[..., 0] + d[..., 1] * n[..., 1] + d[..., 2] * n[..., 2] > 0)


@pytest.mark.parametrize("count", [1, 64, 70, 513])
def test_rows_say_what_single_rays_say(count):
    scene = clutter()
    points, targets = points_of(scene, 300), lamps(scene, count)
    rows = vc.correlation.point_rows(scene, points, targets, engine="packets")
    assert rows.n_directions == count and rows.bits.shape == (300, -(-count // 512) * 8)
    wanted = lie_above(points, targets)
    eyes = vc.EyePoints(points.positions, points.normals, _origins=spawned(scene, points))
    single = scene.oracle(vc.Exact(engine="packets"))
    i, k = np.nonzero(wanted)
    expected = np.zeros_like(wanted)
    expected[i, k] = single.pairs(eyes, i, vc.FarEnds.points(targets[k])).visible
    np.testing.assert_array_equal(unpacked(rows.bits, count), expected)
    assert not unpacked(rows.bits, 64 * rows.bits.shape[1])[:, count:].any()
    assert rows.n_rays == wanted.sum()
    assert count < 64 or 0.05 < expected.sum() / wanted.sum() < 0.95


@pytest.mark.parametrize(
    "spec", ["room?triangles=3000", "cornell_box", "random_triangles?triangles=5000"]
)
@pytest.mark.parametrize("threads", [1, 3])
def test_engines_and_threads_change_no_bit(spec, threads):
    scene = vc.scenes.build(spec)
    points, ends = points_of(scene, 5000), points_of(scene, 80, 7)
    surfaces = vc.FarEnds.surfaces(ends.positions, ends.normals)
    for targets in (surfaces, vc.FarEnds.points(lamps(scene, 80))):
        packets, shafts, auto = (
            vc.correlation.point_rows(scene, points, targets, engine=e, threads=t)
            for e, t in (("packets", 1), ("shafts", threads), ("auto", threads))
        )
        assert packets.engine == "embree" and shafts.engine == "shafts"
        assert packets.bits.tobytes() == shafts.bits.tobytes() == auto.bits.tobytes()
        assert packets.n_rays == shafts.n_rays == auto.n_rays


def test_the_order_of_points_changes_no_bit():
    scene = vc.scenes.build("room?triangles=3000")
    points, targets = points_of(scene, 5000), lamps(scene, 70)
    turned = np.random.default_rng(0).permutation(5000)
    other = vc.correlation.rows.SurfacePoints(
        **{n: getattr(points, n) for n in ("width", "height", "n_bad_normals", "n_misses")},
        **{
            n: getattr(points, n)[turned]
            for n in ("positions", "normals", "theta_normals", "group", "stratum")
        },
    )
    rows = [
        vc.correlation.point_rows(scene, p, targets, engine="shafts").bits for p in (points, other)
    ]
    np.testing.assert_array_equal(rows[0][turned], rows[1])


def test_the_default_says_what_it_chose_and_why():
    scene = vc.scenes.build("room?triangles=3000")
    few = vc.correlation.point_rows(scene, points_of(scene, 100), lamps(scene, 20))
    assert few.engine == "embree"
    assert few.reason == f"shafts answered 0% of {few.n_rays} queries"
    many = vc.correlation.point_rows(scene, points_of(scene, 20_000), lamps(scene, 70))
    assert many.engine == "shafts" and "shafts answered" in many.reason


def test_progress_counts_points_to_the_end():
    scene = clutter()
    points, sky = points_of(scene, 9000), vc.correlation.DirectionSet(map_size=24)
    for call, ends in (
        (vc.correlation.point_rows, lamps(scene, 70)),
        (vc.correlation.visibility_rows, sky),
    ):
        seen = []
        call(scene, points, ends, progress=lambda *a, seen=seen: seen.append(a))
        assert seen[-1] == (9000, 9000) and seen == sorted(seen)


@pytest.mark.parametrize(
    ("targets", "options", "says"),
    [
        (vc.FarEnds.directions([[0, 0, 1.0]]), {}, "targets must be points or surfaces"),
        ([[0, 0, np.nan]], {}, "must be finite"),
        (np.zeros((2, 2)), {}, r"shape \(N, 3\), got \(2, 2\)"),
        (np.zeros((0, 3)), {}, "there must be a far end"),
        (np.ones((1, 3)), {"engine": "batch"}, 'engine must be "auto", "packets" or "shafts"'),
        (np.ones((1, 3)), {"threads": 0}, "threads must be"),
    ],
)
def test_bad_arguments_are_refused(targets, options, says):
    scene = clutter()
    with pytest.raises(ValueError, match=says):
        vc.correlation.point_rows(scene, points_of(scene, 20), targets, **options)
