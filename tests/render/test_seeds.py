"""Pictures of different seeds have nothing in common, however close the seeds are."""

import numpy as np
import pytest

import viscache as vc
from render.test_progressive_oracles import HalfBlind
from viscache.shot.render import seed_of

SEEDS, PASSES = 20, 4
SIZE = (24, 16)
ROOM, LIGHTS = "room?triangles=3000", vc.Whitted(n_vpls=64)
HALF = {"visibility": HalfBlind(), "use": vc.Correct(share=0.25), "renew": 1}
VOXELS = {"visibility": vc.NeePlusPlus(n_voxels=4), "use": "replace", "renew": 1}
CASES = {
    "direct": (ROOM, vc.Direct(n_area=1), {}),
    "whitted": (ROOM, LIGHTS, {}),
    "renewed lights": (ROOM, LIGHTS, {"renew": 1}),
    "ambient occlusion": (ROOM, vc.AmbientOcclusion(n_samples=1), {}),
    "bdpt": ("cornell_box", vc.Bdpt(max_depth=3), {}),
    "corrections": (ROOM, LIGHTS, HALF),
    "roulette": (ROOM, LIGHTS, VOXELS),
}


def correlation_of_neighbours(pictures):
    """The mean correlation of the noise of one picture with that of the next.

    Each pixel counts by its standard deviation, so that a few bright ones do not decide. Residuals
    to the mean of n independent pictures have the correlation −1/(n−1), which is taken off.
    """
    stack = np.asarray(pictures, np.float64)
    deviation = stack.std(0)
    noise = (stack - stack.mean(0))[:, deviation > 0] / deviation[deviation > 0]
    return float((noise[1:] * noise[:-1]).mean() + 1 / (len(stack) - 1))


@pytest.mark.stat
@pytest.mark.parametrize("name", CASES)
def test_pictures_of_neighbouring_seeds_are_uncorrelated(name):
    spec, integrator, more = CASES[name]
    options = {"visibility": "exact", "size": SIZE, "threads": 1} | more
    scene = vc.scenes.build(spec)
    frames = [
        vc.Progressive(scene, integrator, seed=seed, **options).passes(PASSES).image
        for seed in range(SEEDS)
    ]
    assert abs(correlation_of_neighbours(frames)) <= 0.05
    shared = [np.mean(frames[i : i + PASSES], axis=0) for i in range(SEEDS - PASSES + 1)]
    assert correlation_of_neighbours(shared) > 0.5  # as where neighbours share passes


@pytest.mark.parametrize("name", CASES)
def test_the_first_pass_is_a_frame_of_the_seed(name):
    spec, integrator, more = CASES[name]
    options = {n: v for n, v in more.items() if n != "renew"}
    given = {"visibility": "exact", "size": SIZE, "seed": 5} | more
    first = vc.Progressive(spec, integrator, **given).passes(1)
    assert first.sha256 == vc.render(spec, integrator, size=SIZE, seed=5, **options).sha256
    assert first.parameters["seed"] == 5


def test_seeds_of_later_passes_are_seeds():
    made = [seed_of(s, p, n) for s in range(64) for p in ("pass", "lights") for n in range(1, 64)]
    assert len(set(made)) == len(made) and all(0 <= seed < 1 << 64 for seed in made)
    assert {seed_of(7, purpose, 0) for purpose in ("pass", "lights")} == {7}
    given = {"visibility": "exact", "size": (8, 8), "seed": (1 << 64) - 1}
    last = vc.Progressive("cornell_box", vc.Bdpt(max_depth=2), **given)
    assert last.passes(2).parameters["seed"] == (1 << 64) - 1
