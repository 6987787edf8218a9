"""use="correct": any cache as a control variate."""

import numpy as np
import pytest

import viscache as vc
from oracles.test_written import Grid, Half
from reference.built import built
from viscache.oracles.correct import Correct

SIZE = (48, 32)
ROOM = "room?triangles=3000"


@pytest.mark.parametrize(
    ("integrator", "visibility"),
    [
        (vc.Whitted(n_vpls=64), vc.Aqvc(c_e=12)),
        (vc.Whitted(n_vpls=64), vc.Aqvc(preset="fast", c_e=12)),
        (vc.Direct(n_area=4), vc.Aqvc(c_e=12, preset="paper")),
        (vc.Direct(n_area=4), vc.ShadowMap(resolution=32)),
        (vc.AmbientOcclusion(n_samples=8, max_distance=1.0), vc.Aqvc(c_e=12)),
        (vc.Bdpt(max_depth=3), vc.Aqvc(c_e=12)),
        (vc.Direct(), vc.Exact()),
        (vc.Direct(), vc.Unoccluded()),
        (vc.Whitted(n_vpls=64, pick=4), vc.Unoccluded()),
        (vc.Whitted(n_vpls=40), Grid(cell=0.5)),
        (vc.Whitted(n_vpls=40), Half()),
    ],
    ids=[
        *("waves", "fast", "paper", "shadow maps", "own samples", "bdpt", "exact"),
        *("unoccluded", "picks", "own", "own, with weights"),
    ],
)
def test_a_share_of_one_is_the_exact_frame_byte_for_byte(integrator, visibility):
    scene = built(ROOM)
    given = {"size": SIZE, "spp": 2}
    exact = vc.render(scene, integrator, **given)
    given["visibility"] = visibility
    right = vc.render(scene, integrator, use=vc.Correct(share=1), **given)
    assert right.sha256 == exact.sha256
    assert (right.counters["corrections"] > 0) is not isinstance(visibility, vc.Exact)
    if not isinstance(visibility, vc.Exact):
        cached = vc.render(scene, integrator, **given)
        assert cached.sha256 != exact.sha256
        assert right.counters["wrong"] > 0


def test_bytes_do_not_depend_on_threads_and_counters_estimate_the_errors():
    scene, light = built(ROOM), vc.Whitted(n_vpls=64)
    cache = vc.Aqvc(c_e=12, exact_groups=("area", "environment"))
    given = {"visibility": cache, "rays": vc.Bsp(), "use": vc.Correct(share=0.2)}
    frames = [vc.render(scene, light, size=SIZE, threads=n, **given) for n in (1, 3)]
    assert frames[0].sha256 == frames[1].sha256
    use = {"name": "correct", "share": 0.2, "certain": "auto", "classes": "learned"}
    assert frames[0].parameters["use"] == use
    counters = frames[0].counters
    conn = vc.connections(scene, light, size=SIZE, rays=vc.Bsp())
    cached, exact = conn.answers(cache), conn.answers(vc.Exact())
    wrong = sum(
        np.bitwise_count(cached[g].bits ^ exact[g].bits).sum()  # type: ignore[union-attr]
        for g in conn.groups
    )
    share = counters["wrong"] / counters["corrections"]
    expected = wrong / counters["queries"]
    spread = np.sqrt(expected * (1 - expected) / counters["corrections"])
    assert abs(share - expected) < 4 * spread
    assert counters["corrections"] == pytest.approx(0.2 * counters["queries"], rel=0.02)


def test_correct_is_the_default_share():
    scene = built(ROOM)
    options = {"size": SIZE, "visibility": vc.Aqvc(c_e=12)}
    word = vc.render(scene, vc.Direct(), use="correct", **options)
    assert word.sha256 == vc.render(scene, vc.Direct(), use=Correct(), **options).sha256


@pytest.mark.parametrize(
    ("options", "says"),
    [({"share": share}, "share must be") for share in (0, -0.1, 1.1, float("nan"))]
    + [({"certain": 0}, "certain must be > 0 and finite, got 0"), ({"classes": "own"}, "classes")],
)
def test_bad_settings_are_refused(options, says):
    with pytest.raises(ValueError, match=says):
        vc.Correct(**options)


@pytest.mark.parametrize(
    ("integrator", "options", "says"),
    [
        (vc.Direct(), {"visibility": vc.VisMaps(), "use": vc.Correct()}, "with visibility maps"),
        (vc.Direct(environment="product"), {"use": "correct", "env": 1.0}, "product"),
        (vc.AmbientOcclusion(n_samples=33, directions="shared"), {"use": "correct"}, "shared"),
        (vc.Direct(), {"use": "repair"}, "use must be"),
    ],
)
def test_what_does_not_combine_is_refused(integrator, options, says):
    with pytest.raises(ValueError, match=says):
        vc.render(built(ROOM), integrator, size=SIZE, **options)
