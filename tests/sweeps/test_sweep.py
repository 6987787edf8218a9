"""Sweeps over the stand-in renderer, whose error and cost are known exactly."""

import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
import xarray

from sweeps.fake_renderer import FakeScene
from sweeps.stand_in import rows_of
from viscache import metrics
from viscache.frame import Frame
from viscache.settings import by_name
from viscache.shot.shot import BareShot
from viscache.sweeps import work
from viscache.sweeps.store import Store
from viscache.sweeps.sweep import SweepFile, sweep
from viscache.sweeps.table import open_dataset

SMALL = {"size": (32, 24), "metrics": ("rel_l1", "rmse")}


def test_the_grid_comes_back_with_dims_named_by_the_last_part(fake_vc):
    over = {"c_e": [4, 8, 16], "visibility.c_n": [4, 8], "integrator.n_vpls": [1, 2]}
    ds = sweep("room", "whitted", over=over, repeats=2, seed=5, **SMALL)
    assert dict(ds.sizes) == {"c_e": 3, "c_n": 2, "n_vpls": 2, "repeat": 2, "group": 1}
    assert ds.c_e.values.tolist() == [4, 8, 16] and ds.seed.values.tolist() == [5, 6]
    expected = (ds.c_e / 100).broadcast_like(ds.rel_l1)
    np.testing.assert_allclose(ds.rel_l1.transpose(*expected.dims), expected, rtol=1e-5)
    np.testing.assert_allclose(ds.ray_reduction.sel(c_e=4), 16, rtol=0.01)
    np.testing.assert_allclose(ds.speedup.sel(c_e=8), 1 / (0.2 + 0.5 / 8))
    np.testing.assert_allclose(ds.rel_l1_by_group.sel(group="vpl", c_e=16), 0.16, rtol=1e-5)
    assert (ds.rays_by_group.sel(group="vpl") == ds.rays).all()
    assert ds.total_s.attrs["units"] == "s" and (ds.cpu_s >= 0).all()


def test_the_paired_reference_is_rendered_once_per_integrator_and_repeat(fake_vc):
    over = {"c_e": [4, 8, 16], "integrator.n_vpls": [1, 2]}
    sweep("room", "whitted", over=over, repeats=3, **SMALL)
    exact = [c for c in fake_vc.CALLS if type(c["visibility"]).__name__ == "Exact"]
    assert len(exact) == 2 * 3 and len(fake_vc.CALLS) == 2 * 3 + 3 * 2 * 3
    assert {(c["integrator"].n_vpls, c["seed"]) for c in exact} == {
        (n, s) for n in (1, 2) for s in (0, 1, 2)
    }
    assert {c["spp"] for c in fake_vc.CALLS} == {1}


def test_the_converged_reference_gives_the_total_error_beside_the_caches_own(fake_vc):
    ds = sweep("room", "whitted", over={"c_e": [2, 20]}, converged={"spp": 64, "seed": 9}, **SMALL)
    converged = [c for c in fake_vc.CALLS if c["spp"] == 64]
    assert len(converged) == 1 and converged[0]["seed"] == 9
    assert ds.rel_l1.sel(c_e=2).item() == pytest.approx(0.02, rel=1e-5)
    assert ds.exact_converged_rel_l1.max().item() > 0.003  # the noise of one sample
    assert (ds.converged_rmse.sel(c_e=20) > ds.converged_rmse.sel(c_e=2)).all()


def test_an_interrupted_sweep_resumes_and_repeats_nothing(fake_vc, tmp_path):
    over = {"c_e": [4, 8, 16, 32]}
    fake_vc.STOP[:] = [4]
    with pytest.raises(KeyboardInterrupt):
        sweep("room", "whitted", over=over, repeats=2, directory=tmp_path, **SMALL)
    assert len(fake_vc.CALLS) == 4
    before = rows_of(tmp_path)
    assert 0 < len(before) < 8
    partial = open_dataset(tmp_path)
    assert int(partial.rel_l1.notnull().sum()) == len(before)
    fake_vc.STOP.clear()
    ds = sweep("room", "whitted", over=over, repeats=2, directory=tmp_path, **SMALL)
    assert len(fake_vc.CALLS) == 2 + 8 and len(rows_of(tmp_path)) == 8
    seen = [(str(c["visibility"]), c["seed"]) for c in fake_vc.CALLS]
    assert len(seen) == len(set(seen))
    assert ds.rel_l1.notnull().all()
    sweep("room", "whitted", over=over, repeats=2, directory=tmp_path, **SMALL)
    assert len(fake_vc.CALLS) == 10


