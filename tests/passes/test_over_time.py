"""vc.passes_over_time: errors and times of settings after each pass, against known pictures."""

import json
from dataclasses import replace

import numpy as np
import pytest

import viscache as vc
from viscache.frame.emitted_light import light_on_surfaces
from viscache.passes import over_time
from viscache.passes.over_time import gain

SIZE = (48, 32)
WHITTED = vc.Whitted(n_vpls=48)
CACHE = vc.Aqvc(c_e=40, exact_groups=())


def test_errors_are_those_of_the_mean_of_the_passes(room):
    other = vc.Progressive(room, WHITTED, visibility="exact", size=SIZE, first_pass=600).passes(3)
    ds = vc.passes_over_time(
        room, WHITTED, {"cache": {"visibility": CACHE, "use": "replace"}}, passes=2,
        reference=other, size=SIZE,
    )  # fmt: skip
    mine = vc.Progressive(room, WHITTED, visibility=CACHE, use="replace", size=SIZE)
    truth = np.asarray(light_on_surfaces(other), float)
    energy = []
    for n in (1, 2):
        frame = mine.passes(1)
        away = np.asarray(light_on_surfaces(frame), float) - truth
        row = ds.sel(setting="cache").isel({"pass": n - 1})
        assert float(row["nmse"]) == pytest.approx(np.mean(away**2) / truth.mean() ** 2, rel=1e-6)
        assert float(row["rel_l1_reflected"]) == pytest.approx(
            np.abs(away).sum() / truth.sum(), rel=1e-6
        )
        assert float(row["rays"]) == frame.counters["rays"]
        assert float(row["nmse_low"]) < float(row["nmse"]) < float(row["nmse_high"])
        energy.append(float(row["energy"]))
    assert np.mean(energy) == pytest.approx(away.sum() / truth.sum(), abs=1e-6)
    assert ds.attrs["reference_passes"] == 0 and json.loads(ds.attrs["size"]) == list(SIZE)


def test_squares_against_two_references_have_the_noise_of_neither():
    truth, offset = np.full((16, 16, 3), 2.0), np.zeros((16, 16, 3))
    offset[::2] = 0.5
    found = over_time._Truth([truth + offset, truth - offset]).errors(truth + 1.0)
    assert found["nmse"] == pytest.approx((1 - 0.25 / 2) / 4)
    assert found["rel_mse"] == pytest.approx((1 - 0.25 / 2) / (4 + (2 * over_time.DARK) ** 2))


def test_a_biased_setting_stalls_where_unbiased_ones_go_on(room):
    settings = {
        "exact": "exact",
        "biased": {"visibility": CACHE, "use": "replace"},
        "corrected": CACHE,
        "picks": {"visibility": "exact", "integrator": replace(WHITTED, pick=16)},
    }
    ds = vc.passes_over_time(room, WHITTED, settings, passes=12, size=SIZE)
    last = ds["nmse"].isel({"pass": -1})
    energy = ds["energy"].mean("pass")
    off = float(energy.sel(setting="biased") - energy.sel(setting="exact"))
    assert off > 0.03
    for name in ("corrected", "picks"):
        assert abs(float(energy.sel(setting=name) - energy.sel(setting="exact"))) < 0.3 * off
        assert float(last.sel(setting=name)) < float(last.sel(setting="biased"))
    assert float(last.sel(setting="exact")) < 0.5 * float(ds["nmse"].sel(setting="exact")[0])
    assert bool((ds["cpu_s"].diff("pass") > 0).all()) and bool((ds["wall_s"] > 0).all())
    words = json.loads(ds.attrs["settings"])
    assert words["biased"]["use"] == "replace" and "pick=16" in words["picks"]["integrator"]


def test_a_gain_is_error_times_time_over_that_of_another(room):
    ds = vc.passes_over_time(room, WHITTED, passes=2, reference=3, size=SIZE)
    assert list(ds["setting"].values) == ["exact", "biased", "corrected"]
    for at, error in ((1, "nmse"), (None, "rel_mse")):
        row = ds.isel({"pass": (at or 2) - 1})
        cost = row[error] * row["cpu_s"]
        wanted = float(cost.sel(setting="exact") / cost.sel(setting="biased"))
        assert gain(ds, "biased", error=error, at=at) == pytest.approx(wanted)
    assert gain(ds, "exact") == 1.0


