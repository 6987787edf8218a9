"""Directions that all eye points share, or those of a pixel in turns: the light of any engine."""

import dataclasses

import numpy as np
import pytest

import viscache as vc
from render.skies import gradient, light, with_sets
from viscache import _core

SETS = 8
WHOLE, SKY = with_sets(128, 1), with_sets(128, SETS)
SPHERES = vc.scenes.bumpy_spheres(triangles=2000).with_environment(gradient())
#: The same for means over many seeds.
SMALL = {"size": (24, 18)}


def frame_of(integrator=SKY, visibility=None, scene=SPHERES, **more):
    given = {"size": (40, 30), "spp": SETS} | more
    return vc.render(scene, integrator, visibility=visibility, **given)


def by(engine):
    return vc.Exact(sky_engine=engine)


def queries(frame):
    return int(frame.counters["groups"]["environment"]["queries"])


@pytest.fixture(scope="module")
def energy():
    """Of samples of each eye point's own."""
    own = vc.Direct(n_environment=512, n_brdf=512, n_area=0)
    return float(light(frame_of(own, spp=16, **SMALL)).mean())


@pytest.mark.parametrize(
    ("integrator", "spp", "power"),
    [
        (WHOLE, 1, 0.02),
        (SKY, 1, 0.05),
        (SKY, 3, 0.05),
        (with_sets(100, 7), 2, 0.05),
        (with_sets(256, 4, pick=8), 2, 0.05),
    ],
    ids=["no sets", "one set", "three sets", "unequal sets", "picks in sets"],
)
def test_means_over_seeds_are_those_of_samples_of_each_points_own(integrator, spp, power, energy):
    """z-test over independent frames of the mean of the picture, and its power."""
    frames = [frame_of(integrator, seed=s, spp=spp, **SMALL) for s in range(160)]
    means = np.array([light(frame).mean() for frame in frames])
    error = means.std(ddof=1) / np.sqrt(len(means))
    assert abs(means.mean() - energy) < 3.5 * error
    assert abs((1 + power) * means.mean() - energy) > 3.5 * error


def test_a_pixel_with_as_many_samples_as_sets_asks_all_directions_once():
    """On an open plane under a constant sky, where no eye point differs from another."""
    quad = np.float32([[-9, 0, -9], [9, 0, -9], [9, 0, 9], [-9, 0, 9]])
    scene = vc.Scene.from_arrays(quad, [[0, 2, 1], [0, 3, 2]], env=1.0)
    camera = _core.look_at((0, 4, 0), (0, 0, 0.1), (0, 0, 1), 40)

    def values(sets, spp):
        at = {"size": (8, 8), "spp": spp, "camera": camera}
        return light(vc.render(scene, with_sets(128, sets), **at))[..., 0]

    whole = values(1, 1)
    assert whole.max() == whole.min() == pytest.approx(0.5, rel=0.03)
    np.testing.assert_allclose(values(SETS, SETS), whole, rtol=1e-5)
    np.testing.assert_allclose(values(SETS, 2 * SETS), whole, rtol=1e-5)
    assert np.abs(values(SETS, 1) / whole - 1).max() > 1e-3  # one set is not all of them


def test_each_eye_point_asks_its_share_of_the_directions():
    asked, all_asked = queries(frame_of()), queries(frame_of(WHOLE))
    assert asked == pytest.approx(all_asked / SETS, rel=0.05)
    assert queries(frame_of(with_sets(256, SETS, pick=4))) < asked / 2


@pytest.mark.parametrize(("n", "sets"), [(100, 7), (130, 3), (300, 4)])
def test_unequal_sets_are_each_asked_by_one_eye_point_of_a_pixel(n, sets):
    """Sets end within words of bits and beyond them; rays through centres, so that all is equal."""

    def asked(integrator, spp):
        return queries(frame_of(dataclasses.replace(integrator, centred=True), spp=spp))

    assert asked(with_sets(n, sets), sets) == asked(with_sets(n, 1), 1)
    assert asked(with_sets(n, sets), 1) < asked(with_sets(n, 1), 1) / 2


def squared_error(integrator, truth):
    frames = [light(frame_of(integrator, seed=s)) for s in range(1, 5)]
    return float(np.mean([np.square(f - truth).mean() for f in frames]))


def test_sets_have_a_smaller_error_than_the_same_directions_for_all():
    """As many rays: eight sets of sixteen directions, or sixteen for all eye points."""
    truth = light(frame_of(vc.Direct(n_environment=64, n_brdf=64, n_area=0), spp=64, seed=99))
    few = squared_error(with_sets(16, 1), truth)
    assert squared_error(SKY, truth) < few / 4
    # It is the number of directions that helps: sixteen in four sets have no such gain
    assert squared_error(with_sets(16, 4), truth) > few / 4