def test_a_larger_grid_and_a_new_metric_use_what_is_there(fake_vc, tmp_path):
    sweep("room", "whitted", over={"c_e": [4, 8]}, directory=tmp_path, **SMALL)
    assert len(fake_vc.CALLS) == 3
    ds = sweep(
        "room",
        "whitted",
        over={"c_e": [4, 8, 16]},
        directory=tmp_path,
        size=(32, 24),
        metrics=["rel_l1", "ssim"],
    )
    assert len(fake_vc.CALLS) == 4
    assert ds.ssim.notnull().all() and "rmse" not in ds


def test_a_frame_is_measured_while_its_picture_is_written(fake_vc, tmp_path, monkeypatch):
    measured = threading.Event()
    compare, put = metrics.compare, Store.put
    order = []

    def compares(*images, **options):
        order.append("compare")
        measured.set()
        return compare(*images, **options)

    def puts(store, key, spec, frame):
        cached = frame.counters["rays"] < frame.counters["queries"]
        assert not cached or measured.wait(60)
        put(store, key, spec, frame)
        order.append("put")

    monkeypatch.setattr(metrics, "compare", compares)
    monkeypatch.setattr(Store, "put", puts)
    sweep("room", "whitted", over={"c_e": [4]}, directory=tmp_path, size=(32, 24))
    # The exact frame's picture; then the layer vpl and the whole are measured, and somewhere beside
    # them the cached frame's picture is written: never before the first
    assert order[:2] == ["put", "compare"] and sorted(order[2:]) == ["compare", "put"]
    assert len(rows_of(tmp_path)) == 1


def test_a_frame_that_cannot_be_measured_is_kept(fake_vc, tmp_path, monkeypatch):
    def fails(*_, **__):
        raise ValueError("a must be finite")

    monkeypatch.setattr(metrics, "compare", fails)
    with pytest.raises(ValueError, match="a must be finite"):
        sweep("room", "whitted", over={"c_e": [4]}, directory=tmp_path, **SMALL)
    monkeypatch.undo()
    with Store(tmp_path) as store:
        assert len(store.finished()) == 2 and rows_of(tmp_path) == []


def test_the_csv_has_a_row_per_point_and_repeat_and_is_there_after_each_point(fake_vc, tmp_path):
    lengths = []

    def progress(done, total):
        assert done <= total == 6
        lengths.append(len(rows_of(tmp_path)) if (tmp_path / "table.csv").exists() else 0)

    sweep(
        "room",
        "whitted",
        over={"c_e": [4, 8]},
        repeats=2,
        directory=tmp_path,
        progress=progress,
        **SMALL,
    )
    assert lengths == sorted(lengths) and lengths[0] == 0 and max(lengths) >= 3
    rows = rows_of(tmp_path)
    names = ["c_e", "repeat", "seed", "rel_l1", "rmse", "rays", "queries"]
    assert list(rows[0])[:7] == names and "total_s" in rows[0]
    assert [(r["c_e"], r["seed"]) for r in rows] == [("4", "0"), ("4", "1"), ("8", "0"), ("8", "1")]
    assert float(rows[3]["rel_l1"]) == pytest.approx(0.08, rel=1e-5)


