"""The same bytes for any number of threads, and other bytes where they should be others."""

from __future__ import annotations

import hashlib
from typing import Any

import numpy as np
import pytest

import viscache as vc
from render.mitsuba_scene import Look, Model, ball, box, quad

ROOM = Model(
    (
        box((-2, 0, -2), (2, 2.5, 2), look=Look(base_color=(0.7, 0.6, 0.5))).reversed(),
        box((-1, 0, -1), (-0.2, 1, -0.4), look=Look(kind="mirror", specular=(0.9, 0.9, 0.9))),
        ball((0.7, 0.5, 0.3), 0.5, look=Look(kind="dielectric")),
        box((0.2, 0, -1.4), (0.9, 0.7, -0.8), look=Look(kind="glossy", base_color=(0.3, 0.2, 0.1))),
        quad((-0.4, 2.4, -0.4), (0.8, 0, 0), (0, 0, 0.8), emission=(8, 8, 8)),
    ),
    points=(((1.5, 2, 1.5), (1, 1, 1)),),
    directions=(((0, 0.6, 0.8), (0.1, 0.1, 0.1)),),
    spheres=(((-1.5, 2, 0), 0.1, (9, 9, 9)),),
    env=(0.2, 0.2, 0.2),
    origin=(0, 1.2, 1.8),
)

INTEGRATORS = [
    vc.Direct(n_area=4, n_environment=2, n_brdf=2),
    vc.Whitted(n_vpls=24, n_area=4, n_environment=2, n_brdf=2),
    vc.AmbientOcclusion(n_samples=8, max_distance=0.5),
    vc.Bdpt(max_depth=4),
]


@pytest.fixture(scope="module")
def room() -> vc.Scene:
    return ROOM.to_viscache()


def signature(frame: vc.Frame) -> dict[str, Any]:
    layers = {n: hashlib.sha256(p.tobytes()).hexdigest() for n, p in frame.layers.items()}
    return {"layers": layers, "counters": frame.counters}


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=lambda i: type(i).__name__)
def test_any_number_of_threads_gives_the_same_bytes(integrator: Any, room: vc.Scene) -> None:
    """16 samples per pixel make tiles of 32 pixels: 8 tiles share the work."""
    frames = [
        vc.render(room, integrator, size=(97, 34), spp=16, seed=3, threads=n) for n in (1, 8, 3)
    ]
    assert frames[0].parameters["tile_edge_px"] <= 64
    assert frames[1].provenance["threads"] > 1
    for frame in frames[1:]:
        assert signature(frame) == signature(frames[0])


def test_sha256_is_that_of_the_pixels(room: vc.Scene) -> None:
    frame = vc.render(room, vc.Direct(), size=(16, 8))
    digest = hashlib.sha256(frame.image.astype("<f4").tobytes()).hexdigest()
    assert frame.counters["sha256"] == frame.sha256 == digest
    assert vc.render(room, vc.Direct(), size=(16, 8)).sha256 == digest
    assert vc.render(room, vc.Direct(), size=(16, 8), seed=1).sha256 != digest


def test_a_scene_built_again_gives_the_same_bytes(room: vc.Scene) -> None:
    again = ROOM.to_viscache()
    assert again.content_hash == room.content_hash
    a, b = (vc.render(s, INTEGRATORS[1], size=(24, 16)) for s in (room, again))
    assert signature(a) == signature(b)


def test_the_parts_add_up_to_the_image(room: vc.Scene) -> None:
    frame = vc.render(room, INTEGRATORS[1], size=(40, 30), spp=2)
    groups = ["emitted", "point", "directional", "area", "environment", "vpl"]
    total = sum(frame.layers[g].astype(np.float64) for g in groups)
    np.testing.assert_allclose(frame.image, total, rtol=1e-5, atol=1e-6)
    assert set(groups) < set(frame.layers)
    counters = frame.counters
    for name in ("queries", "rays", "occluded"):
        assert sum(g[name] for g in counters["groups"].values()) == counters[name]


def test_pixels_of_one_seed_share_no_samples() -> None:
    """Neighbours under one constant light differ, as do frames of other seeds."""
    plane = quad((-50, 0, -50), (0, 0, 100), (100, 0, 0))
    scene = Model(
        (plane,), env=(1, 1, 1), origin=(0, 5, 0), target=(0, 0, 0), up=(0, 0, 1)
    ).to_viscache()
    frames = [
        vc.render(scene, vc.Direct(n_brdf=0), size=(32, 32), seed=s).image[..., 0] for s in (0, 1)
    ]
    noise = [f.astype(float) - f.mean() for f in frames]
    assert noise[0].std() > 0.01
    for a, b in (
        (noise[0], noise[1]),
        (noise[0][:, 1:], noise[0][:, :-1]),
        (noise[0][1:], noise[0][:-1]),
    ):
        assert abs((a * b).mean() / noise[0].var()) < 5 / 32, "correlated"
