"""Ranges, random points and Latin hypercubes."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from viscache.sweeps import designs
from viscache.sweeps.designs import Range
from viscache.sweeps.sweep import SweepFile, sweep

SMALL = {"size": (32, 24), "metrics": ("rel_l1",)}


def test_a_log_range_has_equal_ratios_and_both_ends():
    values = Range(2, 32, "log").steps(5)
    np.testing.assert_allclose(values, [2, 4, 8, 16, 32])
    assert values[0] == 2.0 and values[-1] == 32.0


def test_a_linear_range_of_whole_numbers_has_no_value_twice():
    assert Range(1, 4, whole=True).steps(9) == [1, 2, 3, 4]
    assert Range(0, 1).steps(3) == [0.0, 0.5, 1.0]


@given(low=st.floats(1e-6, 1e6), ratio=st.floats(1.001, 1e6), u=st.floats(0, 1), log=st.booleans())
def test_values_of_a_range_lie_in_it(low, ratio, u, log):
    made = Range(low, low * ratio, "log" if log else "linear")
    (value,) = made.at(np.array([u]))
    assert made.low <= value <= made.high


@given(n=st.integers(1, 200), seed=st.integers(0, 2**63 - 1))
def test_a_latin_hypercube_has_one_point_in_each_slice_of_every_parameter(n, seed):
    points = designs.latin_hypercube({"a": Range(0, 1), "b": Range(1, 16, "log")}, n, seed=seed)
    for name, position in (("a", lambda v: v), ("b", lambda v: np.log2(v) / 4)):
        slices = np.floor([position(p[name]) * n for p in points] + np.array(1e-9)).astype(int)
        assert sorted(np.minimum(slices, n - 1)) == list(range(n))


def test_random_points_fall_into_some_slice_twice_as_a_hypercube_never_does():
    points = designs.random({"a": Range(0, 1)}, 50)
    assert len({int(p["a"] * 50) for p in points}) < 50


def test_a_hypercube_takes_every_value_of_a_list_equally_often():
    points = designs.latin_hypercube({"c_n": [4, 8, 16], "c_e": Range(2, 32)}, 30)
    assert sorted(p["c_n"] for p in points) == [4] * 10 + [8] * 10 + [16] * 10


def test_the_same_seed_gives_the_same_points_whatever_parameters_come_after():
    one = designs.random({"a": Range(0, 1)}, 9, seed=3)
    two = designs.random({"a": Range(0, 1), "b": [1, 2]}, 9, seed=3)
    assert [p["a"] for p in one] == [p["a"] for p in two]
    assert one != designs.random({"a": Range(0, 1)}, 9, seed=4)


@pytest.mark.parametrize(
    ("over", "says"),
    [
        ({"c_e": {"log": [0, 4], "n": 3}}, r"log range must have low > 0, got \(0, 4\)"),
        ({"c_e": {"log": [4, 2], "n": 3}}, "low < high"),
        ({"c_e": {"log": [2, 4]}}, "how many values"),
        ({"c_e": {"log": [2, 4], "n": 1}}, "n of a range must be a whole number >= 2, got 1"),
        ({"c_e": {"lgo": [2, 4], "n": 3}}, "no 'lgo'; did you mean 'log'"),
        ({"c_e": {"log": [2, 4], "linear": [2, 4], "n": 3}}, "linear or log"),
        ({"c_e": {"log": 2, "n": 3}}, r"log of c_e must be \[low, high\], got 2"),
        ({"c_e": {"linear": [2, "x"], "n": 3}}, "must have two numbers"),
        ({"c_f": {"log": [2, 4], "n": 3}}, "unknown parameter 'c_f'.*did you mean 'c_"),
    ],
)
def test_a_bad_range_is_refused_by_name_before_the_first_frame(fake_vc, over, says):
    with pytest.raises(ValueError, match=says):
        sweep("room", "whitted", over=over, **SMALL)
    assert not fake_vc.CALLS


@pytest.mark.parametrize(
    ("design", "over", "says"),
    [
        ({"kind": "latin", "n": 3}, {"a": [1]}, "did you mean 'latin_hypercube'"),
        ({"kind": "random"}, {"a": [1]}, "how many points"),
        ({"kind": "random", "n": 0}, {"a": [1]}, "whole number >= 1, got 0"),
        ({"kind": "random", "n": 3, "sede": 1}, {"a": [1]}, "did you mean 'seed'"),
        ({"kind": "random", "n": 3, "seed": -1}, {"a": [1]}, "seed must be in"),
        ({"kind": "random", "n": 3}, {"a": {"log": [1, 2], "n": 4}}, "must not have n"),
        ({"kind": "random", "n": 3}, {"a": 4}, "a range or a list"),
        ({"kind": "random", "n": 3}, {}, "at least one parameter"),
        ({"kind": "random", "n": 3}, [{"a": 1}], "over names and ranges"),
    ],
)
def test_a_bad_design_is_refused(design, over, says):
    with pytest.raises(ValueError, match=says):
        designs.draw(design, over)


def test_a_file_sweeps_a_log_range_and_a_hypercube(fake_vc, tmp_path):
    head = 'scene = "room"\nsize = [32, 24]\nmetrics = ["rel_l1"]\n'
    path = tmp_path / "a.toml"
    path.write_text(head + "[over]\nc_e = {log = [2, 32], n = 5}\nintegrator.n_vpls = [1, 2]\n")
    grid = SweepFile.load(path).run(None)
    assert dict(grid.sizes) == {"c_e": 5, "n_vpls": 2, "repeat": 1, "group": 1}
    path.write_text(
        head + '[design]\nkind = "latin_hypercube"\nn = 6\n'
        "[over]\nc_e = {log = [2, 32]}\nintegrator.n_vpls = {linear = [1, 9], whole = true}\n"
    )
    drawn = SweepFile.load(path).run(None)
    assert drawn.sizes["point"] == 6 and set(drawn.n_vpls.dims) == {"point"}
    np.testing.assert_allclose(drawn.rel_l1[:, 0], drawn.c_e / 100, rtol=1e-5)
