"""Ambient occlusion from records: Eq. 12, closed forms, distance to exact rays."""

import numpy as np
import pytest

import viscache as vc
from core import testing
from correlation.scenes import above, unpacked
from reference import vismap_records as reference
from render.mitsuba_scene import Model, box, quad
from vismap.scenes import SIZE, clutter, made, pixels, view

WEIGHT = 4  # the verdict: no record weighs enough
PLANE = quad((-20, 0, -20), (0, 0, 40), (40, 0, 0))


def shaded(model, size=(32, 24), **settings):
    scene = model.to_viscache()
    return vc.cached_ambient_occlusion(
        scene, size=size, settings=vc.MapSettings(**({"n_startup": 100} | settings))
    )


def test_ambient_visibility_is_the_papers_integral():
    cache, _ = made(criterion="ambient")
    r = cache.records()
    free = unpacked(r.bits, 1024)
    cosine = np.maximum(0, r.normals.astype(float) @ cache.directions.T.astype(float))
    expected = (free * cosine).sum(1) * (4 * np.pi / 1024) / np.pi
    np.testing.assert_allclose(r.ambient, expected, atol=1e-5)
    one = testing.ambient_visibility(r.bits[3], 5, cache.directions, r.normals[3].tolist())
    assert one == r.ambient[3]
    assert not np.allclose(r.ambient, 1.01 * expected, atol=1e-5)


def test_the_pattern_integrates_the_cosine_of_any_plane():
    random = np.random.default_rng(0)
    n = random.normal(size=(500, 3))
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    for m, tolerance in ((4, 0.02), (5, 0.006), (6, 0.003)):
        pattern = testing.record_pattern(m, 0)
        integral = np.maximum(0, n @ pattern.T).sum(1) * 4 / 4**m
        assert np.abs(integral - 1).max() < tolerance


def test_nearest_hits_are_those_of_the_records_rays():
    cache, _ = made(criterion="ambient", n_startup=30)
    r = cache.records()
    for i in range(0, len(cache), 5):
        up = cache.directions[above(r.normals[i : i + 1], cache.directions)[0]]
        size = max(np.abs(r.positions[i]).max(), cache.scene._core.offset_extent)
        origin = r.positions[i] + r.normals[i] * np.float32(8 * 2.0**-23) * np.float32(size)
        hits = cache.scene.intersect(np.tile(origin, (len(up), 1)), up)
        # Not nearer than a pixel is wide
        assert r.nearest_hit[i] == hits.t.min() or r.nearest_hit[i] > hits.t.min() > 0
        assert r.nearest_hit[i] >= hits.t.min()
    assert np.isfinite(r.nearest_hit).any()


def test_an_open_plane_is_fully_lit_and_a_closed_room_dark():
    plane = shaded(Model((PLANE,), origin=(0, 2, 0), target=(0, 0, 0), up=(0, 0, 1)))
    np.testing.assert_allclose(plane.image, 1, atol=0.02)
    room = shaded(
        Model((box((-1, -1, -1), (1, 1, 1)).reversed(),), origin=(0.1, 0, 0), target=(1, 0.2, 0))
    )
    assert not room.image.any() and room.counters["without_record"] == 0


def test_at_the_edge_of_two_walls_half_of_the_sky_is_left():
    """At distance x from a wall of height h the share is (1 + x/√(x² + h²))/2."""
    wall = quad((0, 0, -200), (0, 0, 400), (0, 1, 0))
    model = Model((quad((-200, 0, -200), (0, 0, 400), (400, 0, 0)), wall))
    scene = model.to_viscache()
    cache = vc.VisibilityMapCache(scene, vc.MapSettings(criterion="ambient", n_startup=4))
    for x in (0.002, 0.1, 0.5, 1.0, 3.0):
        eye = vc.look_at((x, 0.001, 0), (x, 0, 0), (0, 0, 1), 0.5)
        frame = vc.cached_ambient_occlusion(scene, cache=cache, camera=eye, size=(1, 1))
        assert frame.image[0, 0, 0] == pytest.approx((1 + x / np.hypot(x, 1)) / 2, abs=0.02)


def test_under_a_disc_the_form_factor_is_missing():
    """A disc of radius r at height h above a point hides r²/(r² + h²)."""
    t = np.linspace(0, 2 * np.pi, 129)
    for r, h in ((1.0, 1.0), (0.5, 1.0), (2.0, 0.5)):
        rim = np.stack([r * np.cos(t), np.full_like(t, h), r * np.sin(t)], 1)
        ground = [[-9, 0, -9], [9, 0, -9], [9, 0, 9], [-9, 0, 9]]
        vertices = np.concatenate([[[0, h, 0]], rim, ground])
        fan = [[0, i + 1, i + 2] for i in range(128)]
        scene = vc.Scene.from_arrays(vertices, [*fan, [130, 132, 131], [130, 133, 132]])
        eye = vc.look_at((1e-3, 0.1, 0), (0, 0, 0), (0, 0, 1), 0.5)
        frame = vc.cached_ambient_occlusion(scene, camera=eye, size=(1, 1))
        assert frame.image[0, 0, 0] == pytest.approx(1 - r**2 / (r**2 + h**2), abs=0.02)


