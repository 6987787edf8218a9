"""The figure of the trade over time: its rows, its t values and its verdict."""

import numpy as np
import pytest
import xarray

from viscache_lab.figures import trade
from viscache_lab.figures.bands import trade as trade_bands


def passes(nmse, seconds, energy):
    """A dataset of passes with known ends."""
    names = list(nmse)
    n = len(energy)
    data = {
        "nmse": [[nmse[k]] * n for k in names],
        "rel_mse": [[nmse[k]] * n for k in names],
        "cpu_s": [[seconds[k]] * n for k in names],
        "energy": [energy if k == "corrected" else [0.0] * n for k in names],
    }
    return xarray.Dataset(
        {k: (("setting", "pass"), v) for k, v in data.items()},
        coords={"setting": names, "pass": np.arange(1, n + 1)},
    )


WAYS = ("exact", "packets", "biased", "corrected", "16 picks")


def test_every_band_of_a_gain_is_that_of_a_case():
    assert set(trade.ROOMS) < set(trade_bands.GAIN) == set(trade_bands.RELATIVE_GAIN)
    assert set(trade_bands.GAIN) <= {case.name for case in trade.CASES}
    assert len(trade.CASES) == 8


def test_rows_hold_the_gains_against_the_bands():
    nmse = dict.fromkeys(WAYS, 0.01) | {"biased": 0.03}
    seconds = dict.fromkeys(WAYS, 1.0) | {"packets": 8.0, "exact": 4.0, "16 picks": 1.2}
    ds = passes(nmse, seconds, [0.01, -0.01, 0.02, 0.0])
    rows = {row.what: row for row in trade._rows("room", ds, quick=False)}
    assert rows["room, corrected over packets: gain, nMSE"].measured == pytest.approx(8)
    assert rows["room, corrected over packets: gain, nMSE"].holds is True
    assert rows["room, corrected over exact: gain, nMSE"].measured == pytest.approx(4)
    assert rows["room, corrected over 16 picks: gain, nMSE"].holds is False
    assert rows["room: nMSE of biased over that of corrected passes"].measured == pytest.approx(3)
    for name, stalls in (("room", [trade_bands.STALLS]), ("conference", [])):
        quick = [row.band for row in trade._rows(name, ds, quick=True) if row.band]
        assert quick == [*stalls, trade_bands.UNBIASED, trade_bands.UNBIASED]


def test_a_lost_energy_fails_the_t_value():
    even = dict.fromkeys(WAYS, 1.0)
    fair = passes(even, even, [0.01, -0.01, 0.012, -0.008])
    lost = passes(even, even, [0.101, 0.1, 0.102, 0.099])
    assert abs(trade.energy_t(fair, "corrected")) in trade_bands.UNBIASED
    assert abs(trade.energy_t(lost, "corrected")) not in trade_bands.UNBIASED
    values = np.array([0.01, -0.01, 0.012, -0.008])
    assert trade.energy_t(fair, "corrected") == pytest.approx(
        values.mean() / (values.std(ddof=1) / 2)
    )


def test_the_verdict_names_the_best_unbiased_way_of_each_scene():
    even = dict.fromkeys(WAYS, 1.0)
    found = {
        "a": passes(even | {"corrected": 0.5}, even, [0.0, 0.1]),
        "b": passes(even | {"16 picks": 0.5, "biased": 0.1}, even, [0.0, 0.1]),
    }
    row = trade._verdict(found)
    assert row.measured == 1 and "scenes of 2" in row.what
    assert "exact: none; corrected: a; 16 picks: b" in row.note
