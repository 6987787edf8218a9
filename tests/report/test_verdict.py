"""The verdict of a sweep: what an error costs beside exact visibility, and when it does not pay."""

import pytest
import xarray

from reference import report_pictures as pictures
from viscache import metrics, report
from viscache.report.costs import knee
from viscache.sweeps.sweep import sweep

pytestmark = pytest.mark.usefixtures("fake_vc")


def dataset(errors, seconds, exact=8.8, metric="rel_l1", **more):
    """A sweep over C_E = 2, 4, 8 …; one row per setting, one column per repeat."""
    dims = ("c_e", "repeat")
    rows = {metric: errors, "total_s": seconds, **more}
    rows["exact_total_s"] = [[exact] * len(row) for row in seconds]
    rows["speedup"] = [[exact / s for s in row] for row in seconds]
    coords = {"c_e": [2 << i for i in range(len(errors))], "repeat": list(range(len(errors[0])))}
    return xarray.Dataset(
        {n: (dims, v) for n, v in rows.items()}, coords, {"metrics": f'["{metric}"]'}
    )


def said(*given, target=None, **more):
    return str(report.verdict(dataset(*given, **more), target=target))


ERRORS = [[0.004], [0.009], [0.016], [0.06]]


def test_each_error_names_its_cheapest_setting_time_and_factor():
    told = said(ERRORS, [[4.0], [2.1], [1.7], [1.5]])
    assert told == (
        "1 % error costs 2.1 s instead of 8.8 s (4.2×), at C_E = 4."
        " 2 % error costs 1.7 s (5.2×), at C_E = 8; 10 % error costs 1.5 s (5.9×), at C_E = 16."
    )


def test_a_setting_that_is_dearer_and_worse_is_no_offer():
    told = said(ERRORS, [[2.0], [2.1], [1.7], [1.9]])
    assert told.startswith("0.5 % error costs 2 s instead of 8.8 s (4.4×), at C_E = 2.")
    assert "C_E = 4" not in told and "C_E = 16" not in told


def test_where_exact_visibility_is_faster_the_verdict_says_so():
    told = said(ERRORS, [[9.9], [9.5], [9.1], [4.4]])
    assert told.startswith(
        "1 % error: exact visibility is faster, 8.8 s against 9.5 s, at C_E = 4."
    )
    assert "10 % error costs 4.4 s (2×), at C_E = 16" in told


def test_an_error_that_no_setting_has_is_told_with_the_smallest_there_is():
    told = said([[0.03], [0.04]], [[3.0], [2.0]])
    assert told.startswith("No setting has 1 % error: the smallest is 3 %, at C_E = 2. 5 % error")


def test_a_target_comes_first():
    told = said(ERRORS, [[4.0], [2.1], [1.7], [1.5]], target=0.017)
    assert told.startswith("1.7 % error costs 1.7 s instead of 8.8 s (5.2×), at C_E = 8.")
    with pytest.raises(ValueError, match="target must be > 0, got 0"):
        said(ERRORS, [[4.0], [2.1], [1.7], [1.5]], target=0)


def test_repeats_give_intervals_and_a_gain_within_the_noise_is_no_gain():
    sure = said([[0.009, 0.0092, 0.0088]], [[2.0, 2.1, 2.2]])
    assert sure == "1 % error costs 2.1 ± 0.2 s instead of 8.8 s (4.2 ± 0.5×), at C_E = 2."
    unsure = said([[0.009, 0.0092, 0.0088]], [[6.0, 8.0, 11.0]])
    assert "no surely measured gain" in unsure


def test_other_metrics_are_told_in_their_own_unit():
    assert said([[0.03]], [[2.0]], metric="rmse").startswith("No setting has RMSE 0.01: the")
    assert "RMSE 0.05 costs 2 s instead" in said([[0.03]], [[2.0]], metric="rmse")
    assert report.verdict(dataset([[0.9]], [[2.0]], metric="ssim")) is None


def test_times_that_other_load_disturbed_are_told_beside_cpu_time():
    told = said([[0.009]], [[2.0]], cpu_speedup=[[3.0]])
    assert told.endswith("Other load disturbed these times: by CPU time it is 3×.")
    assert "disturbed" not in said([[0.009]], [[2.0]], cpu_speedup=[[4.2]])
    assert "rough" in said([[0.009]], [[2.0]], alone=[[0.0]])


def test_the_knee_is_where_the_front_bends_most():
    assert knee([(1, 1), (2, 0.1), (10, 0.05), (100, 0.04)]) == 1
    assert knee([(5, 5), (1, 1)]) == 1  # of two, the one of least error
    assert knee([(100, 0.04), (1, 1), (2, 0.1), (3, 3), (10, 0.05)]) == 2


def test_the_page_begins_with_the_verdict_and_opens_on_the_target(tmp_path):
    over = {"c_e": [1, 2, 4, 8]}
    ds = sweep("room", "whitted", over=over, size=(48, 32), metrics=["rel_l1"], directory=tmp_path)
    text = report.write(ds, target=0.02, flip_maps=0).read_text("utf-8")
    body = text.split("<main>")[1]
    assert body.index('class="verdict"') < body.index("<svg") < body.index('class="facts"')
    assert '<p class="first">2 % error costs' in body
    assert '<button class="choose" data-id="s1"><i>C</i><sub>E</sub> = 2</button>' in body
    assert pictures.model(text)["opens"] == "s1"


def test_flip_maps_that_the_sweep_measured_are_not_measured_again(tmp_path, monkeypatch):
    over, size = {"c_e": [4, 8]}, (48, 32)
    wanted = {"repeats": 2, "metrics": ["rel_l1", "flip"], "directory": tmp_path}
    sweep("room", "whitted", over=over, size=size, **wanted)
    assert len(list((tmp_path / "flip").iterdir())) == 2  # of the first repeat only
    monkeypatch.setattr(metrics, "flip_map", lambda *_: pytest.fail("was measured again"))
    data = pictures.model(report.write(tmp_path).read_text("utf-8"))
    assert all("flip" in s for s in data["settings"])
