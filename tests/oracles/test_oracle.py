"""Caches as modules that take arrays of points and return bits."""

import numpy as np
import pytest

import viscache as vc

ROOM = "room?triangles=3000"


@pytest.fixture(scope="module")
def points(room):
    """Points spread over all surfaces by area: no camera."""
    return area_points(room, 3000)


def area_points(scene, count, seed=1):
    """Uniform points on the triangles of a scene."""
    random = np.random.default_rng(seed)
    corners = np.concatenate(
        [np.asarray(m["vertices"])[np.asarray(m["triangles"])] for m in scene.meshes()]
    ).astype(np.float64)
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(cross, axis=1)
    chosen = random.choice(len(area), count, p=area / area.sum())
    u, v = random.random((2, count, 1))
    flip = u + v > 1
    u, v = np.where(flip, 1 - u, u), np.where(flip, 1 - v, v)
    at = corners[chosen]
    places = at[:, 0] + u * (at[:, 1] - at[:, 0]) + v * (at[:, 2] - at[:, 0])
    return vc.EyePoints(places, cross[chosen])


def lamps(scene, count=64, seed=2):
    low, high = np.asarray(scene.bounds, dtype=np.float64)
    share = np.random.default_rng(seed).uniform(0.2, 0.8, (count, 3))
    return vc.FarEnds.points(low + share * (high - low))


def test_exact_answers_are_those_of_single_rays(room, points):
    ends = lamps(room)
    answer = room.oracle(vc.Exact()).block(points, ends)
    # Segments without normals have another offset; answers differ only at grazing angles
    above = points.positions + 1e-4 * points.normals
    assert np.mean(answer.visible != room.visible(above[:, None], ends.positions)) < 2e-3
    assert answer.counters["queries"] == answer.counters["rays"] == len(points) * len(ends)
    assert answer.bits.shape == (len(points), 1)


@pytest.mark.parametrize(
    "visibility",
    [
        vc.Exact(),
        vc.Aqvc(c_e=6),
        vc.Aqvc(c_e=6, preset="paper"),
        vc.ShadowMap(resolution=32),
        vc.NeePlusPlus(n_voxels=4, learn_pixels=200),
    ],
    ids=["exact", "waves", "paper", "shadow maps", "nee++"],
)
def test_answers_do_not_depend_on_threads(room, points, visibility):
    one, three = (
        room.oracle(visibility, threads=n, rays=vc.Bsp()).block(points[:1500], lamps(room, 40))
        for n in (1, 3)
    )
    np.testing.assert_array_equal(one.bits, three.bits)
    assert one.counters == three.counters
    if one.weights is not None and three.weights is not None:
        np.testing.assert_array_equal(one.weights, three.weights)
    assert (one.weights is not None) == isinstance(visibility, vc.NeePlusPlus)


def test_the_order_of_points_does_not_matter(room, points):
    ends, oracle = lamps(room), room.oracle(vc.Exact())
    shuffled = np.random.default_rng(0).permutation(len(points))
    answer = oracle.block(points, ends).visible
    np.testing.assert_array_equal(answer[shuffled], oracle.block(points[shuffled], ends).visible)


def test_wanted_bits_alone_are_asked(room, points):
    ends, oracle = lamps(room), room.oracle(vc.Exact())
    wanted = np.random.default_rng(0).random((len(points), len(ends))) < 0.3
    some, everything = oracle.block(points, ends, wanted), oracle.block(points, ends)
    np.testing.assert_array_equal(some.visible, everything.visible & wanted)
    assert some.counters["rays"] == np.count_nonzero(wanted)
    packed = oracle.block(points, ends, np.packbits(wanted, 1, "little").view(np.uint64))
    np.testing.assert_array_equal(some.bits, packed.bits)


def test_pairs_are_the_entries_of_the_block(room, points):
    ends, oracle = lamps(room), room.oracle(vc.Exact())
    random = np.random.default_rng(4)
    index, column = random.integers(0, len(points), 5000), random.integers(0, len(ends), 5000)
    answer = oracle.pairs(points, index, ends[column])
    np.testing.assert_array_equal(answer.visible, oracle.block(points, ends).visible[index, column])
    cached = room.oracle(vc.Aqvc(c_e=8)).pairs(points, index, ends[column])
    assert np.mean(cached.visible != answer.visible) < 0.1
    assert cached.counters["rays"] < cached.counters["queries"]


