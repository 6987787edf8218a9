"""Parts of the figure about tables kept over frames."""

import numpy as np
import pytest

from viscache.frame import Frame
from viscache_lab.figures import aqvc_temporal


def test_paths_move_the_camera_or_the_ball():
    camera, ball = (aqvc_temporal.views(path, True) for path in ("camera", "ball"))
    assert len(camera) == len(ball) == aqvc_temporal.QUICK_FRAMES
    assert len({scene.geometry_hash for scene, _ in camera}) == 1
    assert len({tuple(view.origin) for _, view in camera}) == len(camera)
    assert len({scene.geometry_hash for scene, _ in ball}) == len(ball)
    assert len({tuple(view.origin) for _, view in ball}) == 1
    assert ball[0][0].triangles > camera[0][0].triangles


def test_a_sequence_adds_up_its_frames():
    counters = [
        {"queries": 100, "rays": 50, "checked_kept": 0, "wrong_kept": 0},
        {"queries": 100, "rays": 10, "checked_kept": 40, "wrong_kept": 2},
    ]
    image = np.zeros((1, 1, 3), np.float32)
    frames = [Frame(layers={"color": image}, counters=c) for c in counters]
    made = aqvc_temporal.Sequence(frames)
    assert made.ray_reduction == pytest.approx(200 / 60)
    assert made.wrong("kept") == 2 / 40 and np.isnan(made.wrong("fresh"))


@pytest.mark.slow
def test_epochs_trace_like_dropped_tables_and_kept_ones_less():
    shots = aqvc_temporal.views("ball", True)[:3]
    rays = {
        way: aqvc_temporal.run(shots, way, "off", (48, 30)).total("rays")
        for way in aqvc_temporal.WAYS
    }
    assert rays["epochs"] == pytest.approx(rays["dropped"], rel=0.01)
    assert rays["kept"] < rays["repaired"] < rays["dropped"]