def test_the_netcdf_table_opens_elsewhere_and_the_pictures_are_there(fake_vc, tmp_path):
    over = {"processing": ["waves", "rows"], "c_e": [4]}
    ds = sweep("room", "whitted", over=over, directory=tmp_path, **SMALL)
    with xarray.open_dataset(tmp_path / "table.nc", engine="h5netcdf") as back:
        assert back.processing.values.tolist() == ["waves", "rows"]
        xarray.testing.assert_equal(back.rel_l1.load(), ds.rel_l1)
        assert "directory" not in back.attrs and back.attrs["spp"] == 1
    for row in rows_of(tmp_path):
        assert Frame.load(tmp_path / row["frame"]).size == (32, 24)


def test_an_executor_gives_the_same_table_as_none(fake_vc, tmp_path):
    arguments = {"over": {"c_e": [4, 8, 16]}, "repeats": 2, **SMALL}
    plain = sweep("room", "whitted", **arguments)
    with ThreadPoolExecutor(3) as pool:
        shared = sweep("room", "whitted", executor=pool, directory=tmp_path, **arguments)
    xarray.testing.assert_equal(plain.rel_l1, shared.rel_l1)
    xarray.testing.assert_equal(plain.rays, shared.rays)
    assert len(rows_of(tmp_path)) == 6


def test_an_error_in_a_worker_is_raised_and_keeps_what_was_finished(fake_vc, tmp_path, monkeypatch):

    def breaks(scene, integrator, **options):
        if getattr(options["visibility"], "c_e", 0) == 16:
            raise RuntimeError("a bad ray")
        return fake_vc.fake_render(scene, integrator, **options)

    monkeypatch.setattr(work, "render_function", breaks)
    with ThreadPoolExecutor(1) as pool, pytest.raises(RuntimeError, match="a bad ray"):
        sweep("room", "whitted", over={"c_e": [4, 16]}, directory=tmp_path, executor=pool, **SMALL)
    assert [r["c_e"] for r in rows_of(tmp_path)] == ["4"]


def test_a_list_of_points_has_one_dim_and_its_coordinates(fake_vc):
    points = [{"c_e": 4, "c_n": 8}, {"c_e": 16, "c_n": 4}, {"c_e": 5, "c_n": 5}]
    ds = sweep("room", "whitted", over=points, **SMALL)
    assert dict(ds.sizes) == {"point": 3, "repeat": 1, "group": 1}
    np.testing.assert_allclose(ds.rel_l1[:, 0], ds.c_e / 100, rtol=1e-5)
    assert ds.c_n.dims == ("point",)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"over": {"c_ee": [1]}}, "unknown parameter 'c_ee'.*did you mean 'c_e'"),
        ({"over": {"integrator.n_vpl": [1]}}, "no parameter 'n_vpl'; did you mean 'n_vpls'"),
        ({"over": {"light.x": [1]}}, "must start with one of integrator, rays, visibility"),
        ({"over": {"c_e": []}}, "at least one value"),
        ({"over": {"c_e": [4, 4]}}, "none twice"),
        ({"over": {"c_e": 4}}, "must be a list of values"),
        ({"over": {}}, "at least one parameter"),
        ({"over": {"c_e": [4, -1]}}, "c_e must be > 0, got -1"),
        ({"over": [{"c_e": 4}, {"c_n": 4}]}, r"all have the names \['c_e'\]"),
        ({"integrator": "whited"}, "unknown integrator 'whited'; did you mean 'whitted'"),
        ({"metrics": ["rel_l2"]}, "unknown metric 'rel_l2'"),
        ({"repeats": 0}, "repeats must be an integer >= 1, got 0"),
        ({"size": (0, 4)}, "size must be"),
        ({"seed": {}}, "seed must be in"),
        ({"converged": {"ssp": 4}}, "did you mean 'spp'"),
    ],
)
def test_bad_sweeps_are_refused_before_the_first_frame(fake_vc, change, says):
    arguments = {"integrator": "whitted", "over": {"c_e": [4]}, **SMALL, **change}
    with pytest.raises(ValueError, match=says):
        sweep("room", arguments.pop("integrator"), **arguments)
    assert not fake_vc.CALLS


