"""Aligned rays by look-up: Embree's bits except for rounding, and when "auto" chooses them."""

import numpy as np
import pytest

import viscache as vc
from reference.built import built
from render.test_interrupt import LIMIT, quickest_stop
from viscache import _core
from viscache.vlf import aligned
from vlf.aligned_scenes import embree, frames_of, surface, unexcused, unpacked


def by_field(scene, settings, points, normals, **more):
    field = scene.caster(settings)
    frames = frames_of(field.settings.n_directions)
    return unpacked(_core.vlf.field_rows(field, points, normals, frames, **more), len(frames))


@pytest.mark.parametrize(
    "spec", ["bumpy_spheres?triangles=3000", "random_triangles?triangles=3000"]
)
@pytest.mark.parametrize("t_max", [np.inf, 0.5])
def test_no_ray_differs_from_embrees_without_an_excuse(spec, t_max):
    scene, frames = built(spec), frames_of(33)
    points, normals = surface(scene, 3000)
    theirs = embree(scene, points, normals, frames, t_max=t_max)
    for settings in (
        vc.Vlf(n_directions=33, n_tiles=24),
        vc.Vlf(n_directions=33, n_tiles=9, bsp_depth=0),
    ):
        ours = by_field(scene, settings, points, normals, t_max=t_max)
        differing, bad = unexcused(scene, points, normals, frames, ours, theirs, t_max)
        assert bad == 0 and differing <= 1e-5 * ours.size + 3
    assert 0.02 < ours.mean() < 0.98


def test_neither_threads_nor_laziness_change_a_bit():
    scene = vc.scenes.bumpy_spheres(triangles=2000)
    points, normals = surface(scene, 1500)
    plain = vc.Vlf(n_directions=33, n_tiles=16)
    lazy = vc.Vlf(n_directions=33, n_tiles=16, lazy=True, max_bytes=400_000)
    base = by_field(scene, plain, points, normals, threads=1)
    for threads in (2, 5):
        for settings in (plain, lazy):
            again = by_field(scene, settings, points, normals, threads=threads)
            np.testing.assert_array_equal(again, base)
    assert by_field(scene, lazy, points[:0], normals[:0]).shape == (0, 33)


def test_rows_of_a_field_given_or_built():
    scene = vc.scenes.bumpy_spheres(triangles=2000)
    points, normals = surface(scene, 500)
    field = vc.VisibilityField(scene, n_directions=33, n_tiles=16)
    given = vc.vlf.trace_aligned(scene, points, normals, 33, engine="field", field=field)
    built = vc.vlf.trace_aligned(scene, points, normals, 33, engine="field")
    assert given.engine == built.engine == "field" and given.reason == "asked for"
    np.testing.assert_array_equal(given.bits, built.bits)
    for wrong in (
        vc.VisibilityField(scene, n_directions=9, n_tiles=4),
        vc.VisibilityField(vc.scenes.cube_on_plane(), n_directions=33, n_tiles=4),
        vc.VisibilityField(scene, settings=vc.Vlf(n_directions=33, n_tiles=4, snap=True)),
    ):
        with pytest.raises(ValueError, match="field must be of the scene, of 33 directions"):
            vc.vlf.trace_aligned(scene, points, normals, 33, engine="field", field=wrong)
    with pytest.raises(ValueError, match="the field must have the directions asked for, it has 33"):
        _core.vlf.field_rows(field._core, points, normals, frames_of(9))


def test_the_reason_says_what_the_field_would_cost():
    """Too expensive without a field, by a lower bound, and with a built one, by its tests."""
    scene = vc.scenes.bumpy_spheres(triangles=2000)
    points, normals = surface(scene, 3000)
    rows = vc.vlf.trace_aligned(scene, points, normals, 33)
    assert rows.engine != "field" and ", field over " in rows.reason
    field = vc.VisibilityField(scene, n_directions=33, n_tiles=16)
    rows = vc.vlf.trace_aligned(scene, points, normals, 33, field=field)
    assert rows.engine != "field" and "tests, built already)" in rows.reason


def test_the_field_is_chosen_where_it_is_predicted_to_be_cheapest(monkeypatch):
    """With expensive alternatives: by prediction, including time and memory of the build."""
    scene = vc.scenes.bumpy_spheres(triangles=2000)
    points, normals = surface(scene, 6000)
    monkeypatch.setattr(aligned, "FIELD_MARGIN", 40.0)
    rows = vc.vlf.trace_aligned(scene, points, normals, 33)
    assert rows.engine == "field" and " s to build)" in rows.reason
    asked = vc.vlf.trace_aligned(scene, points, normals, 33, engine="field")
    np.testing.assert_array_equal(rows.bits, asked.bits)
    few = vc.vlf.trace_aligned(scene, points[:60], normals[:60], 33)
    assert few.engine != "field"  # too few rays to repay the building
    monkeypatch.setattr(vc.vlf.aligned, "Vlf", lambda **k: vc.Vlf(**k, max_bytes=10_000))
    tight = vc.vlf.trace_aligned(scene, points, normals, 33)
    assert tight.engine != "field" and "but over" in tight.reason


def test_predictions_follow_tiles_and_triangles():
    scenes = [vc.scenes.bumpy_spheres(triangles=n)._core for n in (2000, 20_000)]

    def cost(scene, n_tiles):
        settings = vc.Vlf(n_directions=33, n_tiles=n_tiles).core()
        return dict(_core.vlf.predict_field_rows(scene, settings))

    coarse, fine, many = cost(scenes[0], 16), cost(scenes[0], 64), cost(scenes[1], 16)
    for more, less in ((coarse, fine), (many, coarse)):
        assert more["tests"] > less["tests"] and more["ray_ns"] > less["ray_ns"]
    for more, less in ((fine, coarse), (many, coarse)):
        assert more["bytes"] > less["bytes"] and more["build_s"] > less["build_s"]
    field = vc.VisibilityField(vc.scenes.bumpy_spheres(triangles=2000), 33, 64)
    assert 0.5 * field.stats["bytes"] < fine["bytes"] < field.stats["bytes"]


def test_frames_of_ambient_occlusion_by_a_field():
    scene = vc.scenes.bumpy_spheres(triangles=2000)

    def frame_by(engine):
        shared = vc.AmbientOcclusion(
            n_samples=33, max_distance=None, directions="shared", engine=engine
        )
        return vc.render(scene, shared, size=(48, 36))

    frames = {engine: frame_by(engine) for engine in ("embree", "field")}
    assert frames["field"].parameters["engine"]["name"] == "field"
    assert frames["field"].counters["rays"] == frames["embree"].counters["rays"]
    assert np.abs(frames["field"].image - frames["embree"].image).mean() < 1e-4


@pytest.mark.slow
def test_ctrl_c_stops_the_look_ups_soon():
    call = (
        "(lambda at: vc.aligned_occlusion(scene, at.positions, at.normals, 129, engine='field'))"
        "(vc.correlation.surface_points(scene, 1 << 17))"
    )
    assert quickest_stop(call, 1.5) < LIMIT
