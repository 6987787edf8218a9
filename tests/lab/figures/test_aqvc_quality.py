"""Quality choices of the quantized cache: measures with known values, and small parts."""

import numpy as np
import pytest

import viscache as vc
from viscache.frame import Frame
from viscache_lab.figures import aqvc_quality
from viscache_lab.figures.aqvc_runs import Shot


def frame_of(*values):
    image = np.repeat(np.array([values], np.float32)[..., None], 3, axis=2)
    return Frame(layers={"color": image, "emitted": np.zeros_like(image)})


def test_the_interval_of_a_mean_holds_it_95_times_in_100():
    rng = np.random.default_rng(2)
    held = 0
    for _ in range(400):
        found = aqvc_quality.mean_interval((1.5 + rng.normal(size=6)).tolist())
        held += abs(found.mean - 1.5) < found.half
    assert 0.92 < held / 400 < 0.98
    assert str(aqvc_quality.Interval(0.0125, 0.001)) == "+1.250 ± 0.100 %"


def test_bias_is_the_energys_and_stray_light_that_of_black_pixels():
    exact, cached = frame_of(0.0, 1.0, 3.0), frame_of(0.5, 1.0, 1.5)
    assert aqvc_quality.bias(cached, exact) == pytest.approx(-0.25)
    assert aqvc_quality.stray_light(cached, exact) == pytest.approx(0.125)
    shining = Frame(layers={**cached.layers, "emitted": cached.layers["color"]})
    assert aqvc_quality.bias(shining, exact) == -1


def test_only_one_grid_for_all_normals_joins_the_sides_of_a_wall():
    shared = {row.what.split()[1]: row.measured for row in aqvc_quality.leaking_cells()}
    single = shared.pop("single:")
    assert single is not None and single > 0.9 and set(shared.values()) == {0.0}


@pytest.mark.stat
@pytest.mark.slow
def test_refinement_loses_thin_shadows_and_thin_light():
    """Majority filtering brightens below slats and darkens below slits."""
    for name, sign in (("slats", 1), ("slits", -1)):
        scene = getattr(vc.scenes, name)()
        found = aqvc_quality.biases(
            Shot(scene=scene, integrator=vc.Direct(), size=(160, 100)), "waves", 16
        )
        plain, refined = (found[v][0] for v in aqvc_quality.VARIANTS)
        assert abs(plain.mean) < 3 * plain.half
        assert sign * refined.mean > 1.5 * refined.half
