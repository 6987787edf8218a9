"""The garage: lit from outside by its environment alone, most of which the building hides."""

from functools import cache

import numpy as np
import pytest

import viscache as vc
from viscache import scenes
from viscache.scenes.garage import (
    DEPTH,
    GATE,
    HEIGHT,
    LAMPS,
    LENGTH,
    ROOF_LIGHT_Z,
    ROOF_LIGHTS,
    SUN,
    WINDOW_Y,
    WINDOWS,
)
from viscache.scenes.sky import sky_with
from viscache_lab.cases.light_product import blocked_share


@cache
def garage():
    return scenes.garage()


def above(wall_height):
    """A floor with a wall in the plane x = 0, both huge, under a white sky."""
    s = 200.0
    vertices = [[-s, 0, -s], [-s, 0, s], [s, 0, s], [s, 0, -s],
                [0, 0, -s], [0, wall_height, -s], [0, wall_height, s], [0, 0, s]]  # fmt: skip
    triangles = [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]]
    return vc.Scene.from_arrays(vertices, triangles, env=np.ones((32, 64, 3)))


DOWN = vc.look_at((0.5, 1, 0), (0.5, 0, 0), up=(0, 0, 1), fov_deg=20)


def test_all_light_is_in_the_environment():
    assert [light["kind"] for light in garage().lights] == ["environment"]
    assert garage().triangles == 350_058


def test_nearly_all_light_comes_from_the_sun_and_the_lamps():
    lit, dark = (sky_with(discs, 224).astype(float) for discs in ((SUN, *LAMPS), ()))
    area = np.sin((np.arange(224) + 0.5) / 224 * np.pi)[:, None, None]
    share = 1 - (dark * area).sum() / (lit * area).sum()
    assert 0.6 < share < 0.95
    size = ((lit != dark).any(2)[..., None] * area).sum() / (area * np.ones((1, 448, 1))).sum()
    assert size < 0.01, "of all directions"


def test_light_enters_only_by_the_gate_the_windows_and_the_roof_lights():
    rng = np.random.default_rng(3)
    origins = rng.uniform((0.3, 0.2, 0.3), (LENGTH - 0.3, HEIGHT - 0.5, DEPTH - 0.3), (100_000, 3))
    towards = rng.normal(size=origins.shape)
    free = ~garage().occluded(origins, towards)
    o, d = origins[free], towards[free]
    assert 0.02 < free.mean() < 0.2

    def crossing(axis, at):
        """Where rays cross a plane, and whether they do ahead of them."""
        t = (at - o[:, axis]) / d[:, axis]
        return o + t[:, None] * d, t > 0

    def between(values, low, high):
        return (values > low) & (values < high)

    p, ahead = crossing(0, LENGTH)
    gate = ahead & (p[:, 1] < GATE[2]) & between(p[:, 2], *GATE[:2])
    p, ahead = crossing(2, DEPTH)
    window = ahead & between(p[:, 1], *WINDOW_Y)
    window &= np.any([between(p[:, 0], *across) for across in WINDOWS], axis=0)
    p, ahead = crossing(1, HEIGHT)
    roof = ahead & between(p[:, 2], *ROOF_LIGHT_Z)
    roof &= np.any([between(p[:, 0], *across) for across in ROOF_LIGHTS], axis=0)
    assert (gate | window | roof).all()
    assert gate.any() and window.any() and roof.any()


def test_the_share_of_blocked_samples_is_what_geometry_says():
    options = {"camera": DOWN, "size": (6, 4), "samples": 512}
    np.testing.assert_array_equal(blocked_share(above(1e-3), **options), 0)
    np.testing.assert_allclose(blocked_share(above(200.0), **options), 0.5, atol=0.02)


@pytest.mark.slow
def test_most_light_product_samples_are_blocked_as_recorded():
    """The facts of docs/scenes.md, with fewer pixels and samples."""
    share = blocked_share(garage(), size=(32, 24), samples=64)
    seen = share[np.isfinite(share)]
    assert seen.size > 0.9 * share.size
    quartiles = np.quantile(seen, (0.25, 0.5, 0.75))
    np.testing.assert_allclose(quartiles, (0.664, 0.910, 0.992), atol=0.03)


def test_the_picture_is_not_black():
    frame = vc.render(garage(), vc.Direct(n_environment=64), size=(80, 60))
    light = frame.image.mean(2)
    assert np.median(light) > 0.02 * np.quantile(light, 0.99)


def test_scenes_lit_otherwise_are_refused():
    with pytest.raises(ValueError, match="lit by its environment alone, got"):
        blocked_share(scenes.cornell_box(), size=(6, 4), samples=1)