def test_progress_counts_passes(room):
    seen = []
    given = {"passes": 2, "reference": 1, "size": SIZE}
    vc.passes_over_time(room, WHITTED, **given, progress=lambda *at: seen.append(at))
    assert seen == [(n, 8) for n in range(1, 9)]


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ({"settings": {}}, "settings must be a mapping of names"),
        ({"settings": {"a": {"use": "correct"}}}, r"settings\['a'\] must have a visibility"),
        ({"settings": {"a": {"visibility": "aqvc", "uses": 1}}}, r"must have keys of .*'uses'"),
        ({"settings": {"a": "aqvcc"}}, "aqvc"),
        ({"passes": 0}, "passes must be a whole number >= 1, got 0"),
        ({"reference": 1.5}, "reference must be a picture or a whole number of passes >= 1"),
        ({"reference": np.ones((4, 4, 3))}, r"reference must have shape \(32, 48, 3\)"),
        ({"reference": np.full((32, 48, 3), np.nan)}, "finite"),
        ({"reference": np.zeros((32, 48, 3))}, "must have light"),
    ],
)
def test_wrong_input_is_refused(room, arguments, says):
    with pytest.raises(ValueError, match=says):
        vc.passes_over_time(room, WHITTED, **({"size": SIZE, "passes": 1} | arguments))


def test_a_gain_of_what_is_not_there_is_refused(room):
    ds = vc.passes_over_time(room, WHITTED, passes=1, size=SIZE)
    for arguments, says in (
        ({"setting": "maps"}, "setting must be one of"),
        ({"setting": "biased", "error": "rel_l1_reflected"}, "error must be one of"),
        ({"setting": "biased", "at": 2}, "at must be a pass"),
    ):
        with pytest.raises(ValueError, match=says):
            gain(ds, **arguments)


def test_curves_have_a_point_per_pass_and_leave_out_what_is_below_the_noise(room):
    ds = vc.passes_over_time(room, WHITTED, passes=3, size=SIZE)
    ds["nmse"][1, 2] = -1e-6
    for x in ("cpu_s", "wall_s", "rays", "pass"):
        (axes,) = vc.plots.error_over_time(ds, x=x).axes
        lines = {line.get_label(): line for line in axes.get_lines()}
        assert list(lines) == ["exact", "biased", "corrected"]
        assert [len(line.get_xdata()) for line in lines.values()] == [3, 2, 3]
        assert axes.get_xscale() == axes.get_yscale() == "log"
    y = "rel_l1_reflected"
    (axes,) = vc.plots.error_over_time(ds, y=y).axes
    assert np.allclose(axes.get_lines()[2].get_ydata(), ds[y].sel(setting="corrected"))
    with pytest.raises(ValueError, match="x must be one of"):
        vc.plots.error_over_time(ds, x="seconds")
    with pytest.raises(ValueError, match="y must be one of"):
        vc.plots.error_over_time(ds, y="flip")


def test_a_page_has_the_curves_and_pictures_of_every_setting(room, tmp_path):
    ds = vc.passes_over_time(room, WHITTED, passes=3, size=SIZE)
    assert ds["picture"].shape == (3, SIZE[1], SIZE[0], 3)
    away = np.square(ds["picture"][0] - ds["reference"]).mean()
    assert float(away) < 0.2 * float(np.square(ds["reference"]).mean())
    page = vc.report.write_passes(ds, tmp_path / "passes.html").read_text("utf-8")
    assert "http://" not in page.replace("http://www.w3.org", "") and "https://" not in page
    for name in ("plot-cpu_s-nmse", "plot-pass-rel_mse"):
        svg = page.split(f'id="{name}"')[1].split("</svg>")[0]
        assert svg.count('class="point"') == int((ds[name.split("-")[2]] > 0).sum())
        assert svg.count('fill="none"') == 3
    data = json.loads(page.split('type="application/json">')[1].split("</script>")[0])
    assert [s["text"] for s in data["settings"]] == ["exact", "biased", "corrected"]
    assert all("difference" in s and "flip" in s for s in data["settings"])
    with pytest.raises(ValueError, match="ds must be a dataset of"):
        vc.report.write_passes(ds.drop_vars("picture"), tmp_path / "no.html")
    with pytest.raises(ValueError, match="width must be >= 1"):
        vc.report.write_passes(ds, tmp_path / "no.html", width=0)
