"""Connections far above the mean of their eye point get a ray of their own."""

import numpy as np
import pytest

import viscache as vc
from aqvc import tiles
from reference.built import built


@pytest.mark.parametrize("kind", ["point", "directional", "vpl"])
def test_bright_connections_have_the_answers_of_rays_and_others_do_not_change(kind):
    eyes, far = tiles.eye_points(), tiles.lights(kind, 12)
    wanted = tiles.facing(eyes, far)
    f = np.random.default_rng(4).integers(1, 1000, wanted.shape).astype(np.float32) * wanted
    bright = wanted & (f > 1.5 * f.sum(1, keepdims=True) / np.maximum(wanted.sum(1), 1)[:, None])
    assert 0.05 < bright.sum() / wanted.sum() < 0.5
    plain, few = tiles.tile_run(eyes, c_e=24).block(far, wanted, contribution=f)
    run = tiles.tile_run(eyes, c_e=24, bright=1.5)
    exact, _ = run.block(far, wanted, exact=True)
    visible, more = run.block(far, wanted, contribution=f)
    assert (plain != exact)[bright].any()
    np.testing.assert_array_equal(visible[bright], exact[bright])
    np.testing.assert_array_equal(visible[~bright], plain[~bright])
    assert more["rays"] == few["rays"] + bright.sum()
    # Arrays without contributions have no bright connections
    np.testing.assert_array_equal(run.block(far, wanted)[0], plain)


def test_a_bound_near_zero_is_the_exact_frame():
    scene, light = built("room?triangles=3000"), vc.Whitted(n_vpls=32)
    size = (48, 32)

    def frame(bright):
        cache = vc.Aqvc(c_e=24, exact_groups=("area", "environment"), bright=bright)
        return vc.render(scene, light, visibility=cache, size=size)

    exact = vc.render(scene, light, size=size)
    assert frame(1e-6).sha256 == exact.sha256
    errors = [float(np.abs(frame(b).image - exact.image).sum()) for b in (0, 4, 1)]
    assert errors[0] > errors[1] > errors[2] > 0
