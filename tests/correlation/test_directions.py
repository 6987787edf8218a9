"""Direction sets: equal solid angles, compact patches, Lloyd's iteration in its cells."""

import numpy as np
import pytest

import viscache as vc
from sampling.chi_square import p_value
from viscache import _core
from viscache.correlation.directions import patch_order

KINDS = ("centres", "jittered", "lloyd")
SIZES = [1, 2, 3, 7, 16, 31, 32, 33, 48, 96, 100]


def cells(directions, map_size):
    x, y = np.floor(_core.sampling.direction_to_equal_area(directions) * map_size).T.astype(int)
    return np.asarray(y * map_size + x)


@pytest.mark.slow
@pytest.mark.parametrize("map_size", SIZES)
@pytest.mark.parametrize("kind", KINDS)
def test_there_is_one_direction_in_each_cell(map_size, kind):
    found = vc.correlation.DirectionSet(map_size=map_size, kind=kind, seed=5).directions
    assert found.dtype == np.float32
    np.testing.assert_allclose(np.linalg.norm(found.astype(float), axis=1), 1, atol=2e-7)
    np.testing.assert_array_equal(cells(found, map_size), patch_order(map_size))


@pytest.mark.parametrize("map_size", SIZES)
def test_the_order_takes_every_cell_once(map_size):
    order = patch_order(map_size)
    np.testing.assert_array_equal(np.sort(order), np.arange(map_size**2))


@pytest.mark.parametrize("map_size", [32, 64, 96, 128])
def test_packets_words_and_sixteens_are_rectangles_of_cells(map_size):
    y, x = np.divmod(patch_order(map_size), map_size)
    for bits, edges in ((512, {(16, 32), (32, 16)}), (64, {(8, 8)}), (16, {(4, 4)})):
        spans = {
            tuple(np.ptp([a, b], axis=1) + 1)
            for a, b in zip(x.reshape(-1, bits), y.reshape(-1, bits), strict=True)
        }
        assert spans <= edges, bits


@pytest.mark.parametrize("map_size", [23, 40, 67, 100, 150])
def test_packets_of_any_map_are_compact(map_size):
    """Wider than a square of 512 cells by at most 2.2 times, in both directions."""
    y, x = np.divmod(patch_order(map_size), map_size)
    full = map_size**2 // 512 * 512
    for axis in (x, y):
        assert np.ptp(axis[:full].reshape(-1, 512), axis=1).max() + 1 <= 2.2 * 512**0.5
    rows = np.ptp(np.arange(full).reshape(-1, 512) % map_size, axis=1).max() + 1  # scan order
    assert rows > 2.2 * 512**0.5 or map_size < 50


def test_centres_above_any_plane_are_half_of_all():
    """The grid is symmetric about its centre: every direction has its opposite."""
    sky = vc.correlation.DirectionSet()
    normals = np.random.default_rng(0).normal(size=(2000, 3))
    assert set((normals @ sky.directions.T.astype(float) > 0).sum(1).tolist()) == {4608}
    jittered = vc.correlation.DirectionSet(kind="jittered").directions.T.astype(float)
    counts = (normals @ jittered > 0).sum(1)
    assert len(set(counts.tolist())) > 5 and abs(counts - 4608).max() < 40


def test_centres_are_those_of_the_map():
    y, x = np.divmod(patch_order(96), 96)
    p = np.stack([x + 0.5, y + 0.5], 1) / 96
    expected = _core.sampling.equal_area_to_direction(p)
    np.testing.assert_array_equal(vc.correlation.DirectionSet().directions, expected)


def nearest_squared(directions):
    """Mean squared distance of uniform directions to the nearest of a set, in cells."""
    from scipy.spatial import cKDTree

    d = np.random.default_rng(1).normal(size=(200_000, 3))
    found, _ = cKDTree(directions).query(d / np.linalg.norm(d, axis=1)[:, None])
    return float((found**2).mean() * len(directions))


def test_lloyds_iteration_spreads_the_directions_evenly():
    sets = {k: vc.correlation.DirectionSet(map_size=32, kind=k, seed=3).directions for k in KINDS}
    assert nearest_squared(sets["lloyd"]) < 0.75 * nearest_squared(sets["jittered"])
    assert nearest_squared(sets["lloyd"]) < 1.01 * nearest_squared(sets["centres"])


@pytest.mark.stat
def test_jittered_directions_are_uniform_in_their_cells():
    found = vc.correlation.DirectionSet(map_size=200, kind="jittered", seed=9).directions
    inside = (_core.sampling.direction_to_equal_area(found).astype(float) * 200) % 1
    bins = np.floor(inside * 8).astype(int) @ [8, 1]
    expected = np.full(64, 200**2 / 64)
    assert p_value(np.bincount(bins, minlength=64).astype(float), expected) >= 1e-3
    # Negative control: one direction in ten moved to its cell's middle
    bins[::10] = 36
    assert p_value(np.bincount(bins, minlength=64).astype(float), expected) < 1e-6


@pytest.mark.parametrize("kind", KINDS)
def test_the_seed_alone_decides(kind):
    def made(seed):
        return vc.correlation.DirectionSet(map_size=20, kind=kind, seed=seed).directions.tobytes()

    assert made(1) == made(1)
    assert (made(1) == made(2)) == (kind == "centres")


def test_the_directions_of_a_set_cannot_be_changed():
    with pytest.raises(ValueError, match="read-only"):
        vc.correlation.DirectionSet().directions[0, 0] = 1


def test_packet_axes_point_to_the_middle_of_their_patches():
    for map_size in (96, 33, 5):
        sky = vc.correlation.DirectionSet(map_size=map_size)
        axes = sky.packet_axes
        assert axes.shape == (-(-(map_size**2) // 512), 3)
        for k, axis in enumerate(axes):
            mean = sky.directions[512 * k : 512 * (k + 1)].astype(float).mean(0)
            np.testing.assert_allclose(axis, mean / np.linalg.norm(mean), atol=1e-6)
    # 18 patches of equal solid angle reach at most twice as far as a round cap of theirs
    sky = vc.correlation.DirectionSet()
    cosines = np.einsum("pbc,pc->pb", sky.directions.reshape(18, 512, 3), sky.packet_axes)
    assert np.arccos(cosines.min()) < 2 * np.arccos(1 - 2 / 18)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"map_size": 0}, r"map_size must be in \[1, 256\], got 0"),
        ({"map_size": 257}, r"map_size must be in \[1, 256\], got 257"),
        ({"map_size": 9.5}, "map_size must be a whole number, got 9.5"),
        ({"kind": "random"}, "kind must be one of .*, got 'random'"),
        ({"seed": -1}, r"seed must be in \[0, 2\^64\), got -1"),
    ],
)
def test_bad_settings_are_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        vc.correlation.DirectionSet(**arguments)