FULL = {"storage": "exact"}


@pytest.mark.parametrize(
    "paper",
    [None, FULL, {**FULL, "batch": 1}, {**FULL, "queue": 64, "batch": 0}, {}, {"digest_bits": 4}],
    ids=["waves", "full keys", "one by one", "queue", "hashed", "collisions"],
)
def test_clusters_tell_whose_ray_answered(room, points, paper):
    ends = lamps(room, 30)
    form = {} if paper is None else {"preset": "paper", "paper": vc.PaperForm(**paper)}
    oracle = room.oracle(vc.Aqvc(c_e=8, **form))  # type: ignore[arg-type]
    answer = oracle.block(points, ends, clusters=True)
    log, seen = answer.clusters, answer.visible
    np.testing.assert_array_equal(answer.bits, oracle.block(points, ends).bits)
    assert len(np.unique(log[["row", "column"]])) == len(log) == len(points) * len(ends)
    row, column, source = log["row"], log["column"], log["representative"]
    # Every ray belongs to one query, which it answers
    exact = room.oracle(vc.Exact()).block(points, ends).visible
    rays, own = answer.counters["rays"], log["traced"]
    assert own.sum() == rays if paper is not None else own.sum() <= rays
    assert (source == row)[own].all()
    np.testing.assert_array_equal(seen[row, column][own], exact[row, column][own])
    # Queries of one cluster share the answer and the representative
    order = np.argsort(log["cluster"], kind="stable")
    same = np.diff(log["cluster"][order].astype(np.int64)) == 0
    for shared in (seen[row, column][order], source[order]):
        np.testing.assert_array_equal(shared[1:][same], shared[:-1][same])
    # A representative's ray may be to another light only if the table confuses keys
    through = exact[source, column] == seen[row, column]
    lossy = paper is not None and "storage" not in paper
    assert through.mean() > 0.95 if lossy else through.all()
    assert through.all() != ("digest_bits" in (paper or {}))
    assert log["level"].max() >= 1
    with pytest.raises(ValueError, match="clusters must be asked for"):
        _ = oracle.block(points, ends).clusters


def test_queries_of_exact_rays_are_their_own_clusters_and_other_methods_have_none(room, points):
    log = room.oracle(vc.Exact()).block(points[:50], lamps(room, 5), clusters=True).clusters
    assert len(np.unique(log["cluster"])) == len(log) == 250 and log["traced"].all()
    for visibility in (vc.ShadowMap(resolution=32), vc.NeePlusPlus(n_voxels=4, learn_pixels=200)):
        with pytest.raises(ValueError, match="cannot tell"):
            room.oracle(visibility).block(points[:9], lamps(room, 3), clusters=True)


def test_directions_and_surfaces_are_far_ends_too(room, points):
    along = np.random.default_rng(3).normal(size=(40, 3))
    oracle = room.oracle(vc.Exact())
    far = oracle.block(points, vc.FarEnds.directions(along))
    near = oracle.block(points, vc.FarEnds.directions(along, t_max=1e-3))
    assert np.count_nonzero(near.visible) > np.count_nonzero(far.visible)
    others = area_points(room, 30, seed=9)
    surfaces = vc.FarEnds.surfaces(others.positions, others.normals, 1.0)
    exact = oracle.block(points, surfaces)
    cached = room.oracle(vc.Aqvc(c_e=4)).block(points, surfaces)
    assert 0 < np.count_nonzero(exact.visible) < exact.visible.size
    assert np.mean(exact.visible != cached.visible) < 0.1
    sky = vc.FarEnds.solid_angle(along, 40 / (4 * np.pi))
    assert np.mean(oracle.block(points, sky).visible != far.visible) == 0


