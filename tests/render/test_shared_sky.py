"""Light from directions all eye points share: right on average, the same by every engine."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import viscache as vc
from viscache import _core

SKY = vc.Direct(environment="shared", n_environment=128, n_area=0)
SPHERES = vc.scenes.bumpy_spheres(triangles=2000)


def gradient() -> Any:
    """A sky brighter on one side."""
    rows, columns = np.mgrid[0:32, 0:64]
    return np.stack([1 + columns / 16, 2 - rows / 32, 0 * rows + 0.5], -1).astype(np.float32)


def frame_of(
    scene: vc.Scene = SPHERES, engine: Any = "embree", integrator: Any = SKY, **m: Any
) -> Any:
    more: dict[str, Any] = {"size": (64, 48), "env": gradient()} | m
    return vc.render(scene, integrator, visibility=vc.Exact(sky_engine=engine), **more)


def test_means_over_seeds_are_those_of_samples_of_each_points_own() -> None:
    """z-test over independent frames of mean pixel values; the control is 2 % brighter."""
    common: dict[str, Any] = {"size": (24, 18)}
    shared = np.array(
        [frame_of(seed=s, **common).layers["environment"].mean((0, 1)) for s in range(64)]
    )
    truth = (
        frame_of(integrator=vc.Direct(n_environment=512, n_brdf=512, n_area=0), **common, spp=4)
        .layers["environment"]
        .mean((0, 1))
    )
    error = shared.std(0, ddof=1) / np.sqrt(len(shared))
    assert (np.abs(shared.mean(0) - truth) < 3.5 * error).all()
    assert (error < 0.004 * truth).all()
    assert (np.abs(1.02 * shared.mean(0) - truth) > 3.5 * error).all()


def test_an_open_plane_under_a_constant_sky_has_no_noise_between_pixels() -> None:
    quad = np.float32([[-9, 0, -9], [9, 0, -9], [9, 0, 9], [-9, 0, 9]])
    scene = vc.Scene.from_arrays(quad, [[0, 2, 1], [0, 3, 2]], env=1.0)
    image = vc.render(
        scene, SKY, size=(16, 16), camera=_core.look_at((0, 4, 0), (0, 0, 0.1), (0, 0, 1), 40)
    )
    values = image.layers["environment"][..., 0]
    assert values.max() == values.min() == pytest.approx(0.5, rel=0.03)


@pytest.mark.parametrize(
    "scene", [SPHERES, vc.scenes.courtyard(triangles=8000)], ids=["spheres", "masks"]
)
def test_engines_agree_but_for_rounding(scene: vc.Scene) -> None:
    base, batch = (frame_of(scene, engine, spp=2) for engine in ("embree", "batch"))
    assert (
        base.sha256 == frame_of(scene, spp=2, threads=1).sha256 and "engine" not in base.parameters
    )
    engine = batch.parameters["engine"]
    assert engine["name"] == "batch" and engine["batch_rays"] == engine["direction_rays"] > 0
    groups = base.counters["groups"], batch.counters["groups"]
    assert all(a["rays"] == b["rays"] for a, b in zip(*(g.values() for g in groups), strict=True))
    unlike = abs(groups[0]["environment"]["occluded"] - groups[1]["environment"]["occluded"])
    assert unlike <= 2e-5 * groups[0]["environment"]["rays"] + 2
    assert (base.image != batch.image).any(-1).mean() < 5e-3
    assert np.abs(base.image - batch.image).mean() < 1e-4 * base.image.mean()


@pytest.mark.parametrize("engine", ["batch", "auto"])
def test_threads_change_no_byte(engine: str) -> None:
    base = frame_of(engine=engine, threads=1, size=(150, 140), spp=4)
    for threads in (2, 5):
        again = frame_of(engine=engine, threads=threads, size=(150, 140), spp=4)
        assert again.sha256 == base.sha256 and again.counters == base.counters
        assert again.parameters["engine"] == base.parameters["engine"]


def test_the_engine_is_chosen_by_predicted_cost() -> None:
    """Few points before many triangles go to Embree, a frame of points before few to the batch."""
    large = vc.scenes.bumpy_spheres(triangles=100_000)
    few = frame_of(large, "auto", size=(40, 40)).parameters["engine"]
    assert few["name"] == "embree" and few["batch_rays"] == 0
    medium = vc.scenes.bumpy_spheres(triangles=50_000)
    asked = frame_of(medium, "auto", size=(100, 100)).parameters["engine"]
    assert asked["batch_ns"] > 0.9 * asked["embree_ns"] > 0 and asked["name"] == "embree"
    if _core.active_isa() == "avx512":
        many = frame_of(engine="auto", size=(512, 512)).parameters["engine"]
        assert many["batch_rays"] > 0.9 * many["direction_rays"]
        assert many["batch_ns"] < 0.9 * many["embree_ns"]


def test_directional_lights_and_whitted_go_the_same_way() -> None:
    d = _core.description_of(SPHERES._core)
    r = np.random.default_rng(0).normal(size=(20, 3))
    for w in r / np.linalg.norm(r, axis=1, keepdims=True):
        d.add_directional_light(tuple(w), (1.0, 1.0, 1.0))
    scene = vc.Scene.from_description(d)
    both = vc.Whitted(environment="shared", n_vpls=16, n_environment=64)
    base, batch = (frame_of(scene, e, both) for e in ("embree", "batch"))
    assert (base.layers["directional"] != batch.layers["directional"]).any(-1).mean() < 5e-3
    assert (base.layers["environment"] != batch.layers["environment"]).any(-1).mean() < 5e-3
    np.testing.assert_array_equal(base.layers["vpl"], batch.layers["vpl"])
    rays = base.counters["groups"]
    assert batch.parameters["engine"]["batch_rays"] == (
        rays["directional"]["rays"] + rays["environment"]["rays"]
    )


def test_the_quantized_cache_with_small_cells_gives_the_exact_sky() -> None:
    """Fixed sky directions are a shared group of the cache too (level waves)."""
    exact = frame_of(size=(40, 30))
    cached = vc.render(SPHERES, SKY, visibility=vc.Aqvc(c_e=1e-3), size=(40, 30), env=gradient())
    np.testing.assert_array_equal(cached.layers["environment"], exact.layers["environment"])
    coarse = vc.render(SPHERES, SKY, visibility=vc.Aqvc(c_e=8), size=(160, 120), env=gradient())
    assert coarse.counters["ray_reduction"] > 1.2


def test_without_shared_directions_nothing_is_chosen_or_built() -> None:
    scene = vc.scenes.bumpy_spheres(triangles=500)
    frame = frame_of(scene, "batch", vc.Direct(n_environment=4, n_brdf=4))
    assert "engine" not in frame.parameters and "aligned_batch" not in scene._made


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"rays": vc.Bsp()}, r'rays must be vc.Embree\(\) with sky_engine="batch"'),
        ({"integrator": vc.AmbientOcclusion()}, "integrator must be .* with sky_engine"),
        ({"integrator": vc.Bdpt()}, "integrator must be .* with sky_engine"),
        ({"visibility": vc.VisMaps()}, 'environment must not be "shared" with visibility maps'),
        ({"integrator": vc.Direct(environment="shared", passes=2)}, "passes must be 1"),
    ],
)
def test_what_does_not_fit_is_refused(arguments: dict[str, Any], message: str) -> None:
    given: dict[str, Any] = {"integrator": SKY, "visibility": vc.Exact(sky_engine="batch")}
    with pytest.raises(ValueError, match=message):
        vc.render(SPHERES, **(given | arguments), size=(8, 8))
