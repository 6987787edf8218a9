"""Ambient occlusion along shared directions: the right shares, whoever traces them."""

import numpy as np
import pytest

import viscache as vc
from core import testing
from correlation.scenes import clutter, convex
from render.test_interrupt import LIMIT, quickest_stop
from vlf.aligned_scenes import surface, unpacked

SHARED = vc.AmbientOcclusion(n_samples=129, max_distance=None, directions="shared")


def shared(n=129, **more):
    return vc.AmbientOcclusion(n_samples=n, directions="shared", **{"max_distance": None, **more})


@pytest.mark.parametrize("n", [1, 9, 129, 513])
def test_a_share_is_the_weighted_mean_of_its_bits(n):
    scene = clutter()
    points, normals = surface(scene, 200)
    bits = vc.aligned_occlusion(scene, points, normals, n)
    weight = np.abs(normals.astype(float) @ vc.vlf.directions(n).T) * vc.vlf.direction_weights(n)
    expected = (weight * unpacked(bits, n)).sum(1) / weight.sum(1)
    np.testing.assert_allclose(testing.free_share(n, normals, bits), expected, atol=1e-5)


def test_a_convex_body_is_lit_fully():
    frame = vc.render(convex(), SHARED, size=(64, 64))
    seen = frame.layers["coverage"][..., 0] == 1
    np.testing.assert_allclose(frame.image[seen], 1, atol=1e-5)
    assert frame.counters["occluded"] == 0 and seen.any()


def test_it_agrees_with_directions_of_each_points_own():
    """513 shared directions have no noise; the mean is within what their number leaves."""
    scene = vc.scenes.bumpy_spheres(triangles=3000)
    one = vc.render(scene, shared(513), size=(64, 64), spp=4)
    other = vc.render(
        scene, vc.AmbientOcclusion(n_samples=1024, max_distance=None), size=(64, 64), spp=4
    )
    assert abs(one.image.mean() / other.image.mean() - 1) < 5e-3
    assert np.sqrt(np.mean((one.image - other.image) ** 2)) < 0.02
    np.testing.assert_array_equal(one.layers["depth"], other.layers["depth"])


@pytest.mark.parametrize("max_distance", [None, 0.2])
def test_engines_agree(max_distance):
    scene = vc.scenes.bumpy_spheres(triangles=5000)
    engines = ("batch", "embree")
    batch, embree = (
        vc.render(scene, shared(engine=e, max_distance=max_distance), size=(80, 60), spp=2)
        for e in engines
    )
    assert batch.parameters["engine"]["name"] == "batch"
    assert embree.parameters["engine"]["name"] == "embree"
    assert np.abs(embree.image - batch.image).max() < 0.02
    assert np.abs(embree.image - batch.image).mean() < 1e-5
    rays = batch.counters["rays"]
    assert rays == batch.counters["queries"] and rays % 129 == 0
    assert batch.counters["groups"]["ambient"]["rays"] == rays
    assert 0 < batch.counters["occluded"] < rays


@pytest.mark.slow
def test_ctrl_c_stops_the_frame_soon():
    call = (
        "vc.render(scene, vc.AmbientOcclusion(n_samples=8193, directions='shared', "
        "engine='batch'), size=(512, 512))"
    )
    assert quickest_stop(call, 1.0) < LIMIT


def test_rows_of_another_length_are_refused():
    with pytest.raises(ValueError, match=r"rows must have shape \(1, 3\), got \(1, 1\)"):
        testing.free_share(129, [[0, 0, 1.0]], np.zeros((1, 1), np.uint64))


def test_an_empty_view_is_black():
    d = vc.SceneDescription()
    d.add_camera((0, 0, 0), (0, 0, 1), up=(0, 1, 0), fov_deg=30)
    frame = vc.render(vc.Scene.from_description(d), SHARED, size=(8, 8))
    assert not frame.image.any() and frame.counters["rays"] == 0
