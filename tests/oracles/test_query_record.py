"""Queries of a frame as a file that xarray and pandas read."""

import numpy as np
import pytest
import xarray

import viscache as vc
from reference.built import built


def connections_of(size):
    return vc.connections(built("room?triangles=3000"), vc.Whitted(n_vpls=20), size=size)


@pytest.fixture(scope="module")
def conn():
    return connections_of((64, 56))


def test_the_file_holds_every_query_once(conn, tmp_path):
    path = tmp_path / "queries.nc"
    count = vc.record_queries(conn, vc.Aqvc(c_e=8), path)
    answers = conn.answers(vc.Aqvc(c_e=8))
    exact = conn.answers(vc.Exact())
    assert count == sum(answers[g].counters["queries"] for g in conn.groups)  # type: ignore[union-attr]
    with xarray.open_dataset(path, engine="h5netcdf") as file:
        queries = file.load()
    frame = queries.drop_vars(["x", "y"]).to_dataframe()
    assert len(frame) == count
    assert not frame.duplicated(["eye", "far", "group"]).any()
    places = np.asarray(conn.eyes.positions)[queries["eye"].values]
    np.testing.assert_array_equal(queries["x"].values, places)
    for number, group in ((0, "point"), (4, "vpl")):
        of = frame[frame["group"] == number]
        for column, found in (("v", exact), ("answer", answers)):
            seen = found[group].visible  # type: ignore[union-attr]
            np.testing.assert_array_equal(of[column], seen[of["eye"], of["far"]])
    # What shares a cluster shares the answer
    assert (frame.groupby("cluster")["answer"].nunique() == 1).all()
    assert frame["level"].max() >= 1
    assert 0 < (frame["v"] != frame["answer"]).mean() < 0.2


@pytest.mark.slow
def test_a_memory_bound_changes_nothing_but_numbers_of_clusters(tmp_path):
    conn = connections_of((160, 140))
    whole, parts = tmp_path / "whole.nc", tmp_path / "parts.nc"
    # The largest tile has up to 16384 eye points; this is room for few of its lights at a time
    bound = 96 * 4 * max(len(t["positions"]) for t in conn.eyes._tiles or ())
    count = vc.record_queries(conn, vc.Aqvc(c_e=8), whole)
    assert vc.record_queries(conn, vc.Aqvc(c_e=8), parts, max_bytes=bound) == count
    with (
        xarray.open_dataset(whole, engine="h5netcdf") as a,
        xarray.open_dataset(parts, engine="h5netcdf") as b,
    ):
        names = ["group", "eye", "far", "v", "answer", "level"]
        first, second = (f[names].to_dataframe().sort_values(names[:3]).to_numpy() for f in (a, b))
        np.testing.assert_array_equal(first, second)
        assert len(np.unique(a["cluster"])) == len(np.unique(b["cluster"]))


def test_what_cannot_be_written_leaves_no_file(conn, tmp_path):
    path = tmp_path / "queries.nc"
    for visibility, bound, match in (
        (vc.ShadowMap(resolution=32), 1 << 30, "cannot tell"),
        (vc.Aqvc(), 1 << 16, "max_bytes must be >="),
        (vc.Aqvc(), 5, "65536"),
    ):
        with pytest.raises(ValueError, match=match):
            vc.record_queries(conn, visibility, path, max_bytes=bound)
        assert list(tmp_path.iterdir()) == []