FILE = """
scene = "room?triangles=2000"
integrator = {name = "whitted", n_vpls = 3}
visibility = "aqvc"
preset = "paper"
size = [32, 24]
repeats = 2
converged = {spp = 4, seed = 1000}
metrics = ["rel_l1"]
[over]
c_e = [4, 8]
"""


def test_a_file_runs_as_written(fake_vc, tmp_path):
    path = tmp_path / "a.toml"
    path.write_text(FILE + "integrator.n_vpls = [1, 3]\n")
    ds = SweepFile.load(path).run(tmp_path / "out")
    assert dict(ds.sizes) == {"c_e": 2, "n_vpls": 2, "repeat": 2, "group": 1}
    cached = [c["visibility"] for c in fake_vc.CALLS if hasattr(c["visibility"], "preset")]
    assert {v.preset for v in cached} == {"paper"}
    assert ds.attrs["scene"] == "room?triangles=2000"


def test_a_files_scene_is_relative_to_the_file(tmp_path):
    (tmp_path / "a.toml").write_text('scene = "meshes/x.obj"\n[over]\nc_e = [1]\n')
    from viscache.scenes import sources

    loaded = SweepFile.load(tmp_path / "a.toml")
    assert sources.absolute(loaded.scene, loaded.folder) == str(tmp_path / "meshes/x.obj")
    assert sources.absolute("room?lights=2", tmp_path) == "room?lights=2"


def test_a_files_points_are_a_list_of_tables(fake_vc, tmp_path):
    text = FILE.split("[over]")[0] + "points = [{c_e = 4, c_n = 2}, {c_e = 8, c_n = 1}]\n"
    (tmp_path / "a.toml").write_text(text)
    ds = SweepFile.load(tmp_path / "a.toml").run(None)
    assert ds.sizes["point"] == 2 and ds.c_n.values.tolist() == [2, 1]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("sceen = 'a'\n[over]\nc_e = [1]", "unknown key 'sceen'; did you mean 'scene'"),
        ("[over]\nc_e = [1]", "must name a scene"),
        ("scene = 'room'", r"either \[over\] or points"),
        ("scene = 'room'\nspp = 'many'\n[over]\nc_e = [1]", "spp must be an integer, got 'many'"),
        ("scene = room", r"a\.toml"),
    ],
)
def test_bad_files_are_refused_with_file_and_reason(tmp_path, text, says):
    (tmp_path / "a.toml").write_text(text)
    with pytest.raises(ValueError, match=says) as caught:
        SweepFile.load(tmp_path / "a.toml")
    assert "a.toml" in str(caught.value)


READY = sorted((Path(__file__).parents[2] / "scripts" / "sweeps").glob("*.toml"))


@pytest.mark.parametrize("path", READY, ids=lambda p: p.stem)
def test_the_ready_sweeps_name_parameters_that_exist(path):
    from viscache.sweeps.plan import make_plan

    loaded = SweepFile.load(path)
    roles = {r: getattr(loaded, r) for r in by_name.ROLES}
    shot = BareShot(FakeScene(), **roles, size=(640, 400), spp=loaded.spp)
    asked = {name: getattr(loaded, name) for name in ("over", "repeats", "converged")}
    plan = make_plan(shot, loaded.scene, metrics=list(loaded.metrics), **asked)
    assert len(plan.points) >= 9


def test_a_real_sweep_trades_rays_for_error_and_the_exact_limit_has_none(tmp_path):
    import viscache as vc
    from viscache_lab.commands.self_test import small_scene

    ds = sweep(
        small_scene(),
        vc.Direct(),
        visibility=vc.Aqvc(exact_groups=()),
        over={"c_e": [0.01, 4, 16]},
        size=(64, 48),
        metrics=["rel_l1"],
        repeats=2,
        directory=tmp_path,
    )
    errors, rays = ds.rel_l1.mean("repeat").values, ds.rays.mean("repeat").values
    assert errors[0] == 0.0 and 0 < errors[1] < errors[2] < 0.2
    assert rays[0] > rays[1] > rays[2] > 0
    assert (ds.queries == ds.queries[0]).all()
    assert (ds.total_s > 0).all() and (ds.speedup > 0).all()
