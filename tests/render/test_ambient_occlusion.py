"""AmbientOcclusion: uniform or cosine directions, a distance at which looking ends."""

from dataclasses import replace

import numpy as np
import pytest

import viscache as vc
from render.mitsuba_scene import Look, Model, box, quad
from render.ztest import compare

PLANE = quad((-20, 0, -20), (0, 0, 40), (40, 0, 0))
WALL = quad((0, 0, -20), (0, 0, 40), (0, 20, 0))
CORNER = Model((PLANE, WALL), origin=(2, 1.5, 3), target=(0.5, 0, 0))

FIRST_HITS = ("depth", "normal", "albedo", "coverage")


def ambient(model, size=(32, 24), spp=1, **kwargs):
    """A frame without a limit of distance; of several `seeds`, a stack of images."""
    scene, seeds = model.to_viscache(), kwargs.pop("seeds", 1)
    integrator = vc.AmbientOcclusion(**{"max_distance": None, **kwargs})
    shots = [vc.render(scene, integrator, size=size, seed=s, spp=spp) for s in range(seeds)]
    return np.stack([s.image for s in shots]).astype(np.float64) if seeds > 1 else shots[0]


@pytest.mark.parametrize(("distribution", "noise"), [("cosine", 1e-6), ("uniform", 0.05)])
def test_an_open_plane_is_fully_lit_and_a_closed_room_dark(distribution, noise):
    """Uniform directions carry the cosine as a weight, whose mean is 1 but for noise."""
    plane = Model((PLANE,), origin=(0, 2, 0), target=(0, 0, 0), up=(0, 0, 1))
    image = ambient(plane, n_samples=64, distribution=distribution).image
    np.testing.assert_allclose(image, 1, atol=noise)
    walls = box((-1, -1, -1), (1, 1, 1)).reversed()
    room = Model((walls,), origin=(0.1, 0, 0), target=(1, 0.2, 0))
    assert not ambient(room, n_samples=16, distribution=distribution).image.any()


@pytest.mark.stat
def test_uniform_and_cosine_directions_have_one_expectation():
    a, b = (
        ambient(CORNER, seeds=8, spp=16, n_samples=16, distribution=d)
        for d in ("uniform", "cosine")
    )
    assert compare(a, b).same
    assert not compare(0.99 * a, b).same


@pytest.mark.parametrize("distribution", ["cosine", "uniform"])
def test_blockers_beyond_the_maximum_distance_do_not_count(distribution):
    ceiling = quad((-50, 1, -50), (100, 0, 0), (0, 0, 100))
    model = Model((PLANE, ceiling), origin=(0, 0.9, 0), target=(0, 0, 0), up=(0, 0, 1), fov_deg=10)

    def share(distance):
        frame = ambient(model, n_samples=256, distribution=distribution, max_distance=distance)
        return float(frame.image.mean())

    assert share(None) == share(float("inf")) < 1e-3, "None and inf are no limit"
    assert share(0.99) == pytest.approx(1, abs=0.02)
    assert share(1.01) < 1
    # A ray at angle t meets the ceiling after 1/cos t: cos t < 1/2 escapes, a share of 1/2²
    assert share(2.0) == pytest.approx(0.25, abs=0.02)
    assert share(1e9) < 1e-3


def test_mirrors_glass_black_and_one_sided_surfaces_are_surfaces_like_others():
    reference = ambient(CORNER).image
    for look in (
        Look(kind="mirror"),
        Look(kind="dielectric"),
        Look(base_color=(0, 0, 0)),
        Look(two_sided=False),
        Look(kind="glossy"),
    ):
        model = replace(CORNER, parts=tuple(replace(p, look=look) for p in CORNER.parts))
        np.testing.assert_array_equal(ambient(model).image, reference)


def test_each_sample_is_one_query_of_the_ambient_group():
    frame = ambient(CORNER, size=(10, 10), spp=2, n_samples=7)
    assert frame.counters["groups"].keys() == {"ambient"}
    assert 0 < frame.counters["queries"] <= 10 * 10 * 2 * 7
    assert frame.counters["queries"] == frame.counters["rays"]
    assert set(frame.layers) == {"color", "emitted", "ambient", *FIRST_HITS}


@pytest.mark.parametrize("own", [True, False], ids=["own directions", "shared directions"])
def test_by_default_a_tenth_of_the_scenes_diagonal_is_looked_at(own):
    scene = vc.scenes.room(triangles=5000)
    given = {} if own else {"n_samples": 129, "directions": "shared"}

    def frame(**more):
        return vc.render(scene, vc.AmbientOcclusion(**given, **more), size=(24, 16))

    diagonal = float(np.linalg.norm(scene.bounds[1].astype(float) - scene.bounds[0]))
    usual = frame()
    distance = usual.parameters["integrator"]["max_distance"]
    assert distance == pytest.approx(0.1 * diagonal)
    assert usual.sha256 == frame(max_distance=distance).sha256
    unlimited = frame(max_distance=None)
    assert unlimited.parameters["integrator"]["max_distance"] is None
    assert usual.image.mean() > 0.5 > 0.1 > unlimited.image.mean(), "closed rooms are not black"
