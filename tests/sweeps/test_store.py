"""The store: atomic, shared between processes, nothing lost and nothing repeated."""

import sqlite3
from contextlib import closing

import numpy as np
import pytest

from viscache.base.array_digests import content_key
from viscache.frame import Frame
from viscache.sweeps.store import Store, picture_name


def frame(value=1.0):
    return Frame(layers={"color": np.full((3, 4, 3), value)}, counters={"rays": 5})


KEY, OTHER = "a" * 64, "b" * 64


def test_the_key_is_of_the_content_not_of_the_order():
    assert content_key({"a": 1, "b": [2.5]}) == content_key({"b": [2.5], "a": 1})
    assert content_key({"a": 1}) != content_key({"a": 2})


def test_a_finished_frame_is_there_after_reopening(tmp_path):
    with Store(tmp_path) as store:
        assert store.get(KEY) is None
        store.put(KEY, {"seed": 3}, frame(2.0))
    with Store(tmp_path) as store:
        record = store.get(KEY)
        assert record is not None and record.spec == {"seed": 3} and record.counters == {"rays": 5}
        assert store.frame(KEY).sha256 == record.sha256 == frame(2.0).sha256


def test_a_frame_whose_picture_was_deleted_counts_as_missing(tmp_path):
    with Store(tmp_path) as store:
        store.put(KEY, {}, frame())
        (tmp_path / picture_name(KEY)).unlink()
        assert store.get(KEY) is None


def test_a_new_picture_forgets_comparisons_of_the_old_one(tmp_path):
    with Store(tmp_path) as store:
        store.put(KEY, {}, frame())
        store.put_comparison(KEY, OTHER, {"rmse": 1.0, "flip": None})
        assert store.compared(KEY, OTHER) == {"rmse": 1.0, "flip": None}
        store.put(KEY, {}, frame(3.0))
        assert store.compared(KEY, OTHER) == {}


def test_a_file_that_is_no_store_is_refused(tmp_path):
    (tmp_path / "sweep.sqlite").write_text("not a database, but long enough to be looked at" * 9)
    with pytest.raises(ValueError, match=r"sweep\.sqlite is not a sweep's store"):
        Store(tmp_path)
    assert Store.exists(tmp_path)


def test_the_store_uses_a_write_ahead_log(tmp_path):
    Store(tmp_path).close()
    with closing(sqlite3.connect(tmp_path / "sweep.sqlite")) as db, db:
        assert db.execute("PRAGMA journal_mode").fetchone() == ("wal",)
    db.close()
