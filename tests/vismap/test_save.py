"""Files of caches: the same cache comes back, anything else is refused with its reason."""

import numpy as np
import pytest

import viscache as vc
from viscache.vismap import cache_file
from vismap.scenes import SIZE, clutter, made, pixels, same, view


@pytest.fixture
def saved(tmp_path):
    cache, _ = made(n_startup=30, preset="auto", m=4)
    points = pixels(cache)
    found = cache.lookup(points.positions, points.normals, points.d_max)
    cache.compare(found, np.tile([0.0, 1.0, 0.0], (len(points), 1, 1)), np.zeros((len(points), 1)))
    cache.end_frame()
    path = tmp_path / "cache.npz"
    cache.save(path)
    return cache, path


def test_a_loaded_cache_is_the_saved_one(saved):
    cache, path = saved
    back = vc.VisibilityMapCache.load(path, clutter())
    assert same(back, cache) and len(back) > 10
    assert (back.settings, back.frame, back.rays) == (cache.settings, cache.frame, cache.rays)
    assert back.thresholds == cache.thresholds != vc.MapSettings().thresholds()
    points = pixels(cache)
    a, b = (c.lookup(points.positions, points.normals, points.d_max) for c in (cache, back))
    np.testing.assert_array_equal(a.ids, b.ids)
    np.testing.assert_array_equal(a.beta, b.beta)
    # Both go on alike, and neither starts up again
    reports = [c.update(view(), size=SIZE) for c in (cache, back)]
    assert reports[0] == reports[1] and reports[0].startup == 0
    assert same(back, cache)


def test_a_cache_of_another_scene_is_refused(saved):
    _, path = saved
    with pytest.raises(ValueError, match="must be of the scene given, whose hash is") as e:
        vc.VisibilityMapCache.load(path, clutter(seed=1))
    assert clutter().content_hash in str(e.value)
    assert clutter(seed=1).content_hash in str(e.value)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"settings": {"bogus": 1}}, "must have the settings of one: .*bogus"),
        ({"settings": []}, r"settings must be a table, got \[\]"),
        ({"settings": {"m": "x"}}, "must have the settings of one"),
        ({"frame": -5}, "frame must be a whole number in .0, 2.63., got -5"),
        ({"frame": None}, "frame must be a whole number in .0, 2.63., got None"),
        ({"started": 3}, "started must be true or false, got 3"),
        ({"rays": 1.5}, "rays must be a whole number in .0, 2.63., got 1.5"),
        ({"thresholds": [1]}, "thresholds must be two finite numbers"),
        ({"thresholds": [0.1, float("nan")]}, "thresholds must be two finite numbers"),
    ],
)
def test_heads_that_were_made_by_hand_are_refused(saved, change, says):
    """Their digest fits, so what they say is checked."""
    _, path = saved
    fields, arrays = cache_file.FORMAT.read_npz(path)
    cache_file.FORMAT.write_npz(path, fields | change, arrays)
    with pytest.raises(ValueError, match=rf"cache\.npz.* {says}"):
        vc.VisibilityMapCache.load(path, clutter())


def test_a_file_that_cannot_be_written_leaves_nothing(saved, tmp_path):
    cache, path = saved
    with pytest.raises(OSError, match="cannot write"):
        cache.save(tmp_path / "nowhere" / "cache.npz")
    with pytest.raises(FileNotFoundError, match="no such file"):
        vc.VisibilityMapCache.load(tmp_path / "missing.npz", clutter())
    assert list(tmp_path.iterdir()) == [path]
