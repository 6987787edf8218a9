"""Sets of shared directions, which the eye points of a pixel ask in turns."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import viscache as vc
from viscache import _core

SETS = 8
SKY = vc.Direct(environment="shared", n_environment=128, interleave=SETS, n_area=0)
SIZE = (40, 30)


def gradient() -> Any:
    """A sky brighter on one side, with one bright patch."""
    rows, columns = np.mgrid[0:32, 0:64]
    sky = np.stack([1 + columns / 16, 2 - rows / 32, 0 * rows + 0.5], -1).astype(np.float32)
    sky[8:10, 20:23] = 30
    return sky


SPHERES = vc.scenes.bumpy_spheres(triangles=2000).with_environment(gradient())


def frame_of(integrator: Any = SKY, visibility: Any = None, **more: Any) -> vc.Frame:
    given: dict[str, Any] = {"size": SIZE, "spp": SETS} | more
    return vc.render(SPHERES, integrator, visibility=visibility, **given)


def light(frame: vc.Frame) -> Any:
    return np.asarray(frame.layers["environment"], np.float64)


def queries(frame: vc.Frame) -> int:
    return int(frame.counters["groups"]["environment"]["queries"])


def with_sets(n: int, sets: int, **more: Any) -> vc.Direct:
    return vc.Direct(environment="shared", n_environment=n, interleave=sets, n_area=0, **more)


SMALL: dict[str, Any] = {"size": (24, 18)}


@pytest.fixture(scope="module")
def energy() -> float:
    """Of samples of each eye point's own."""
    own = vc.Direct(n_environment=512, n_brdf=512, n_area=0)
    return float(light(frame_of(own, spp=16, **SMALL)).mean())


@pytest.mark.parametrize(
    ("integrator", "spp"),
    [(SKY, 1), (SKY, 3), (with_sets(100, 7), 2), (with_sets(256, 4, pick=8), 2)],
    ids=["one set", "three sets", "unequal sets", "picks in sets"],
)
def test_means_over_seeds_are_those_of_samples_of_each_points_own(
    integrator: vc.Direct, spp: int, energy: float
) -> None:
    """z-test over independent frames of the mean of the picture; the control is 5 % brighter."""
    frames = [frame_of(integrator, seed=s, spp=spp, **SMALL) for s in range(160)]
    means = np.array([light(frame).mean() for frame in frames])
    error = means.std(ddof=1) / np.sqrt(len(means))
    assert abs(means.mean() - energy) < 3.5 * error
    assert abs(1.05 * means.mean() - energy) > 3.5 * error


def test_each_eye_point_asks_its_share_of_the_directions() -> None:
    asked, all_asked = queries(frame_of()), queries(frame_of(with_sets(128, 1)))
    assert asked == pytest.approx(all_asked / SETS, rel=0.05)
    assert queries(frame_of(with_sets(256, SETS, pick=4))) < asked / 2


def test_a_pixel_with_as_many_samples_as_sets_asks_all_directions_once() -> None:
    """On an open plane under a constant sky, where no eye point differs from another."""
    quad = np.float32([[-9, 0, -9], [9, 0, -9], [9, 0, 9], [-9, 0, 9]])
    scene = vc.Scene.from_arrays(quad, [[0, 2, 1], [0, 3, 2]], env=1.0)
    camera = _core.look_at((0, 4, 0), (0, 0, 0.1), (0, 0, 1), 40)

    def values(sets: int, spp: int) -> Any:
        frame = vc.render(scene, with_sets(128, sets), size=(8, 8), spp=spp, camera=camera)
        return light(frame)[..., 0]

    whole = values(1, 1)
    np.testing.assert_allclose(values(SETS, SETS), whole, rtol=1e-5)
    np.testing.assert_allclose(values(SETS, 2 * SETS), whole, rtol=1e-5)
    assert np.abs(values(SETS, 1) / whole - 1).max() > 1e-3  # one set is not all of them


@pytest.mark.parametrize(("n", "sets"), [(100, 7), (130, 3), (300, 4)])
def test_unequal_sets_are_each_asked_by_one_eye_point_of_a_pixel(n: int, sets: int) -> None:
    """Sets end within words of bits and beyond them; rays through centres, so that all is equal."""

    def asked(integrator: vc.Direct, spp: int) -> int:
        return queries(frame_of(dataclasses.replace(integrator, centred=True), spp=spp))

    assert asked(with_sets(n, sets), sets) == asked(with_sets(n, 1), 1)
    assert asked(with_sets(n, sets), 1) < asked(with_sets(n, 1), 1) / 2


def test_frames_that_go_on_ask_the_next_sets() -> None:
    together = light(frame_of())
    apart = np.mean([light(frame_of(spp=1, first_sample=s)) for s in range(SETS)], axis=0)
    np.testing.assert_allclose(apart, together, rtol=1e-5, atol=1e-6)
    again = np.mean([light(frame_of(spp=1, seed=s)) for s in range(SETS)], axis=0)
    assert np.abs(again - together).max() > 0.01


def squared_error(integrator: vc.Direct, truth: Any) -> float:
    frames = [light(frame_of(integrator, seed=s)) for s in range(1, 5)]
    return float(np.mean([np.square(f - truth).mean() for f in frames]))


def test_sets_have_a_smaller_error_than_the_same_directions_for_all() -> None:
    """As many rays: eight sets of sixteen directions, or sixteen for all eye points."""
    truth = light(frame_of(vc.Direct(n_environment=64, n_brdf=64, n_area=0), spp=64, seed=99))
    few = squared_error(with_sets(16, 1), truth)
    assert squared_error(SKY, truth) < few / 4
    # It is the number of directions that helps: sixteen in four sets have no such gain
    assert squared_error(with_sets(16, 4), truth) > few / 4


@pytest.mark.parametrize(
    "visibility",
    [
        lambda: vc.Exact(order="by_light"),
        lambda: vc.Exact(order="by_pixel"),
        lambda: vc.Exact(sky_engine="auto"),
        lambda: vc.Aqvc(c_e=1e-3),
    ],
    ids=["by light", "by pixel", "auto", "cache with small cells"],
)
def test_every_way_to_the_exact_answer_gives_the_same_bytes(
    visibility: Callable[[], Any],
) -> None:
    base = frame_of(threads=1, size=(90, 70))
    other = frame_of(visibility=visibility(), threads=3, size=(90, 70))
    np.testing.assert_array_equal(other.layers["environment"], base.layers["environment"])


def test_the_aligned_batch_answers_but_for_rounding() -> None:
    base, batch = (frame_of(visibility=vc.Exact(sky_engine=e)) for e in ("embree", "batch"))
    assert queries(base) == queries(batch) == batch.parameters["engine"]["batch_rays"]
    assert (light(base) != light(batch)).any(-1).mean() < 5e-3


def test_the_cache_answers_sets_too() -> None:
    """With fewer rays, at a small error."""
    exact, cached = (frame_of(visibility=v, size=(160, 120)) for v in (vc.Exact(), vc.Aqvc(c_e=8)))
    assert cached.counters["ray_reduction"] > 1.2
    assert vc.metrics.rel_l1(cached.image, exact.image) < 0.03


def test_whitted_and_passes_take_sets() -> None:
    both = vc.Whitted(environment="shared", n_environment=64, interleave=4, n_vpls=8, n_area=0)
    passes = vc.Progressive(SPHERES, both, visibility=vc.Exact(), size=SIZE)
    together = light(frame_of(both, spp=4))
    np.testing.assert_allclose(light(passes.passes(4)), together, rtol=1e-5, atol=1e-6)
