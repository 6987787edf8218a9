"""Figures of the visibility cache: dots where records are, rows and samples."""

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import viscache as vc
from viscache import cli
from viscache_lab.experiment import Trial
from viscache_lab.experiment.drawing import project
from viscache_lab.figures.vismap_animation import Frame, _rows, crate_and_garage, swinging_camera
from viscache_lab.figures.vismap_equal_time import noisiest_windows, samples_in
from viscache_lab.figures.vismap_living_room import living_rooms, variance_rows
from viscache_lab.figures.vismap_table3 import Times


def test_points_are_drawn_where_the_camera_sees_them():
    camera = vc.look_at((1, 2, 3), (1, 2, -4), fov_deg=90)
    points = np.array([[1, 2, 0], [4, 2, 0], [1, 5, 0], [1, 2, 5]], float)
    pixels = project(camera, (200, 100), points)
    np.testing.assert_allclose(pixels[:3], [[100, 50], [150, 50], [100, 0]], atol=1e-5)
    assert np.isnan(pixels[3]).all(), "behind the camera"


def test_figure_5_needs_no_scene_and_holds_its_bands(tmp_path, capsys):
    assert cli.main(["reproduce", "vismap-fig5", "-o", str(tmp_path), "--json"]) == 0
    got = json.loads(capsys.readouterr().out)
    assert [row["holds"] for row in got["rows"]] == [True] * 4
    assert (tmp_path / "vismap-fig5.png").read_bytes()[:4] == b"\x89PNG"


def frames(ratios):
    one = Frame(records=9, inserted=2, wrong=1, unused=0, miss_share=0.01, ratio=0.0)
    return [replace(one, ratio=ratio) for ratio in ratios]


def test_an_animation_whose_variance_creeps_up_does_not_hold_its_band():
    steady = list(_rows(frames([0.3, 0.5] * 30)))
    assert steady[0].measured == pytest.approx(1) and steady[0].holds
    creeping = list(_rows(frames(list(np.linspace(0.3, 0.9, 60)))))
    assert creeping[0].holds is False
    assert steady[1].note == "120 inserted, 60 removed"


def test_the_crate_of_the_animation_moves_and_the_camera_swings():
    first, last = (crate_and_garage(t) for t in (0.0, 1.0))
    assert first.triangles == last.triangles and first.content_hash != last.content_hash
    assert swinging_camera(0.25).origin[2] - swinging_camera(0.75).origin[2] == pytest.approx(2.8)


def test_crops_are_where_the_noise_is_and_do_not_overlap():
    variance = np.full((20, 30), 0.01)
    variance[5:9, 10:14], variance[12:16, 20:24] = 3.0, 2.0
    assert noisiest_windows(variance, 4, 2) == [(5, 10), (12, 20)]
    assert variance[5, 10] == 3.0, "stays as it was"


def test_time_is_split_by_a_line_and_equal_time_is_where_it_meets():
    times = Times(samples=(10, 30, 100), product=(3.0, 5.0, 12.0), maps=(4.0, 6.0, 13.5))
    assert times.overhead == pytest.approx((1.0, 1.0, 1.5))
    assert times.split() == pytest.approx((2.0, 0.1))

    class Fake:
        def product(self, samples):
            return SimpleNamespace(timings={"cpu_s": 2.0 + 0.1 * samples})

    assert samples_in(Fake(), 6.0) == 40  # type: ignore[arg-type]


def test_the_living_room_is_taken_under_two_skies_or_named_as_absent(monkeypatch, tmp_path):
    monkeypatch.delenv("VISCACHE_SCENES", raising=False)
    trial = Trial()
    assert list(living_rooms(trial)) == []
    names = ["living-room, noon", "living-room, sunset"]
    assert [s["what"] for s in trial.skipped] == names
    assert "VISCACHE_SCENES" in trial.skipped[0]["reason"]
    # A room of our own in its place, under one sky
    (tmp_path / "living-room").mkdir()
    (tmp_path / "hdr").mkdir()
    room = (
        '<scene version="3.0.0"><sensor type="perspective"><float name="fov" value="60"/>'
        '<transform name="to_world"><lookat origin="0,1,4" target="0,0,0" up="0,1,0"/></transform>'
        '</sensor><shape type="cube"/></scene>'
    )
    (tmp_path / "living-room" / "scene.xml").write_text(room)
    head = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 16 +X 32\n"
    (tmp_path / "hdr" / "venice_sunset_1k.hdr").write_bytes(head + bytes([128] * 4) * 16 * 32)
    monkeypatch.setenv("VISCACHE_SCENES", str(tmp_path))
    trial = Trial()
    found = next(living_rooms(trial))
    assert found[0] == names[1]
    assert [s["what"] for s in trial.skipped] == names[:1]
    assert "hdr/kloppenheim_05_1k.hdr is absent" in trial.skipped[0]["reason"]
    rows = list(variance_rows(*found, quick=True))
    assert [row.what.split(", rendered")[0] for row in rows] == [names[1]] * 2
    assert all(row.measured is not None and 0 < row.measured < 2 for row in rows)
