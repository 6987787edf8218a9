"""Files of caches: the same cache comes back, anything else is refused with its reason."""

from __future__ import annotations

import io
import json
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import viscache as vc
from viscache.vismap import cache_file
from vismap.scenes import SIZE, clutter, made, pixels, same, view


@pytest.fixture
def saved(tmp_path: Path) -> tuple[vc.VisibilityMapCache, Path]:
    cache, _ = made(n_startup=30, preset="auto", m=4)
    points = pixels(cache)
    found = cache.lookup(points.positions, points.normals, points.d_max)
    cache.compare(found, np.tile([0.0, 1.0, 0.0], (len(points), 1, 1)), np.zeros((len(points), 1)))
    cache.end_frame()
    path = tmp_path / "cache.npz"
    cache.save(path)
    return cache, path


def test_a_loaded_cache_is_the_saved_one(saved: Any) -> None:
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


def test_a_file_with_an_older_name_of_a_setting_is_read(saved: Any, tmp_path: Path) -> None:
    cache, path = saved
    with np.load(path) as file:
        content = {name: file[name] for name in file.files}
    head = json.loads(str(content.pop("head")))
    head["settings"]["settle"] = head["settings"].pop("repeat_passes")
    del head["digest"]
    text = json.dumps(head | {"digest": cache_file.digest(head, content)})
    np.savez(path, head=np.array(text), **content)
    back = vc.VisibilityMapCache.load(path, clutter())
    assert same(back, cache) and back.settings == cache.settings


def test_a_cache_of_another_scene_is_refused(saved: Any) -> None:
    _, path = saved
    with pytest.raises(ValueError, match="must be of the scene given, whose hash is") as e:
        vc.VisibilityMapCache.load(path, clutter(seed=1))
    assert clutter().content_hash in str(e.value)
    assert clutter(seed=1).content_hash in str(e.value)


def rewritten(path: Path, change: Any, arrays: Any = None) -> None:
    """The file with another head."""
    with np.load(path) as file:
        content = {name: file[name] for name in file.files}
    head = json.loads(str(content["head"]))
    change(head)
    content |= {"head": np.array(json.dumps(head))} | (arrays or {})
    np.savez(path, **content)


def test_other_versions_are_refused(saved: Any) -> None:
    _, path = saved
    rewritten(path, lambda head: head.update(format_version=99))
    with pytest.raises(ValueError, match="the cache's version must be 1, got 99"):
        vc.VisibilityMapCache.load(path, clutter())


@pytest.mark.parametrize("name", ["eps_max", "m", "seed"])
def test_changed_settings_are_found_out(saved: Any, name: str) -> None:
    _, path = saved
    rewritten(path, lambda head: head["settings"].update({name: 6}))
    with pytest.raises(ValueError, match="the cache must be undamaged"):
        vc.VisibilityMapCache.load(path, clutter())


def test_changed_records_are_found_out(saved: Any) -> None:
    cache, path = saved
    bits = cache.records().bits.copy()
    bits[0, 0] ^= np.uint64(1)
    rewritten(path, lambda head: None, {"bits": bits})
    with pytest.raises(ValueError, match="the cache must be undamaged"):
        vc.VisibilityMapCache.load(path, clutter())


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"settings": {"bogus": 1}}, "must have the settings of one: .*bogus"),
        ({"settings": []}, r"settings of the cache must be a table of settings, got \[\]"),
        ({"settings": {"m": "x"}}, "must have the settings of one"),
        ({"frame": -5}, "frame of the cache must be a whole number >= 0, got -5"),
        ({"frame": None}, "frame of the cache must be a whole number >= 0, got None"),
        ({"started": 3}, "started of the cache must be true or false, got 3"),
        ({"rays": 1.5}, "rays of the cache must be a whole number >= 0, got 1.5"),
        ({"thresholds": [1]}, "thresholds of the cache must be two finite numbers"),
        ({"thresholds": [0.1, float("nan")]}, "thresholds of the cache must be two finite numbers"),
    ],
)
def test_heads_that_were_made_by_hand_are_refused(saved: Any, change: Any, says: str) -> None:
    """Their digest fits, so what they say is checked."""
    _, path = saved
    with np.load(path) as file:
        arrays = {name: file[name] for name in file.files if name != "head"}
        head = json.loads(str(file["head"]))
    head.pop("digest")
    head |= change
    text = json.dumps(head | {"digest": cache_file.digest(head, arrays)})
    np.savez(path, head=np.array(text), **arrays)
    with pytest.raises(ValueError, match=rf"cache\.npz: .*{says}"):
        vc.VisibilityMapCache.load(path, clutter())


@pytest.mark.fuzz
def test_anything_else_is_refused(saved: Any, tmp_path: Path) -> None:
    _, path = saved
    good = path.read_bytes()
    other = io.BytesIO()
    np.savez(other, head=np.array('{"format": "something else"}'))
    empty = io.BytesIO()
    zipfile.ZipFile(empty, "w").close()
    array = io.BytesIO()
    np.save(array, np.zeros(3))
    for content in (
        b"",
        b"hello",
        good[: len(good) // 2],
        good[:-30],
        other.getvalue(),
        empty.getvalue(),
        array.getvalue(),
        b"PK\x03\x04" + bytes(100),
    ):
        path.write_bytes(content)
        with pytest.raises(ValueError, match=r"cache\.npz: must be a file of Visib"):
            vc.VisibilityMapCache.load(path, clutter())
    random = np.random.default_rng(0)
    for _ in range(60):
        damaged = bytearray(good)
        damaged[random.integers(len(good))] ^= 1 << int(random.integers(8))
        path.write_bytes(damaged)
        try:
            back = vc.VisibilityMapCache.load(path, clutter())
        except ValueError:
            continue
        assert len(back) > 10  # a bit of the archive's own book-keeping


def test_a_file_that_cannot_be_written_leaves_nothing(saved: Any, tmp_path: Path) -> None:
    cache, path = saved
    with pytest.raises(OSError, match="cannot write"):
        cache.save(tmp_path / "nowhere" / "cache.npz")
    with pytest.raises(OSError, match="No such file"):
        vc.VisibilityMapCache.load(tmp_path / "missing.npz", clutter())
    assert list(tmp_path.iterdir()) == [path]