def test_shading_is_the_gaussian_mean_of_the_nearest_records():
    cache, _ = made(criterion="ambient", m_nearest=64)
    points = cache._pixels(view(), *SIZE, (0.5, 0.5), 1)[0]
    r = cache.records()
    for weighted in (False, True):
        value, count, jump = cache._core.shade_ambient(points, 0.25, weighted)
        compared = 0
        for i in np.flatnonzero(points.d_max > 0)[::11]:
            w = reference.full_weights(
                points.positions[i].astype(float),
                points.normals[i],
                r.positions,
                r.normals,
                float(points.d_max[i]),
                np.radians(30),
            )
            near = np.flatnonzero(~np.isnan(w))
            if len(near) >= 64:
                assert jump[i] > 0
                continue
            d = np.linalg.norm(r.positions[near] - points.positions[i], axis=1) / points.d_max[i]
            g = np.exp(-(d**2) / (2 * 0.25**2)) * (w[near] if weighted else 1)
            assert count[i] == len(near) and jump[i] == 0
            assert value[i] == pytest.approx((g * r.ambient[near]).sum() / g.sum(), abs=1e-4)
            compared += 1
        assert compared > 50


def test_near_hits_shorten_the_reach_of_a_record_as_the_paper_says():
    cache, _ = made(criterion="ambient", m_nearest=64, n_startup=200)
    points, r = pixels(cache), cache.records()
    judged = cache._core.select(points)
    w_min, compared = cache.thresholds[0], 0
    for i in np.flatnonzero(points.d_max > 0)[::5]:
        x = points.positions[i].astype(float)
        d_max = float(points.d_max[i])
        w = reference.full_weights(
            x, points.normals[i], r.positions, r.normals, d_max, np.radians(30)
        )
        if (~np.isnan(w)).sum() > 60:  # of more, only the nearest are looked at
            continue
        d = np.linalg.norm(r.positions - x, axis=1)
        expected = reference.ambient_test(w, d, r.nearest_hit)
        assert judged["tested"][i] == pytest.approx(expected, abs=2e-5)
        assert (judged["verdict"][i] == WEIGHT) == (
            judged["candidates"][i] > 0 and expected < w_min
        )
        compared += 0.05 < expected < reference.ambient_test(w, d, 2 * r.nearest_hit) - 0.01
    assert compared > 50, "with twice the nearest hits these weights would be others"


@pytest.mark.stat
def test_images_come_close_to_exact_ones_with_fewer_rays():
    scene, eye = clutter(), view()
    settings = vc.MapSettings(d_max=0.1, w_min=0.5)
    frame = vc.cached_ambient_occlusion(scene, settings=settings, camera=eye, size=(96, 64), spp=4)
    exact = vc.render(
        scene,
        vc.AmbientOcclusion(n_samples=256, max_distance=None),
        camera=eye,
        size=(96, 64),
        spp=4,
    ).image[:, :, :1]
    error = frame.image * frame.layers["coverage"] - exact
    assert np.sqrt((error**2).mean()) < 0.04 and abs(error.mean()) < 0.01
    assert frame.counters["rays_per_point"] < 100 and frame.counters["without_record"] == 0
    # Not just any smooth picture: the exact one's structure is there
    there = frame.layers["coverage"] == 1
    assert np.corrcoef(frame.image[there], exact[there])[0, 1] > 0.9


def test_the_points_are_those_of_the_exact_render():
    scene, eye = clutter(), view()
    exact_ao = vc.AmbientOcclusion(n_samples=1, max_distance=None)
    for seed in (0, 7):
        shot = {"camera": eye, "size": SIZE, "spp": 3, "seed": seed}
        frame = vc.cached_ambient_occlusion(scene, **shot)
        exact = vc.render(scene, exact_ao, **shot)
        np.testing.assert_array_equal(frame.layers["coverage"], exact.layers["coverage"])
        assert 0 < frame.layers["coverage"].mean() < 1


def test_frames_are_the_same_for_any_number_of_threads_and_the_second_costs_no_ray():
    cache, _ = made(criterion="ambient")
    frames = [
        vc.cached_ambient_occlusion(clutter(), camera=view(), size=SIZE, spp=4, threads=t)
        for t in (1, 3)
    ]
    frames += [
        vc.cached_ambient_occlusion(cache.scene, cache=cache, camera=view(), size=SIZE)
        for _ in range(2)
    ]
    assert frames[0].sha256 == frames[1].sha256 and frames[2].sha256 == frames[3].sha256
    assert frames[0].counters == frames[1].counters and frames[3].counters["rays"] == 0


def test_wrong_uses_are_refused():
    cache, _ = made()
    other, _ = made(clutter(1), criterion="ambient")
    for scene, given, says in (
        (cache.scene, {"cache": cache}, 'criterion must be "ambient"'),
        (cache.scene, {"cache": other}, "cache must be of the scene"),
        (cache.scene, {"spp": 0}, r"spp must be in \[1, 2\^20\], got 0"),
        (cache.scene, {"width": 0.0, "size": SIZE}, r"width must be in \(0, 1e6\]"),
        (
            other.scene,
            {"cache": other, "settings": vc.MapSettings()},
            "settings must be left out with a cache",
        ),
    ):
        with pytest.raises(ValueError, match=says):
            vc.cached_ambient_occlusion(scene, **given)  # type: ignore[arg-type]
