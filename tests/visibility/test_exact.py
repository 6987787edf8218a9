"""The exact oracle: packet order and coherence never change a byte; what it counts."""

from dataclasses import replace

import pytest

import viscache as vc
from render.test_ambient_occlusion import FIRST_HITS
from render.test_determinism import ROOM


@pytest.fixture(scope="module")
def room():
    return ROOM.to_viscache()


INTEGRATORS = [
    vc.Direct(n_area=4, n_environment=2, n_brdf=2),
    vc.Whitted(n_vpls=100, n_area=4, n_environment=2, n_brdf=2),
    vc.Whitted(n_vpls=64, n_area=0, pick=6),
    vc.AmbientOcclusion(n_samples=5, max_distance=0.7),
]


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=["direct", "whitted", "picks", "ambient"])
@pytest.mark.parametrize("size", [(67, 41), (1, 1), (130, 3)])
def test_packet_order_and_coherence_change_no_byte(integrator, size, room):
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


def test_a_group_that_the_scene_lacks_is_neither_counted_nor_stored():
    bare = replace(ROOM, directions=(), spheres=(), env=None, parts=ROOM.parts[:4]).to_viscache()
    frame = vc.render(bare, vc.Direct(), size=(16, 16))
    assert frame.counters["groups"].keys() == {"point"}
    assert set(frame.layers) == {"color", "emitted", "point", *FIRST_HITS}
