"""Subfields on first use: built when a ray needs them, given up when the budget ends."""

import threading

import numpy as np
import pytest

import viscache as vc
from vlf.field_rays import flat, rays_of_every_kind, soup

SCENE = vc.Scene.from_arrays(*soup(2000))
CHORDS = rays_of_every_kind(flat(SCENE), 6000, 129)["chords"]


def lazy(max_bytes=1 << 30):
    settings = vc.Vlf(n_directions=129, n_tiles=32, bsp_depth=3, max_bytes=max_bytes, lazy=True)
    return vc.VisibilityField(SCENE, settings=settings)


def test_nothing_is_built_before_a_ray_comes():
    f = lazy()
    assert f.stats["subfields"] == f.stats["built"] == 0
    f.occluded(CHORDS[:1, 0], CHORDS[:1, 1])
    assert f.stats["subfields"] == f.stats["built"] == 1
    f.occluded(CHORDS[:1, 0], -CHORDS[:1, 1])  # of the same axis
    assert f.stats["built"] == 1


def test_a_lazy_field_ends_as_the_whole_one():
    whole, f = vc.VisibilityField(SCENE, 129, 32, 3), lazy()
    axes = vc.vlf.directions(129)
    f.occluded(np.zeros_like(axes), axes)
    assert f.stats == whole.stats | {"built": 129}
    for direction in range(129):
        a, b = whole._core.subfield(direction), f._core.subfield(direction)
        assert all((a[name] == b[name]).all() for name in a)


def test_the_longest_unused_are_evicted_and_built_again():
    whole = vc.VisibilityField(SCENE, 129, 32, 3)
    each = (whole.stats["bytes"] - 2000 * 96) / 129
    f = lazy(int(2000 * 96 + 20 * each))
    expected = whole.intersect(CHORDS[:, 0], CHORDS[:, 1])
    for _ in range(2):
        found = f.intersect(CHORDS[:, 0], CHORDS[:, 1])
        for a, b in zip(found, expected, strict=True):
            np.testing.assert_array_equal(a, b)
        assert f.stats["bytes"] <= f.settings.max_bytes
        assert 10 < f.stats["subfields"] < 30
    assert f.stats["evicted"] == f.stats["built"] - f.stats["subfields"] > 129
    # Recently used ones are there still
    axes = vc.vlf.directions(129)
    f.occluded(np.zeros((5, 3)), axes[:5])
    built = f.stats["built"]
    for _ in range(10):
        f.occluded(np.zeros((5, 3)), axes[:5])
    assert f.stats["built"] == built


def test_threads_that_ask_at_once_get_right_answers_from_a_small_store():
    whole = vc.VisibilityField(SCENE, 129, 32, 3)
    expected = whole.occluded(CHORDS[:, 0], CHORDS[:, 1])
    f = lazy(2000 * 96 + 100_000)
    wrong = []

    def ask(part):
        for _ in range(3):
            rows = CHORDS[part::4]
            found = f.occluded(rows[:, 0], rows[:, 1], threads=2)
            wrong.append(int((found != expected[part::4]).sum()))

    workers = [threading.Thread(target=ask, args=(k,)) for k in range(4)]
    for w in workers:
        w.start()
    for w in workers:
        w.join()
    assert wrong == [0] * 12
    assert f.stats["evicted"] > 0


def test_a_budget_below_the_triangles_is_refused():
    with pytest.raises(MemoryError, match="triangles alone take 192000 bytes, max_bytes is 1000"):
        lazy(1000)