@pytest.mark.parametrize(
    ("integrator", "visibility"),
    [
        (SKY, vc.Exact(order="by_light")),
        (SKY, vc.Exact(order="by_pixel")),
        (SKY, by("auto")),
        (SKY, vc.Aqvc(c_e=1e-3)),
        (WHOLE, vc.Aqvc(c_e=1e-3)),
    ],
    ids=["by light", "by pixel", "auto", "small cells", "small cells, no sets"],
)
def test_every_way_to_the_exact_answer_gives_the_same_bytes(integrator, visibility):
    base = frame_of(integrator, threads=1, size=(90, 70))
    other = frame_of(integrator, visibility, threads=3, size=(90, 70))
    np.testing.assert_array_equal(other.layers["environment"], base.layers["environment"])


@pytest.mark.parametrize("integrator", [WHOLE, SKY], ids=["no sets", "sets"])
def test_the_cache_answers_them_with_fewer_rays_at_a_small_error(integrator):
    exact, cached = (frame_of(integrator, v, size=(160, 120)) for v in (vc.Exact(), vc.Aqvc(c_e=8)))
    assert cached.counters["ray_reduction"] > 1.2
    assert vc.metrics.rel_l1(cached.image, exact.image) < 0.03


@pytest.mark.parametrize(
    ("scene", "integrator"),
    [(SPHERES, WHOLE), (SPHERES, SKY), (vc.scenes.courtyard(triangles=8000), WHOLE)],
    ids=["spheres", "sets", "masks"],
)
def test_engines_agree_but_for_rounding(scene, integrator):
    given = {"scene": scene, "size": (64, 48), "spp": 2, "env": gradient()}
    base, batch = (frame_of(integrator, by(engine), **given) for engine in ("embree", "batch"))
    assert "engine" not in base.parameters
    engine = batch.parameters["engine"]
    assert engine["name"] == "batch" and engine["batch_rays"] == engine["direction_rays"] > 0
    groups = base.counters["groups"], batch.counters["groups"]
    assert all(a["rays"] == b["rays"] for a, b in zip(*(g.values() for g in groups), strict=True))
    unlike = abs(groups[0]["environment"]["occluded"] - groups[1]["environment"]["occluded"])
    assert unlike <= 2e-5 * groups[0]["environment"]["rays"] + 2
    assert (base.image != batch.image).any(-1).mean() < 5e-3
    assert np.abs(base.image - batch.image).mean() < 1e-4 * base.image.mean()


def test_the_engine_is_chosen_by_predicted_cost():
    """Few points before many triangles go to Embree, a frame of points before few to the batch."""

    def asked(triangles, edge):
        scene = vc.scenes.bumpy_spheres(triangles=triangles)
        given = {"size": (edge, edge), "spp": 1, "env": gradient()}
        return frame_of(WHOLE, by("auto"), scene, **given).parameters["engine"]

    few = asked(100_000, 40)
    assert few["name"] == "embree" and few["batch_rays"] == 0
    medium = asked(50_000, 100)
    assert medium["batch_ns"] > 0.9 * medium["embree_ns"] > 0 and medium["name"] == "embree"
    if _core.active_isa() == "avx512":
        many = asked(2000, 512)
        assert many["batch_rays"] > 0.9 * many["direction_rays"]
        assert many["batch_ns"] < 0.9 * many["embree_ns"]


def test_directional_lights_and_whitted_go_the_same_way():
    d = _core.description_of(SPHERES._core)
    r = np.random.default_rng(0).normal(size=(20, 3))
    for w in r / np.linalg.norm(r, axis=1, keepdims=True):
        d.add_directional_light(tuple(w), (1.0, 1.0, 1.0))
    scene = vc.Scene.from_description(d)
    both = vc.Whitted(environment="shared", n_vpls=16, n_environment=64)
    given = {"scene": scene, "size": (64, 48), "spp": 1, "env": gradient()}
    base, batch = (frame_of(both, by(e), **given) for e in ("embree", "batch"))
    for group in ("directional", "environment"):
        assert (base.layers[group] != batch.layers[group]).any(-1).mean() < 5e-3
    np.testing.assert_array_equal(base.layers["vpl"], batch.layers["vpl"])
    rays = [base.counters["groups"][group]["rays"] for group in ("directional", "environment")]
    assert batch.parameters["engine"]["batch_rays"] == sum(rays)


def test_whitted_and_passes_take_sets():
    both = vc.Whitted(environment="shared", n_environment=64, interleave=4, n_vpls=8, n_area=0)
    passes = vc.Progressive(SPHERES, both, visibility=vc.Exact(), size=(40, 30))
    together = light(frame_of(both, spp=4))
    np.testing.assert_allclose(light(passes.passes(4)), together, rtol=1e-5, atol=1e-6)


def test_without_shared_directions_nothing_is_chosen_or_built():
    scene = vc.scenes.bumpy_spheres(triangles=500)
    frame = frame_of(vc.Direct(n_environment=4, n_brdf=4), by("batch"), scene, env=gradient())
    assert "engine" not in frame.parameters and "aligned_batch" not in scene._made
