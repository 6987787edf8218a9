"""Bidirectional path tracing against Mitsuba 3's `path`: z-tests, each with its power."""

from dataclasses import replace

import numpy as np
import pytest

import viscache as vc
from render import bdpt_scenes as scenes
from render.mitsuba_frames import assert_same, theirs
from render.test_mitsuba import smooth_map
from render.ztest import compare

pytestmark = [pytest.mark.mitsuba, pytest.mark.stat]

SIZE = (24, 16)


def frames(model, depth, spp, seeds, **kwargs):
    scene, integrator = model.to_viscache(), vc.Bdpt(max_depth=depth, **kwargs)
    made = [vc.render(scene, integrator, size=SIZE, spp=spp, seed=i) for i in range(seeds)]
    assert all(f.counters["non_finite"] == 0 for f in made)
    return made


def stack(made, without=""):
    """Images, or images that lack one kind of strategy."""
    lack = [f.layers[without] if without else np.float32(0) for f in made]
    return np.stack([f.image - x for f, x in zip(made, lack, strict=True)]).astype(np.float64)


@pytest.mark.slow
def test_a_closed_room_is_mitsubas_by_all_strategies_together(mi, tmp_path):
    """Whatever strategy is left out or counted twice, as by a wrong weight, is missed."""
    reference = theirs(mi, scenes.ROOM.to_mitsuba(mi, SIZE, tmp_path), depth=5, spp=25)
    made = frames(scenes.ROOM, 5, 40, 32)
    assert_same(stack(made), reference)
    for layer in ("emitted", "area", "connection", "camera"):
        assert not compare(stack(made, layer), reference).same, layer
        twice = 2 * stack(made) - stack(made, layer)
        assert not compare(twice, reference).same, layer
    shallow = stack(frames(scenes.ROOM, 4, 80, 4))
    assert not compare(shallow, reference).same, "the last bounce is not seen"


@pytest.mark.slow
@pytest.mark.parametrize("camera", ["bypass", pytest.param("off", marks=pytest.mark.release)])
@pytest.mark.parametrize(
    ("model", "depth"),
    [
        pytest.param(scenes.CAUSTICS, 7, id="caustics"),
        pytest.param(scenes.PLATES, 6, id="thin plate", marks=pytest.mark.release),
        pytest.param(scenes.GLOSSY, 5, id="glossy", marks=pytest.mark.release),
        pytest.param(scenes.SMOOTH, 5, id="interpolated normals", marks=pytest.mark.release),
        pytest.param(scenes.OPEN, 5, id="point, sun and sky"),
    ],
)
def test_many_bounces_are_mitsubas(model, depth, camera, mi, tmp_path):
    reference = theirs(mi, model.to_mitsuba(mi, SIZE, tmp_path), depth=depth, spp=64)
    spp = 64 if model is scenes.PLATES else 32  # of 32, 1 % of the energy is not seen
    made = frames(model, depth, spp, 64, camera_connections=camera)
    assert_same(stack(made), reference)


@pytest.mark.slow
def test_a_smooth_environment_map_is_mitsubas(mi, tmp_path):
    """The camera looks down: the map's texels, which we resample, are seen by their light alone."""
    model = replace(
        scenes.OUTSIDE, env=smooth_map(), origin=(0.5, 3.5, 2.0), target=(0, 0, 0), fov_deg=30
    )
    reference = theirs(mi, model.to_mitsuba(mi, SIZE, tmp_path), depth=5, spp=64)
    made = frames(model, 5, 64, 64)
    assert_same(stack(made), reference)
    for layer in ("emitted", "environment", "connection", "camera"):
        assert not compare(stack(made, layer), reference).same, layer
