"""ρ, its bin and its sums against the transcription of Section 4."""

from dataclasses import replace

import numpy as np
import pytest

from correlation.points import SUMS, Points, convex_points, random_points, unit
from reference import vismap as reference
from reference.isas import AVAILABLE
from viscache.correlation import pairs

D_EDGES = np.linspace(0.1, 1.3, 25)
ANGLES = np.arange(0, 180.5, 2.0)


def expected(points, d_edges=D_EDGES, angles=ANGLES, domain="sphere", **rules):
    found = reference.all_pairs(
        points.visible,
        points.positions,
        points.normals,
        domain=domain,
        directions=points.directions,
    )
    q, defined = reference.quantized_rho(found, single=domain == "sphere", **rules)
    return reference.pair_sums(
        found, q, defined, points.group, np.array(d_edges, float), np.array(angles, float)
    )


def assert_sums(table, sums):
    for name in SUMS:
        np.testing.assert_array_equal(getattr(table, name), sums[name], err_msg=name)
    np.testing.assert_array_equal(table.sum_q2(), sums["sum_q2"])


@pytest.mark.parametrize("isa", AVAILABLE)
@pytest.mark.parametrize("n_directions", [64, 500, 2305])
def test_sums_equal_the_transcription(isa, n_directions):
    points = random_points(n_directions=n_directions, seed=n_directions)
    table = pairs.pair_statistics(*points.arguments, D_EDGES, ANGLES, isa=isa)
    sums = expected(points)
    assert sums["n"].sum() > 30000 and sums["n_undefined"].sum() > 5000
    assert_sums(table, sums)


@pytest.mark.parametrize("isa", AVAILABLE)
@pytest.mark.parametrize(("min_bits", "undefined"), [(60, "skip"), (30, "one_if_both")])
def test_rules_for_pairs_without_correlation(isa, min_bits, undefined):
    points = random_points()
    table = pairs.pair_statistics(
        *points.arguments, D_EDGES, ANGLES, isa=isa, undefined=undefined, min_bits=min_bits
    )
    rules = {"min_bits": min_bits, "one_if_both": undefined == "one_if_both"}
    assert_sums(table, expected(points, **rules))


