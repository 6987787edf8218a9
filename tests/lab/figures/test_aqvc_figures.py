"""Parts of the quantized cache's figures."""

from collections import Counter

import numpy as np
import pytest

import viscache as vc
from viscache.frame import Frame
from viscache_lab.experiment import Trial
from viscache_lab.figures import (
    aqvc_claims,
    aqvc_clusters,
    aqvc_edges,
    aqvc_maps,
    aqvc_nee,
    aqvc_pictures,
    aqvc_sweeps,
)
from viscache_lab.figures import aqvc_printed as printed
from viscache_lab.figures.aqvc_runs import Shot, Trade, difference, group_rows, presets
from viscache_lab.figures.aqvc_setups import SETUPS


def disc(x, y):
    rows, columns = np.mgrid[0:90, 0:120]
    return 1.0 / (1 + np.exp(np.hypot(columns - 60 - x, rows - 45 - y) - 20))


@pytest.mark.parametrize("moved", [(0.0, 0.0), (0.4, -0.2), (-3.0, 2.0)])
def test_a_shift_is_found_to_the_right_and_down(moved):
    found = aqvc_edges.shift(disc(*moved), disc(0, 0))
    assert found == pytest.approx(moved, abs=0.02)


@pytest.fixture(scope="module")
def trade():
    shot = Shot(
        scene=vc.scenes.cornell_box(), size=(40, 40), integrator=vc.Whitted(n_vpls=16, n_area=4)
    )
    return Trade(frame=shot.frame(vc.Aqvc(c_e=16, exact_groups=())), exact=shot.frame())


def test_a_trade_names_the_error_of_every_light_group(trade):
    assert trade.groups == ["area", "vpl"]
    rows = list(group_rows("box", trade))
    assert [row.what for row in rows] == ["box: rel_l1 of area light", "box: rel_l1 of vpl light"]
    for group, row in zip(trade.groups, rows, strict=True):
        cached, exact = (f.layers[group].astype(float) for f in (trade.frame, trade.exact))
        assert row.measured == pytest.approx(np.abs(cached - exact).sum() / exact.sum())
        assert row.measured is not None and row.measured > 0
    total = vc.metrics.compare(trade.frame, trade.exact)
    assert trade.rel_l1 == pytest.approx(total.rel_l1) and trade.ssim == pytest.approx(total.ssim)
    counts = trade.frame.counters["groups"]["vpl"]
    assert trade.group_reduction("vpl") == counts["queries"] / counts["rays"]
    assert set(trade.record()) >= {"rel_l1_area", "rr_vpl", "speedup", "cpu_s"}


def test_settings_take_turns_and_keep_the_frame_of_the_median_time(monkeypatch):
    seconds = {"Exact": [9.0, 6.0, 7.0], "Aqvc": [3.0, 1.0, 2.0]}
    asked = []

    def made(*_, visibility, **__):
        name = type(visibility).__name__
        asked.append(name)
        cpu_s = seconds[name][asked.count(name) - 1]
        shade = len(asked) if changes and name == "Aqvc" else 1
        return Frame(
            layers={"color": np.full((2, 2, 3), shade, np.float32)}, timings={"cpu_s": cpu_s}
        )

    monkeypatch.setattr(vc, "render", made)
    shot = Shot(scene=vc.scenes.cornell_box(), size=(2, 2), integrator=vc.Direct())
    changes = False
    full = shot.trades({"a": vc.Aqvc()}, quick=False)["a"]
    assert asked == 3 * ["Exact", "Aqvc"]
    assert (full.exact.timings["cpu_s"], full.frame.timings["cpu_s"]) == (7.0, 2.0)
    assert full.speedup == 3.5
    asked.clear()
    assert shot.trades({"a": vc.Aqvc()}, quick=True)["a"].speedup == 3.0
    assert asked == ["Exact", "Aqvc"]
    asked.clear()
    changes = True
    with pytest.raises(AssertionError, match="the same pixels"):
        shot.trades({"a": vc.Aqvc()}, quick=False)


def test_differences_are_amplified():
    image = np.full((4, 5, 3), 1.0, np.float32)
    brighter = image.copy()
    brighter[1, 2] += 0.03125
    made = Trade(frame=Frame(layers={"color": brighter}), exact=Frame(layers={"color": image}))
    shown = difference(made)
    assert shown.shape == (4, 5, 1) and shown[1, 2, 0] == pytest.approx(0.5)
    assert (np.delete(shown.ravel(), 7) == 0).all()


