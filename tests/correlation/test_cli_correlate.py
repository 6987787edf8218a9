"""`viscache correlate` and `scripts/correlation.py`."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from codebase.repository import ROOT
from viscache import cli
from viscache.correlation import load_dataset, measure

SCENE = "bumpy_spheres?triangles=3000"
SMALL = ["--points", "200", "--map-size", "16", "--d-bins", "8", "--theta-bins", "9"]


def test_the_file_holds_what_measure_returns(tmp_path, capsys):
    out = tmp_path / "a.nc"
    words = ["correlate", SCENE, "-o", str(out), *SMALL, "--seed", "3", "--d-max", "2.5", "--json"]
    more = ["--plot", str(tmp_path / "p"), "--format", "pdf"]
    assert cli.main([*words, *more, "--store", str(tmp_path / "s")]) == 0
    got = json.loads(capsys.readouterr().out)
    ds = load_dataset(out)
    expected = measure(
        SCENE, n_points=200, map_size=16, d_edges=8, theta_edges_deg=9, seed=3, d_max=2.5
    )
    assert np.array_equal(ds["mean"], expected["mean"], equal_nan=True)
    assert got["n_points"] == 200 and got["d_max"] == 2.5 and got["n_pairs"] == 19900
    assert got["box_d_max"] == ds.attrs["box_d_max"] and len(got["correlation_lengths"]) == 9
    assert len(got["predicted_variance_ratio"]) == ds.sizes["spacing"]
    assert all(Path(p).is_file() for p in got["plots"])
    assert [Path(p).name for p in got["plots"]] == ["table.pdf", "slices.pdf", "map.pdf"]
    assert cli.main([*words, "--format", "pdf"]) == 2  # without --plot
    assert list((tmp_path / "s").iterdir())


def test_the_text_names_the_box_and_the_correlation_lengths(tmp_path, capsys):
    words = ["correlate", SCENE, "-o", str(tmp_path / "a.nc"), *SMALL, "--pairs", "9000"]
    assert cli.main([*words, "--on", "camera", "--camera", "0"]) == 0
    text = capsys.readouterr().out
    assert "box_d_max" in text and "box_theta_max_deg" in text and "d at rho 0.9" in text


def test_local_visibility_and_processes_are_options(tmp_path, capsys):
    words = ["correlate", SCENE, *SMALL, "--t-max", "0.1", "--json", "-o"]
    assert cli.main([*words, str(tmp_path / "a.nc")]) == 0
    assert cli.main([*words, str(tmp_path / "b.nc"), "--workers", "2"]) == 0
    capsys.readouterr()
    a, b = (load_dataset(tmp_path / f"{name}.nc") for name in "ab")
    assert a.attrs["t_max"] == 0.1
    assert a["mean"].values.tobytes() == b["mean"].values.tobytes()


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["-o", "a.txt"], "output must be an .nc file"),
        (["-o", "none/a.nc"], "output must lie in a folder that can be written"),
        (["-o", "a.nc", "--points", "0"], "must be a whole number >= 1"),
        (["-o", "a.nc", "--pairs", "few"], "must be a whole number >= 1"),
        (["-o", "a.nc", "--camera", "7"], "camera must be in"),
        (["-o", "a.nc", "--camera", "front"], "camera must be one of"),
        (["-o", "a.nc", "--d-max", "-1"], "d_max must be finite and > 0"),
        (["-o", "a.nc", "--seed", "-1"], "seed must be in"),
        ([], "required: -o"),
    ],
)
def test_bad_usage_is_one_line_and_status_2(words, says, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert cli.main(["correlate", SCENE, "--points", "50", "--map-size", "8", *words]) == 2
    captured = capsys.readouterr()
    assert says in captured.err and len(captured.err.strip().splitlines()) == 1
    assert captured.out == "" and list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_the_script_measures_scenes_one_after_another(tmp_path):
    script = ROOT / "scripts/correlation.py"
    assert len(script.read_text().splitlines()) <= 30
    done = subprocess.run(
        [sys.executable, script, SCENE, "cube_on_plane", "-o", tmp_path, "--", *SMALL],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    made = {p.relative_to(tmp_path).as_posix() for p in tmp_path.glob("*/*")}
    names = ("statistics.nc", "table.png", "slices.png", "map.png")
    folders = ("bumpy-spheres-triangles-3000", "cube-on-plane")
    assert made == {f"{folder}/{name}" for folder in folders for name in names}