@pytest.mark.parametrize("domain", ["joint", "union"])
@pytest.mark.parametrize("rules", [{}, {"one_if_both": True}], ids=str)
def test_domains_equal_the_transcription(domain, rules):
    """Also where rows claim to see below their own plane, which does not count."""
    convex = convex_points(120, edge=16)
    random = np.random.default_rng(0)
    visible = convex.visible & (random.random(convex.visible.shape) < 0.8)
    visible[:10] = convex.visible[:10]
    visible[20:30] |= random.random((10, 256)) < 0.1
    points = Points(
        visible=visible,
        positions=convex.positions,
        normals=convex.normals,
        group=(np.arange(120) // 60).astype(np.int32),
        directions=convex.directions,
    )
    sums = expected(points, domain=domain, **rules)
    for isa in AVAILABLE:
        table = pairs.pair_statistics(
            *points.arguments,
            D_EDGES,
            ANGLES,
            domain=domain,
            directions=points.directions,
            undefined="one_if_both" if rules else "skip",
            isa=isa,
            tile=50,
        )
        assert_sums(table, sums)
    near = pairs.near_pairs(
        *points.arguments,
        D_EDGES,
        ANGLES,
        d_near=D_EDGES[-1],
        domain=domain,
        directions=points.directions,
        undefined="one_if_both" if rules else "skip",
    )
    assert_sums(near, sums)


EDGES = {
    "one bin": ([0, np.inf], [0, 180]),
    "linear to infinity": ([*np.linspace(0, 1, 129)[:-1], np.inf], np.arange(0, 181, 1.0)),
    "logarithmic": (np.geomspace(1e-6, 10, 200), np.geomspace(1e-3, 180, 100)),
    "close together": ([0.5, 0.50001, 0.50002, 0.9], [10, 10.001, 10.002, 179.99]),
    "narrow": ([0.4, 0.6], [30, 31]),
    "past everything": ([100, 200], [0, 180]),
    "many": (np.linspace(0, 2, 1001), np.linspace(0, 180, 1801)),
}


@pytest.mark.parametrize("edges", EDGES.values(), ids=EDGES.keys())
def test_any_edges_bin_exactly(edges):
    points = random_points(n=250, n_directions=70, groups=1)
    sums = expected(points, *edges)
    for isa in AVAILABLE:
        table = pairs.pair_statistics(*points.arguments, *edges, isa=isa)
        assert_sums(table, sums)


@pytest.mark.extreme
@pytest.mark.parametrize("scale", [1e-18, 1e-6, 1e6, 1e18])
def test_scenes_of_any_size_bin_exactly(scale):
    """Where d² overflows it is infinite, and lies in the open bin."""
    points = random_points(n=100, n_directions=70, groups=1)
    with np.errstate(over="ignore", under="ignore"):
        points = replace(points, positions=points.positions * np.float32(scale))
        edges = np.array([0, 0.1, 0.5, 0.9, np.inf]) * scale
        sums = expected(points, edges)
    for isa in AVAILABLE:
        assert_sums(pairs.pair_statistics(*points.arguments, edges, ANGLES, isa=isa), sums)
    assert sums["n"].sum() + sums["n_undefined"].sum() == 100 * 99 // 2


@pytest.mark.extreme
@pytest.mark.parametrize("scale", [1e-30, 1e30])
def test_edges_whose_squares_leave_single_precision_are_refused(scale):
    points = random_points(n=50, n_directions=70)
    with pytest.raises(ValueError, match="d_edges must lie further apart than single precision"):
        pairs.pair_statistics(*points.arguments, np.array([0, 1, 2, 3]) * scale, ANGLES)


@pytest.mark.extreme
def test_pairs_at_an_edge_lie_in_the_bin_past_it():
    """Distances 0, ½, 1 and angles 0 and 90 are exact in single precision; 180 closes its bin."""
    visible = np.zeros((4, 64), bool)
    visible[:, :32] = 1
    points = Points(
        visible=visible,
        group=np.zeros(4, np.int32),
        positions=np.array([[0, 0, 0], [0, 0, 0], [0.5, 0, 0], [1, 0, 0]], np.float32),
        normals=np.array([[0, 0, 1], [0, 0, 1], [0, 1, 0], [0, 0, -1]], np.float32),
    )
    for isa in AVAILABLE:
        table = pairs.pair_statistics(*points.arguments, [0, 0.5, 1, 2], [0, 90, 179, 180], isa=isa)
        # 0-1: d 0; 0-2, 1-2: d ½, 90°; 0-3, 1-3: d 1, 180°; 2-3: d ½, 90°
        assert table.n[0].tolist() == [[1, 0, 0], [0, 3, 0], [0, 0, 2]]


def test_an_angle_in_degrees_is_the_one_between_the_normals():
    """Edges half a thousandth to either side of the true angle hold the pair, from 0.1 to 179."""
    angles = np.array([0.1, 1, 30, 89.9, 90.1, 150, 179])
    radians = np.radians(angles)
    normals = unit(np.stack([np.sin(radians), np.zeros(7), np.cos(radians)], axis=1))
    visible = np.arange(64) < 32
    for angle, normal in zip(angles, normals, strict=True):
        table = pairs.pair_statistics(
            reference.packed(np.stack([visible, visible])),
            64,
            np.zeros((2, 3), np.float32),
            np.array([[0, 0, 1], normal], np.float32),
            np.zeros(2, np.int32),
            [0, 1],
            [0, angle - 5e-4, angle + 5e-4, 180],
        )
        assert table.n[0, 0].tolist() == [0, 1, 0], angle


@pytest.mark.stat
def test_correlation_on_a_convex_body_falls_linearly_with_the_angle():
    """ρ(θ) = 1 − 2θ/π whatever d, for 96² directions (C++ half of the convex scene's test)."""
    points = convex_points(1500)
    edges, angles = [0, 0.5, np.inf], np.arange(0, 181, 2.0)
    table = pairs.pair_statistics(*points.arguments, edges, angles)
    i, j = np.triu_indices(1500, 1)
    # The angle of every pair in double, so that a bin's mean compares with the line over its pairs
    n = points.normals.astype(np.float64)
    theta = 2 * np.arctan2(np.linalg.norm(n[i] - n[j], axis=1), np.linalg.norm(n[i] + n[j], axis=1))
    line = 1 - 2 * theta / np.pi
    far = np.linalg.norm(points.positions[i] - points.positions[j], axis=1) >= 0.5
    for d in (0, 1):
        bins = np.digitize(np.degrees(theta[far == d]), angles) - 1
        count = np.bincount(bins, minlength=90)
        mean_line = np.bincount(bins, line[far == d], minlength=90) / np.maximum(count, 1)
        with np.errstate(invalid="ignore"):
            mean = table.sum_q[0, d] / table.n[0, d] / pairs.SCALE
        enough = count >= 1000
        assert enough.sum() > 70
        np.testing.assert_allclose(mean[enough], mean_line[enough], atol=5e-4)
    single = pairs.phi(points.bits[:300], points.bits, 9216)
    expected_line = 1 - 2 * np.arccos(np.clip(n[:300] @ n.T, -1, 1)) / np.pi
    np.testing.assert_allclose(single, expected_line, atol=0.02)


@pytest.mark.extreme
def test_the_sum_of_squares_has_room_for_a_full_cell():
    """All pairs in one cell with ρ = ±1 fill the packed sums as far as they go."""
    n = 4200
    visible = np.zeros((n, 64), bool)
    visible[::2, :32] = 1
    visible[1::2, 32:] = 1
    points = Points(
        visible=visible,
        positions=np.zeros((n, 3), np.float32),
        normals=np.tile(np.array([[0, 0, 1]], np.float32), (n, 1)),
        group=np.zeros(n, np.int32),
    )
    table = pairs.pair_statistics(*points.arguments, [0, 1], [0, 180], tile=n)
    same, all_ = 2 * (n // 2) * (n // 2 - 1) // 2, n * (n - 1) // 2
    assert table.n.item() == all_ > 4 * 2**21
    assert table.sum_q.item() == (2 * same - all_) * 2**20
    assert table.sum_q2().item() == all_ * 2**40