def test_presets_stand_side_by_side_with_what_was_given():
    both = presets(9.0, refinement="off")
    assert {name: s.preset for name, s in both.items()} == {"default": "default", "paper": "paper"}
    assert all((s.c_e, s.refinement) == (9.0, "off") for s in both.values())


def test_false_colours_are_equal_where_keys_are():
    scene = vc.scenes.bumpy_spheres(triangles=2000, spheres=4)
    shot = Shot(scene=scene, size=(48, 40), integrator=vc.Direct())
    samples = aqvc_clusters.eye_samples(shot)
    keys = samples.keys(vc.Aqvc(c_e=8))
    image = aqvc_clusters.false_colors(samples, keys, (40, 48)).reshape(-1, 3)
    cells = aqvc_clusters.Cells(keys)
    assert cells.count.sum() == len(keys) and len(cells.count) > 20
    colors = image[samples.pixel]
    np.testing.assert_array_equal(colors, colors[cells.first][cells.number])
    assert len(np.unique(colors, axis=0)) == len(cells.count)
    unseen = np.setdiff1d(np.arange(48 * 40), samples.pixel)
    assert (image[unseen] == 0).all()


def test_bins_of_normals_are_as_wide_as_their_rule_says():
    rounded = aqvc_clusters.greatest_angle_deg(vc.Aqvc())
    floored = aqvc_clusters.greatest_angle_deg(vc.Aqvc(paper=vc.PaperForm(normal_mode="floor")))
    assert rounded == pytest.approx(11.3, abs=0.1) and floored == pytest.approx(25.2, abs=0.3)


def test_stand_ins_have_the_papers_lights_samples_and_triangles():
    kinds = Counter(light["kind"] for light in SETUPS["delta"].make(2000).lights)
    assert kinds == {"point": 24, "directional": 1}
    assert SETUPS["hairball"].make(100).triangles >= 100
    for setup in SETUPS.values():
        triangles = printed.SCENES[setup.printed].triangles
        assert setup.triangles[0] == triangles or setup.name == "courtyard"
        assert setup.pixels(False, (1280, 800)) == (1280, 800)
    apartment = SETUPS["apartment"]
    full, small = apartment.integrator(False), apartment.integrator(True)
    assert (full.n_vpls, full.n_environment + full.n_brdf) == (1024, 256)
    assert (small.n_vpls, small.n_environment + small.n_brdf) == (128, 32)
    assert SETUPS["conference"].integrator(False).n_area == 64
    paper = apartment.cache("paper", 24.0)
    assert (paper.preset, paper.c_e, dict(paper.c_e_groups)) == ("paper", 24.0, {"point": 4.0})
    assert apartment.cache("default", 24.0).preset == "default"


def test_reflected_light_leaves_out_what_shines_itself():
    shown = np.full((3, 4, 3), 1.0, np.float32)
    lit = Frame(layers={"color": shown * 5, "emitted": shown * 4})
    wrong = Frame(layers={"color": shown * 5.5, "emitted": shown * 4})
    made = Trade(frame=wrong, exact=lit)
    assert made.rel_l1 == pytest.approx(0.1) and made.reflected_rel_l1 == pytest.approx(0.5)


def test_maps_are_compared_at_equal_time_and_must_fit(monkeypatch):
    image = np.ones((2, 2, 3), np.float32)

    def taking(cpu_s):
        frame = Frame(layers={"color": image}, timings={"cpu_s": cpu_s})
        return Trade(frame=frame, exact=frame)

    sizes = (16, 32, 64)
    trades = {f"map {r}": taking(r / 16) for r in sizes} | {"default": taking(2.5)}
    assert aqvc_maps.equal_time(trades, sizes, "default") == 32
    assert aqvc_maps.equal_time(trades | {"default": taking(0.5)}, sizes, "default") == 16
    trial = Trial()
    memory = {"SC_PAGE_SIZE": 4096, "SC_PHYS_PAGES": 1 << 20}  # 4 GiB
    monkeypatch.setattr(aqvc_maps.os, "sysconf", memory.__getitem__)
    assert aqvc_maps.fitting((1024, 2048, 4096), trial) == [1024, 2048]
    assert trial.skipped == [{"what": "maps of 4096x4096", "reason": "they need 9.1 GiB of memory"}]