def test_density_comes_from_neighbours_where_none_is_given():
    random = np.random.default_rng(7)
    flat = np.column_stack([random.random((20000, 2)), np.zeros(20000)])
    eyes = vc.EyePoints(flat, np.broadcast_to([0.0, 0, 1], flat.shape)).with_density()
    inner = np.all((flat[:, :2] > 0.1) & (flat[:, :2] < 0.9), axis=1)
    # E[k/(π r_k²)] of a Poisson process is λ·k/(k−1)
    assert np.mean(np.asarray(eyes.density)[inner]) == pytest.approx(20000 * 8 / 7, rel=0.03)
    given = vc.EyePoints(flat, np.broadcast_to([0.0, 0, 1], flat.shape), 5.0)
    assert np.all(np.asarray(given.with_density().density) == 5)
    alone = vc.EyePoints([(0, 0, 0)], [(0, 0, 1)]).with_density()
    assert np.asarray(alone.density).tolist() == [0]
    equal = vc.EyePoints(np.zeros((30, 3)), np.ones((30, 3))).with_density()
    assert np.isfinite(np.asarray(equal.density)).all()


@pytest.mark.parametrize(
    ("make", "match"),
    [
        (lambda: vc.EyePoints(np.zeros((3, 2)), np.ones((3, 3))), r"\(N, 3\)"),
        (lambda: vc.EyePoints(np.zeros((3, 3)), np.ones((2, 3))), "3 rows"),
        (lambda: vc.EyePoints([(0, 0, np.nan)], [(0, 0, 1)]), "row 0"),
        (lambda: vc.EyePoints([(0, 0, 0)], [(0, 0, 0)]), "not be zero"),
        (lambda: vc.EyePoints([(0, 0, 0)], [(0, 0, 1)], -1.0), "density"),
        (lambda: vc.EyePoints([(0, 0, 0)], [(0, 0, 1)], [1.0, 2.0]), "density"),
        (lambda: vc.EyePoints("abc", [(0, 0, 1)]), "must be numbers"),
        (lambda: vc.FarEnds.points(np.zeros((0, 3))), "must be a far end"),
        (lambda: vc.FarEnds.directions([(0, 0, 0)]), "not be zero"),
        (lambda: vc.FarEnds.surfaces([(0, 0, 0)], [(0, 0, np.inf)]), "finite"),
        (lambda: vc.FarEnds.points([(0, 0, 0)], group="lamp"), "group must be one of"),
        (lambda: vc.FarEnds("rays", [(0, 0, 0)]), "kind must be one of"),  # type: ignore[arg-type]
    ],
)
def test_bad_arrays_are_refused(make, match):
    with pytest.raises(ValueError, match=match):
        make()


def test_bad_questions_are_refused_and_lose_nothing(room, points):
    oracle, ends = room.oracle(vc.Aqvc()), lamps(room, 3)
    for call, match in (
        (lambda: oracle.block(points, ends, np.ones((2, 3), dtype=bool)), "wanted must be"),
        (lambda: oracle.block(points, ends, np.ones((len(points), 3))), "wanted must be"),
        (lambda: oracle.block(points, ends, contributions=np.ones((4, 4))), "contributions"),
        (
            lambda: oracle.block(points, ends, contributions=np.full((len(points), 3), np.nan)),
            "finite",
        ),
        (lambda: oracle.block(points.positions, ends), "eyes must be"),
        (lambda: oracle.pairs(points, [0, 1], ends), "index must be"),
        (lambda: oracle.pairs(points, [0, 1, len(points)], ends), "index must be in"),
        (lambda: oracle.pairs(points, [0.5, 1, 2], ends), "integers"),
        (lambda: room.oracle(vc.VisMaps()), "visibility must be"),
        (lambda: room.oracle("exact?"), "visibility|unknown"),
        (lambda: room.oracle(vc.Exact(), use="repair"), "use must be"),
        (lambda: room.oracle(vc.Exact(), threads=0), "threads"),
        (lambda: room.oracle(vc.Exact(), seed=-1), "seed"),
        (lambda: room.oracle(vc.Aqvc(), spp=1 << 63), r"spp must be .* \[1, 2\^20\]"),
        (lambda: oracle.block(vc.EyePoints([(1e20, 0, 0)], [(0, 0, 1)]), ends), "1e16"),
    ):
        with pytest.raises(ValueError, match=match):
            call()
    assert oracle.block(points, ends).visible.shape == (len(points), 3)
