"""The exact oracle: packet order and coherence never change a byte; what it counts."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import viscache as vc
from render.test_ambient_occlusion import FIRST_HITS
from render.test_determinism import ROOM


@pytest.fixture(scope="module")
def room() -> vc.Scene:
    return ROOM.to_viscache()


INTEGRATORS = [
    vc.Direct(n_area=4, n_environment=2, n_brdf=2),
    vc.Whitted(n_vpls=100, n_area=4, n_environment=2, n_brdf=2),
    vc.Whitted(n_vpls=64, n_area=0, pick=6),
    vc.AmbientOcclusion(n_samples=5, max_distance=0.7),
]


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=["direct", "whitted", "picks", "ambient"])
@pytest.mark.parametrize("size", [(67, 41), (1, 1), (130, 3)])
def test_packet_order_and_coherence_change_no_byte(
    integrator: Any, size: tuple[int, int], room: vc.Scene
) -> None:
    settings = [vc.Exact()] if size != (67, 41) else [vc.Exact(), vc.Exact(engine="shafts")]
    settings += [
        vc.Exact(order=o, coherent=c, engine="packets")
        for o in ("by_light", "by_pixel")
        for c in (True, False)
    ]
    if not isinstance(integrator, vc.Whitted):
        settings = [s for s in settings if s.engine != "shafts"]
    frames = [vc.render(room, integrator, size=size, visibility=v, seed=5) for v in settings]
    for frame in frames[1:]:
        assert frame.sha256 == frames[0].sha256
        assert frame.counters == frames[0].counters


def test_every_query_costs_one_ray(room: vc.Scene) -> None:
    counters = vc.render(room, INTEGRATORS[1], size=(64, 48)).counters
    assert counters["rays"] == counters["queries"] > 64 * 48
    assert counters["ray_reduction"] == 1
    assert 0 < counters["occluded"] < counters["queries"]
    assert counters["groups"].keys() == {"point", "directional", "area", "environment", "vpl"}
    assert counters["camera_rays"] >= 64 * 48
    assert (
        counters["bypassed"]
        == counters["non_finite"]
        == counters["lookups"]
        == counters["cells"]
        == 0
    )
    assert counters["vpls"] <= 100


def test_a_group_that_the_scene_lacks_is_neither_counted_nor_stored() -> None:
    from dataclasses import replace

    bare = replace(ROOM, directions=(), spheres=(), env=None, parts=ROOM.parts[:4]).to_viscache()
    frame = vc.render(bare, vc.Direct(), size=(16, 16))
    assert frame.counters["groups"].keys() == {"point"}
    assert set(frame.layers) == {"color", "emitted", "point", *FIRST_HITS}


def test_frames_see_what_visible_sees() -> None:
    """The mask of one point light, pixel by pixel, asked again through scene.visible."""
    from render.mitsuba_scene import Model, box, quad

    light = (0.5, 1.4, 0.6)
    parts = (quad((-3, 0, -3), (0, 0, 6), (6, 0, 0)), box((-0.4, 0.3, -0.4), (0.2, 0.8, 0.3)))
    model = Model(
        parts,
        points=((light, (1, 1, 1)),),
        origin=(0, 3, 0),
        target=(0, 0, 0),
        up=(0, 0, 1),
        fov_deg=40,
    )
    scene = model.to_viscache()
    frame = vc.render(scene, vc.Direct(), size=(64, 64))
    # Pixels whose four corners agree need no knowledge of where in the pixel the sample lies
    half = np.tan(np.radians(20))
    view = scene.cameras[0]
    at = np.linspace(-half, half, 65)
    x, y = np.meshgrid(at, -at)
    direction = np.array(view.forward) + x[..., None] * view.right + y[..., None] * view.up
    origin = np.broadcast_to(view.origin, direction.shape).reshape(-1, 3)
    hit = scene.intersect(origin, direction.reshape(-1, 3))
    points = origin + hit.t[:, None] * direction.reshape(-1, 3) * (1 - 1e-6)
    seen = scene.visible(points, np.broadcast_to(light, points.shape)).reshape(65, 65)
    corners = np.stack([seen[:-1, :-1], seen[1:, :-1], seen[:-1, 1:], seen[1:, 1:]])
    lit, dark = corners.all(0), ~corners.any(0)
    assert lit.sum() > 500 and dark.sum() > 100
    mask = frame.image[..., 0] > 0
    assert mask[lit].mean() > 0.999 and mask[dark].mean() < 0.001