def test_sweeps_run_from_end_to_end_of_the_papers_ranges():
    for name, antialiased, (low, high) in (
        ("delta", True, printed.DELTA_AA),
        ("delta", False, printed.DELTA_PLAIN),
        ("courtyard", True, printed.SMOOTH_AA),
        ("courtyard", False, printed.SMOOTH_PLAIN),
    ):
        for quick in (False, True):
            values = aqvc_sweeps.c_e_values(SETUPS[name], antialiased, quick)
            for preset in ("default", "paper"):
                assert (min(values[preset]), max(values[preset])) == (low, high)
            assert set(values["paper"]) <= set(values["default"])
    delta = SETUPS["delta"]
    sweep, shot = aqvc_sweeps.make_sweep(delta, delta.make(2000), True, False, None)
    assert (sweep.label, shot.spp, shot.size) == ("delta, AA", 16, (640, 400))
    apartment = SETUPS["apartment"]
    _, shot = aqvc_sweeps.make_sweep(apartment, apartment.make(2000), True, False, (8, 8))
    assert isinstance(shot.integrator, vc.Whitted) and shot.size == (8, 8)
    assert (shot.integrator.n_vpls, shot.integrator.n_environment) == (256, 32)


def test_scenes_made_by_others_stand_in_their_own_light_or_under_a_sky(tmp_path, monkeypatch):
    monkeypatch.setenv("VISCACHE_SCENES", str(tmp_path))
    trial = Trial()
    assert aqvc_sweeps.load_file("room", trial) is None
    light = '<emitter type="point"><point name="position" x="0" y="3" z="0"/></emitter>'
    for name, inside in (("lit", light), ("dark", "")):
        (tmp_path / name).mkdir()
        text = f'<scene version="3.0.0"><shape type="cube"/>{inside}</scene>'
        (tmp_path / name / "scene.xml").write_text(text)
    lit = aqvc_sweeps.load_file("lit", trial)
    assert lit is not None and [light["kind"] for light in lit.lights] == ["point"]
    assert aqvc_sweeps.load_file("dark", trial) is None
    assert [left["what"] for left in trial.skipped] == ["room", "dark"]
    (tmp_path / "hdr").mkdir()
    head = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 16 +X 32\n"
    sky = tmp_path / "hdr" / "kloppenheim_05_1k.hdr"
    sky.write_bytes(head + bytes([128] * 4) * 16 * 32)
    dark = aqvc_sweeps.load_file("dark", trial)
    assert dark is not None and len(dark.lights) == 1


def test_flicker_is_the_variance_over_frames_of_what_a_screen_shows():
    planes = [np.array([[0.0, 1.0]]), np.array([[0.0, 3.0]]), np.array([[0.0, 5.0]])]
    assert aqvc_claims.mean_temporal_variance(planes) == pytest.approx(4.0 / 2)
    image = np.full((1, 2, 3), 0.25, np.float32)
    image[0, 1] = 4.0
    shown = aqvc_claims.seen(Frame(layers={"color": image}), 2.0)
    np.testing.assert_allclose(shown, [[0.5, 1.0]], rtol=1e-6)
    first, last = aqvc_claims.PATH
    path = [first, np.mean(aqvc_claims.PATH, axis=0), last]
    origins = [view.origin for view in aqvc_claims.cameras(3)]
    np.testing.assert_allclose(origins, path, rtol=1e-6)


def test_a_picture_is_exact_above_the_diagonal_and_cached_below():
    above, below = np.full((40, 60, 3), 1.0), np.full((40, 60, 3), 2.0)
    picture = aqvc_pictures.diagonal(above, below)
    assert picture[0, 0, 0] == picture[5, 30, 1] == 1.0
    assert picture[39, 59, 0] == picture[35, 30, 2] == 2.0
    line = (picture == 0).all(axis=2)
    assert line[39, 0] and line[0, 59] and line[20, 29] and 30 < line.sum() < 120


def test_bidirectional_paths_go_through_both_presets_without_refinement():
    trades = aqvc_pictures.bidirectional(True, (12, 10))
    assert list(trades) == ["default", "paper"]
    for preset, trade in trades.items():
        settings = trade.frame.parameters["visibility"]
        assert (settings["preset"], settings["c_e"]) == (preset, 12.0)
        assert settings["refinement"] == "off"
        assert trade.exact.counters["rays"] == trade.exact.counters["queries"]
        assert trade.ray_reduction > 1 and trade.rel_l1 > 0


def test_equal_time_weighs_squared_errors_by_seconds():
    exact, fewer_rays = aqvc_nee.Noise(0.5, 4.0), aqvc_nee.Noise(0.75, 2.0)
    assert fewer_rays.at_equal_time(exact) == 0.75 and exact.at_equal_time(exact) == 1
